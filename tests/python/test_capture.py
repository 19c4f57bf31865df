"""The capture in Python: set-ups and plans, diffuse light, many lights, cameras from landmarks, maps onto the blade."""

from __future__ import annotations

import time
from pathlib import Path
from threading import Event

import numpy as np
import pytest
import togishi_core as core
from blade_outline import against_the_light

WIDTH, HEIGHT = 32, 6
# A flat plate under two distant boxes: every pixel sees them as the plan's middle does, within the noise.
SETUP = f"""format = 1
scale = 1.0
[noise]
snr = 400.0
read = 1e-4
bits = 16
[camera]
kind = "orthographic"
width_px = {WIDTH}
height_px = {HEIGHT}
scale_px_per_mm = 8.0
position_mm = [0.0, 0.0, 0.0]
right = [-1.0, 0.0, 0.0]
down = [0.0, 0.0, -1.0]
[surface]
kind = "plate"
size_mm = [8.0, 4.0]
[[photograph]]
file = "one.tif"
[photograph.source]
kind = "rectangle"
centre_mm = [0.0, 2000.0, 260.0]
half_u_mm = [800.0, 0.0, 0.0]
half_v_mm = [0.0, 0.0, 200.0]
[[photograph]]
file = "two.tif"
[photograph.source]
kind = "rectangle"
centre_mm = [0.0, 2000.0, 480.0]
half_u_mm = [800.0, 0.0, 0.0]
half_v_mm = [0.0, 0.0, 300.0]
"""


def setup(tmp_path: Path, text: str = SETUP) -> core.CaptureSetup:
    path = tmp_path / "setup é.toml"
    path.write_text(text, encoding="utf-8")
    return core.read_capture_setup(str(path))


def plates(plan: dict, mu_deg: np.ndarray) -> dict[str, np.ndarray]:
    """What the two photographs show of a surface all ji with these half widths."""
    return {
        name: np.interp(np.log(mu_deg), np.log(plan["mu_deg"]), curve["radiance"])
        for name, curve in zip(("one.tif", "two.tif"), plan["photographs"], strict=True)
    }


def test_a_set_up_says_what_it_holds(tmp_path):
    s = setup(tmp_path)
    assert s.surface == "plate" and s.camera_fit is None and s.landmarks == []
    assert s.camera["scale"] == 8.0 and s.camera["right"] == (-1.0, 0.0, 0.0)
    assert [Path(file).name for file in s.files] == ["one.tif", "two.tif"]
    again = core.parse_capture_setup(s.to_toml(), s.file)
    assert again.to_toml() == s.to_toml()
    with pytest.raises(core.InputError, match=r"setup é\.toml.*kind"):
        setup(tmp_path, SETUP.replace("orthographic", "fisheye"))


def test_diffuse_light_finds_the_half_width_again(tmp_path):
    s = setup(tmp_path)
    plan = core.capture_diffuse_plan(s, {"material": "sashikomi_katana"})
    assert not plan["blind"] and plan["sentences"] and plan["picture"].shape == (760, 1200, 3)
    assert len(plan["photographs"]) == 2 and plan["photographs"][0]["flat_at_deg"] is not None
    prior = core.load_material("sashikomi_katana")["parts"]["ji"]
    middle = np.sqrt(prior["mu_t_deg"] * prior["mu_b_deg"])
    truth = middle * np.exp(np.linspace(-0.2, 0.2, WIDTH))
    pictures = plates(plan, np.broadcast_to(truth, (HEIGHT, WIDTH)))
    pictures["one.tif"][3, 5] = 1.0  # at full scale
    asked, shares = [], []

    def read(path: str):
        asked.append(Path(path).name)
        return pictures[Path(path).name].astype(np.float32), True

    found = core.capture_diffuse(s, read, {"spread": 0.3}, progress=shares.append)
    assert asked == ["one.tif", "two.tif"]
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1.0)
    # Maps run upwards, what is said of pixels downwards.
    w, ln_mu = found["maps"]["w"][::-1], found["maps"]["ji.ln_mu_deg"][::-1]
    mask = found["quality"]["mask"]
    assert mask[3, 5] & 2 and not found["usable"][3, 5]
    assert found["masked"]["clipped"] == 1 and found["seen"] == WIDTH * HEIGHT
    told = found["usable"] & (mask == 0)
    assert told.mean() > 0.3
    assert np.median(w[told]) < 0.05
    error = np.abs(np.expm1(ln_mu - np.log(truth)))[told]
    assert np.median(error) < 0.05
    assert found["mu_measured"] and "measured: 2 photographs" in found["source"]
    assert found["pictures"]["w"].shape == found["pictures"]["mu"].shape


def test_diffuse_light_refuses_and_stops(tmp_path):
    s = setup(tmp_path)
    flat = np.full((HEIGHT, WIDTH, 1), 0.1, np.float32)
    with pytest.raises(InterruptedError):
        core.capture_diffuse(s, lambda _path: (flat, True), progress=lambda _share: False)
    with pytest.raises(ZeroDivisionError):
        core.capture_diffuse(s, lambda _path: 1 / 0)
    with pytest.raises(core.InputError, match=r"one\.tif"):
        core.capture_diffuse(s, lambda _path: flat)
    with pytest.raises(core.InputError, match=r"one\.tif.*size.*5 x 5"):
        core.capture_diffuse(s, lambda _path: (np.zeros((5, 5)), False))
    with pytest.raises(core.InputError, match=r"capture diffuse.*'sigma'.*hadori"):
        core.capture_diffuse(s, lambda _path: (flat, True), {"sigma": 1})
    even = SETUP[: SETUP.index("[[photograph]]")] + (
        '[[photograph]]\nfile = "one.tif"\n[photograph.source]\nkind = "hemisphere"\naxis = [0.0, 1.0, 0.0]\n'
    )
    # Under an even hemisphere every polish looks alike.
    assert core.capture_diffuse_plan(setup(tmp_path, even))["w_share"] == 0.0


class Stack:
    """Pictures of one flat lobe of 8 degrees, as capture_lights reads them."""

    step, fingerprint = 0.0, "test"

    def __init__(self, lights: np.ndarray, height: int, width: int, mu_deg: float) -> None:
        self.width, self.height = width, height
        half = np.add(lights, [0.0, 0.0, 1.0])
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        angle = np.degrees(np.arccos(np.clip(half[:, 2], -1, 1)))
        self.signal = 0.8 * np.exp(-np.log(2) * (angle / mu_deg) ** 2)
        self.fail: int | None = None

    def read(self, picture: int, begin: int, end: int) -> np.ndarray:
        if picture == self.fail:
            raise OSError(f"picture {picture} is cut off")
        return np.full((end - begin, self.width), self.signal[picture], np.float32)


def light_file(tmp_path: Path, name: str = "stack.lp", count: int = 30) -> tuple[Path, np.ndarray]:
    angle = 2.399963 * np.arange(count)
    zenith = np.radians(4 + 44 * np.sqrt((np.arange(count) + 0.5) / count))
    lights = np.stack(
        [np.sin(zenith) * np.cos(angle), np.sin(zenith) * np.sin(angle), np.cos(zenith)], -1
    )
    lines = [str(count)]
    for i, light in enumerate(lights):
        (tmp_path / f"{i}.tif").touch()
        lines.append(f"{i}.tif " + " ".join(f"{v:.9f}" for v in light))
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n")
    return path, lights


def test_many_lights_plan_run_and_resume(tmp_path):
    path, lights = light_file(tmp_path)
    plan = core.capture_lights_plan(str(path))
    assert plan["lights"] == 30 and len(plan["pictures"]) == 30
    assert plan["mu_sure_deg"] == pytest.approx(0.65 * plan["spacing_deg"])
    assert "30 lights" in plan["sentence"]
    bracketed = core.capture_lights_plan(str(path), {"brackets": [(str(path), 0.25)]})
    assert len(bracketed["pictures"]) == 60
    stack = Stack(lights, 150, 70, 8.0)
    target = tmp_path / "map.exr"
    options = {"band_rows": 64, "light_error_deg": 0.2}
    asked = Event()

    def stop(_share: float) -> bool:
        asked.set()
        return False

    def read_when_asked(picture: int, begin: int, end: int) -> np.ndarray:
        assert asked.wait(30.0)
        time.sleep(0.02)
        return Stack.read(stack, picture, begin, end)

    stack.read = read_when_asked
    with pytest.raises(InterruptedError, match="bands are kept"):
        core.capture_lights(str(path), stack, str(target), options, progress=stop)
    del stack.read
    shares: list[float] = []
    tiles = core.capture_lights(str(path), stack, str(target), options, progress=shares.append)
    assert (tiles.width, tiles.height, tiles.bands) == (70, 150, 3)
    assert shares and all(0 <= share <= 1 for share in shares)
    rows = np.concatenate([tiles.read(band) for band in range(tiles.bands)])
    assert rows.shape == (150, 70, len(core.CAPTURE_CHANNELS))
    ln_mu = rows[..., core.CAPTURE_CHANNELS.index("lobe.ln_mu_deg")]
    assert np.exp(np.median(ln_mu)) == pytest.approx(8.0, rel=0.1)
    found = tiles.property_maps()
    flags = rows[..., core.CAPTURE_CHANNELS.index("flags")].astype(int)
    assert (found["usable"] == (flags == 0)).all()
    assert np.array_equal(found["maps"]["ji.ln_mu_deg"], found["maps"]["ha.ln_mu_deg"])
    good = found["usable"]
    assert np.array_equal(found["maps"]["ji.ln_mu_deg"][::-1][good], ln_mu[good])
    assert found["maps"]["w"] == 1.0  # fitted as hamon
    tiles.remove()
    assert not list(tmp_path.glob(".*map*"))


def test_many_lights_refusals(tmp_path):
    path, lights = light_file(tmp_path)
    stack = Stack(lights, 70, 70, 8.0)
    stack.fail = 4
    with pytest.raises(OSError, match="picture 4 is cut off"):
        core.capture_lights(str(path), stack, str(tmp_path / "map.exr"))
    stack.fail = None

    def fails(_share: float) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        core.capture_lights(str(path), stack, str(tmp_path / "map.exr"), progress=fails)
    stack.width = 69
    stack.read = lambda _picture, begin, end: np.zeros((end - begin, 3), np.float32)
    with pytest.raises(core.InputError, match="no array of that many rows"):
        core.capture_lights(str(path), stack, str(tmp_path / "map.exr"))
    for options, message in (
        ({"colour": 1}, "'colour'"),
        ({"transfer": "log"}, "linear, srgb"),
        ({"white_patch": [1, 2, 3]}, "4 numbers"),
        ({"memory_mib": 1}, "16 to"),
        ({"snr": "high"}, "a number"),
    ):
        with pytest.raises(core.InputError, match=message):
            core.capture_lights_plan(str(path), options)


def camera() -> dict:
    return {
        "kind": "orthographic",
        "width_px": 400,
        "height_px": 40,
        "scale": 0.5,
        "centre_px": (200.0, 20.0),
        "position_mm": (368.0, 0.0, -12.0),
        "right": (-1.0, 0.0, 0.0),
        "down": (0.0, 0.0, -1.0),
    }


def pixel_of(point) -> tuple[float, float]:
    return 200 - 0.5 * (point[0] - 368), 20 - 0.5 * (point[2] + 12)


def test_landmarks_give_the_camera():
    places = core.blade_landmarks(core.katana_defaults())
    assert {"tip", "ha_machi", "mune_machi", "yokote_edge"} <= set(places)
    marks = [
        {"name": name, "point_mm": places[name], "pixel": pixel_of(places[name])}
        for name in ("tip", "ha_machi", "mune_machi", "yokote_edge", "yokote_ridge")
    ]
    fit = core.camera_from_landmarks(marks, 400, 40)
    assert fit["rms_mm"] < 1e-3 and len(fit["residual_mm"]) == 5
    assert fit["camera"]["scale"] == pytest.approx(0.5, rel=1e-4)
    np.testing.assert_allclose(fit["camera"]["right"], (-1, 0, 0), atol=0.05)
    with pytest.raises(core.InputError, match="landmarks"):
        core.camera_from_landmarks(marks[:3], 400, 40)
    with pytest.raises(core.InputError, match="landmarks"):
        core.camera_from_landmarks([marks[0]] * 4, 400, 40)
    with pytest.raises(core.InputError, match="orthographic, pinhole"):
        core.camera_from_landmarks(marks, 400, 40, "fisheye")


def test_maps_come_onto_the_blade():
    blade = core.katana_defaults()
    # The share w rises from the tip, on the left, to the machi.
    w = np.broadcast_to(np.linspace(0, 1, 400, dtype=np.float32), (40, 400))
    one = np.zeros((1, 1), np.float32)
    maps = {"ji.ln_mu_deg": one, "ha.ln_mu_deg": one + np.float32(np.log(5)), "w": w}
    photograph = {"maps": maps, "camera": camera(), "frame": "surface"}
    shares: list[float] = []
    found = core.capture_project(blade, [photograph], 256, 32, detail=0.05, progress=shares.append)
    assert len(shares) == 32 and shares == sorted(shares) and shares[-1] == 1.0
    with pytest.raises(InterruptedError):
        core.capture_project(
            blade, [photograph], 256, 32, detail=0.05, progress=lambda share: share < 0.5
        )
    with pytest.raises(ZeroDivisionError):
        core.capture_project(
            blade, [photograph], 64, 16, detail=0.05, progress=lambda _share: 1 / 0
        )
    assert found["maps"]["w"].shape == found["coverage"].shape == (32, 256)
    assert 0 < found["holes"] < found["on_blade"]
    covered = found["coverage"] > 0
    columns = [c for c in range(256) if covered[:, c].sum() > 2]
    means = [found["maps"]["w"][covered[:, c], c].mean() for c in columns]
    # u runs from the machi to the tip.
    assert np.corrcoef(columns, means)[0, 1] < -0.99
    unusable = np.zeros((40, 400), bool)
    with pytest.raises(core.InputError):
        core.capture_project(blade, [{**photograph, "usable": unusable}], 64, 16, detail=0.05)
    with pytest.raises(core.InputError, match="none"):
        core.capture_project(blade, [], 64, 16)
    with pytest.raises(core.InputError, match="photograph 1"):
        core.capture_project(blade, [{**photograph, "usable": unusable[:3]}], 64, 16, detail=0.05)


def test_the_outline_corrects_the_camera(tmp_path):
    true = {**camera(), "width_px": 800, "height_px": 80, "scale": 1.0, "centre_px": (400.0, 40.0)}
    picture = against_the_light(true, core.katana(core.katana_defaults(), 0.05))
    off = {**true, "centre_px": (401.2, 38.8)}
    found = core.camera_on_outline(core.katana_defaults(), off, picture, detail=0.05)
    assert found["outline"]["rms_mm"] < 0.4 < 0.8 < found["outline"]["before_rms_mm"]
    at = np.array(found["camera"]["position_mm"]) - true["position_mm"]
    moved = found["camera"]["centre_px"] - at @ np.stack([true["right"], true["down"]], -1)
    np.testing.assert_allclose(moved, true["centre_px"], atol=0.4)
    with pytest.raises(core.InputError, match="plain ground"):
        core.camera_on_outline(core.katana_defaults(), off, 0 * picture, detail=0.05)
    with pytest.raises(core.InputError, match=r"80 x 800.*that of the camera"):
        core.camera_on_outline(core.katana_defaults(), off, picture.T, detail=0.05)

    # The same by a set-up that names the picture: the evaluation does not run without it.
    text = SETUP.replace('kind = "plate"\nsize_mm = [8.0, 4.0]', 'kind = "blade"\ndetail = 0.05')
    start = text.index("[camera]")
    text = text[:start] + text[text.index("[surface]") :]
    text += '[camera]\nsilhouette = "out.tif"\nscale_px_per_mm = 1.0\n' + "\n".join(
        f"{key} = {str(list(value)) if isinstance(value, tuple) else repr(value)}".replace("'", '"')
        for key, value in off.items()
        if key != "scale"
    )
    asked = []

    def read(path: str):
        asked.append(Path(path).name)
        return (picture if asked[-1] == "out.tif" else np.full_like(picture, 0.1)), False

    given = setup(tmp_path, text)
    assert Path(given.silhouette).name == "out.tif" and given.outline is None
    refined = core.refine_capture_camera(given, read)
    assert given.camera["centre_px"] == (401.2, 38.8) and given.outline is None
    assert refined.camera == found["camera"] and refined.outline == found["outline"]
    result = core.capture_diffuse(given, read, {"border_px": 3})
    assert asked == ["out.tif", "out.tif", "one.tif", "two.tif"]
    assert result["camera"] == found["camera"] and result["outline"] == found["outline"]
    asked.clear()
    core.capture_diffuse(refined, read)
    assert asked == ["one.tif", "two.tif"]
    with pytest.raises(core.InputError, match=r"out\.tif.*4 x 4.*that of the camera"):
        core.capture_diffuse(given, lambda _path: (np.zeros((4, 4)), False))
