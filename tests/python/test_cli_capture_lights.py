"""togishi capture lights: a small stack of photographs, rendered by the reference evaluation, becomes the maps that it
was rendered from; the same bits for any threads and bands; bad input is named and finished tiles are kept."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
import togishi_core
from PIL import Image

WIDTH, HEIGHT, LIGHTS = 150, 140, 40
STORE_HEADER = 128  # bytes before the checksums of the bands (cpp_core/capture/tile_store.cpp)
NAME = "写真 "  # spaces and characters beyond ASCII


def stack(folder: Path, images: int = LIGHTS) -> tuple[Path, dict[str, np.ndarray]]:
    """Pictures of a gently curved hamon with a lobe that changes from left to right, and the truth."""
    rng = np.random.default_rng(5)
    x, y = np.meshgrid(np.linspace(-1, 1, WIDTH), np.linspace(1, -1, HEIGHT))
    tilt_x, tilt_y = np.radians(2 * x), np.radians(1.5 * y)
    normal = np.stack([np.sin(tilt_x), np.sin(tilt_y), np.ones_like(x)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    ln_mu = np.log(6.0) + 0.25 * x
    e1, e2 = 0.3 * np.cos(0.6 + 0.5 * y), 0.3 * np.sin(0.6 + 0.5 * y)
    points = WIDTH * HEIGHT
    view, tangent = np.tile([0.0, 0, 1], (points, 1)), np.tile([1.0, 0, 0], (points, 1))
    angle = 2.399963 * np.arange(images)
    zenith = np.radians(4 + 44 * np.sqrt((np.arange(images) + 0.5) / images))
    lights = np.stack(
        [np.sin(zenith) * np.cos(angle), np.sin(zenith) * np.sin(angle), np.cos(zenith)], -1
    )
    lobe = np.stack([ln_mu, e1, e2], -1).reshape(points, 3)
    pictures = []
    for light in lights:
        xyz = togishi_core.reference_xyz(
            metal="iron_johnson_christy",
            lights=["D65"],
            light_of=np.zeros(1, np.int32),
            normal=normal.reshape(points, 3),
            tangent=tangent,
            view=view,
            light_direction=np.tile(light, (points, 1, 1)),
            irradiance=np.ones((points, 1)),
            lobe_ji=lobe,
            lobe_hadori=lobe,
            lobe_ha=lobe,
            w=1.0,
            h=0.0,
        )
        pictures.append(xyz[:, 1].reshape(HEIGHT, WIDTH) + 0.02 / np.pi * (normal @ light))
    full = max(p.max() for p in pictures) / 0.9
    lines = [str(images)]
    for i, (picture, light) in enumerate(zip(pictures, lights, strict=True)):
        signal_ = picture / full
        noisy = signal_ + np.sqrt(1e-4 * signal_ + 9e-8) * rng.normal(size=picture.shape)
        steps = np.clip(np.round(noisy * 65535), 0, 65535).astype(np.uint16)
        name = f"{NAME}{i:03d}.tif"
        Image.fromarray(steps).save(folder / name)
        lines.append(name + " " + " ".join(f"{v:.9f}".replace(".", ",") for v in light))
    file = folder / "stack.lp"
    file.write_text("\r\n".join(lines) + "\r\n", encoding="utf-8-sig")
    return file, {"normal": normal, "lobe.ln_mu_deg": ln_mu, "lobe.e1": e1, "lobe.e2": e2}


def read(path: Path) -> dict[str, np.ndarray]:
    """The channels of a tiled OpenEXR file of 32-bit floats, ZIP-compressed."""
    data = path.read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01"
    at, header = 8, {}
    while data[at] != 0:
        name, _, rest = data[at:].split(b"\0", 2)
        at = len(data) - len(rest)
        size = int.from_bytes(data[at : at + 4], "little")
        header[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    names, rest = [], header["channels"]
    while rest[0] != 0:
        name, rest = rest.split(b"\0", 1)
        assert int.from_bytes(rest[:4], "little") == 2, "32-bit floats"
        names.append(name.decode())
        rest = rest[16:]
    x0, y0, x1, y1 = np.frombuffer(header["dataWindow"], "<i4")
    width, height, tile = x1 - x0 + 1, y1 - y0 + 1, int.from_bytes(header["tiles"][:4], "little")
    planes = {name: np.full((height, width), np.nan, np.float32) for name in names}
    tiles = -(-width // tile) * -(-height // tile)
    for offset in np.frombuffer(data, "<u8", tiles, at):
        tx, ty, _, _, size = np.frombuffer(data, "<i4", 5, int(offset))
        packed = data[int(offset) + 20 : int(offset) + 20 + size]
        columns, rows = min(tile, width - tx * tile), min(tile, height - ty * tile)
        count = columns * rows * len(names) * 4
        if size < count:
            shifted = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
            shifted[1:] -= 128
            halves = np.cumsum(shifted).astype(np.uint8)
            packed = np.empty(count, np.uint8)
            packed[0::2], packed[1::2] = np.split(halves, [(count + 1) // 2])
        values = np.frombuffer(bytes(packed), "<f4").reshape(rows, len(names), columns)
        for i, name in enumerate(names):
            planes[name][ty * tile : ty * tile + rows, tx * tile : tx * tile + columns] = values[
                :, i
            ]
    return planes


def refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    assert done.returncode == 2, done.stderr
    assert "allowed:" in done.stderr
    for word in words:
        assert word in done.stderr, done.stderr


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, np.ndarray]]:
    return stack(tmp_path_factory.mktemp("stack"))


def test_the_maps_that_were_photographed_come_back(togishi, photographs, tmp_path):
    file, truth = photographs
    out = tmp_path / "maps.exr"
    done = togishi("--json", "capture", "lights", file, "-o", out, "--light-error", "0")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["flagged"] < 0.01 * WIDTH * HEIGHT
    assert [p.name for p in tmp_path.iterdir()] == ["maps.exr"]
    found = read(out)
    good = found["flags"] == 0
    mu = np.exp(found["lobe.ln_mu_deg"] - truth["lobe.ln_mu_deg"]) - 1
    assert np.median(np.abs(mu[good])) < 0.01
    normal = np.stack([found[f"N.{c}"] for c in "XYZ"], -1)
    lean = np.degrees(np.arccos(np.clip((normal * truth["normal"]).sum(-1), -1, 1)))
    assert np.percentile(lean[good], 90) < 0.2
    for name in ("lobe.e1", "lobe.e2"):
        assert np.percentile(np.abs(found[name] - truth[name])[good], 90) < 0.03
    # What it claims of ln mu is what it is off by, within a factor of 1.5.
    ratio = np.abs(np.log1p(mu))[good] / found["sigma.ln_mu"][good]
    assert 0.3 < np.median(ratio) < 1.0
    assert (found["samples.used"][good] > 0.8 * LIGHTS).all()


def test_the_same_bits_for_any_threads_and_bands(togishi, photographs, tmp_path):
    file, _ = photographs
    maps = []
    for i, options in enumerate((["--threads", "1"], ["--threads", "3", "--band-rows", "64"])):
        out = tmp_path / f"{i}.exr"
        done = togishi("capture", "lights", file, "-o", out, "--self-calibrate", *options)
        assert done.returncode == 0, done.stderr
        assert "narrow half widths are measured from" in done.stdout
        maps.append(read(out))
    for name, plane in maps[0].items():
        assert np.array_equal(plane, maps[1][name], equal_nan=True), name


def test_a_picture_cut_off_stops_the_run_and_the_next_goes_on(togishi, photographs, tmp_path):
    file, _ = photographs
    for picture in file.parent.iterdir():
        (tmp_path / picture.name).write_bytes(picture.read_bytes())
    cut = tmp_path / f"{NAME}007.tif"
    whole = cut.read_bytes()
    out = tmp_path / "maps.exr"
    options = ["-o", out, "--band-rows", "64"]
    expected = tmp_path / "expected.exr"
    assert togishi("capture", "lights", tmp_path / "stack.lp", "-o", expected).returncode == 0

    # The same file, of the same size and time, whose end cannot be read.
    stamp = cut.stat()

    def damaged(data: bytes) -> None:
        cut.write_bytes(data)
        os.utime(cut, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))

    damaged(whole[: len(whole) * 6 // 10])
    done = togishi("capture", "lights", tmp_path / "stack.lp", *options)
    refused(done, "007.tif")
    assert not out.exists()
    damaged(whole)
    done = togishi("--json", "capture", "lights", tmp_path / "stack.lp", *options)
    assert done.returncode == 0, done.stderr
    for name, plane in read(out).items():
        assert np.array_equal(plane, read(expected)[name], equal_nan=True), name
    assert not list(tmp_path.glob(".*.tiles"))


def whole_bands(store: Path) -> int:
    """How many of a run's bands are marked in its store: a checksum each, behind the header."""
    bands = -(-HEIGHT // 64)
    sums = np.frombuffer(store.read_bytes()[STORE_HEADER : STORE_HEADER + 8 * bands], "<u8")
    return int(np.count_nonzero(sums))


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL], ids=["stopped", "killed"])
def test_a_run_that_is_interrupted_goes_on_where_it_was(
    togishi, togishi_cli, photographs, tmp_path, how
):
    file, _ = photographs
    out = tmp_path / "maps.exr"
    command = [str(togishi_cli), "capture", "lights", str(file), "-o", str(out)]
    command += ["--band-rows", "64", "--threads", "1", "--self-calibrate"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    tiles: list[Path] = []
    deadline = time.monotonic() + 60
    while process.poll() is None and time.monotonic() < deadline:
        tiles = list(tmp_path.glob(".maps.exr.*.tiles"))
        if tiles and whole_bands(tiles[0]) > 0:
            process.send_signal(how)
            break
        time.sleep(0.002)
    _, errors = process.communicate(timeout=60)
    if process.returncode == 0:
        pytest.skip("the machine was faster than the signal")
    if how == signal.SIGINT:
        assert process.returncode == 1, errors
        assert "stopped: " in errors
    assert not out.exists()
    done = togishi("--json", *command[1:])
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["bands_resumed"] >= 1
    again = tmp_path / "again.exr"
    assert togishi("capture", "lights", file, "-o", again, "--self-calibrate").returncode == 0
    for name, plane in read(out).items():
        assert np.array_equal(plane, read(again)[name], equal_nan=True), name


def near_stack(folder: Path) -> tuple[Path, Path, float, float]:
    """A flat hamon and a white patch under lamps at 300 mm, of unlike intensities, as floats: the .lp file with and
    the one without intensities, full scale, and the weight of the lobe."""
    width, height, distance_mm, lamps = 80, 48, 300.0, 40
    rng = np.random.default_rng(8)
    x, y = np.meshgrid(np.arange(width) - (width - 1) / 2, (height - 1) / 2 - np.arange(height))
    place = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    points = len(place)
    mu_t, mu_b, rho = np.radians(8.0), np.radians(5.0), np.radians(25.0)
    r = 0.5 * np.log(mu_t / mu_b)
    ln_mu = np.log(np.degrees(np.sqrt(mu_t * mu_b)))
    lobe = np.tile([ln_mu, r * np.cos(2 * rho), r * np.sin(2 * rho)], (points, 1))
    angle, zenith = 2.399963 * np.arange(lamps), np.radians(np.linspace(5, 46, lamps))
    lamp = distance_mm * np.stack(
        [np.sin(zenith) * np.cos(angle), np.sin(zenith) * np.sin(angle), np.cos(zenith)], -1
    )
    intensity = rng.uniform(0.5, 2.0, lamps)
    up = np.tile([0.0, 0, 1], (points, 1))
    pictures = []
    for at, strength in zip(lamp, intensity, strict=True):
        ray = at - place
        apart = np.linalg.norm(ray, axis=-1, keepdims=True)
        light, irradiance = ray / apart, strength * (distance_mm / apart) ** 2
        xyz = togishi_core.reference_xyz(
            metal="iron_johnson_christy",
            lights=["D65"],
            light_of=np.zeros(1, np.int32),
            normal=up,
            tangent=np.tile([1.0, 0, 0], (points, 1)),
            view=up,
            light_direction=light[:, None],
            irradiance=irradiance,
            lobe_ji=lobe,
            lobe_hadori=lobe,
            lobe_ha=lobe,
            w=1.0,
            h=0.0,
        )
        picture = (xyz[:, 1] + 0.02 / np.pi * light[:, 2] * irradiance[:, 0]).reshape(height, width)
        white = (0.99 / np.pi * light[:, 2] * irradiance[:, 0]).reshape(height, width)
        picture[4:14, 2:12] = white[4:14, 2:12]
        pictures.append(picture)
    full = max(p.max() for p in pictures) / 0.9
    files = [["near.lp", str(lamps)], ["white.lp", str(lamps)]]
    for i, (picture, at, strength) in enumerate(zip(pictures, lamp, intensity, strict=True)):
        Image.fromarray((picture / full).astype(np.float32)).save(folder / f"{i}.tif")
        line = f"{i}.tif " + " ".join(f"{v:.6f}" for v in at)
        files[0].append(f"{line} {strength:.6f}")
        files[1].append(line)
    for name, *lines in files:
        (folder / name).write_text("\n".join(lines) + "\n")
    weight = np.log(2) / (4 * np.pi * mu_t * mu_b)
    return folder / "near.lp", folder / "white.lp", full, weight


def test_near_lamps_by_their_intensities_or_by_a_white_reference(togishi, tmp_path):
    stated, white, full, weight = near_stack(tmp_path)
    near = ["--positions", "--mm-per-pixel", "1", "--light-error", "0"]
    runs = (
        (stated, ["--intensities"], weight / full),
        (white, ["--white-patch", "2", "4", "10", "10"], weight),
    )
    for file, options, expected in runs:
        out = tmp_path / f"{file.stem}.exr"
        done = togishi("capture", "lights", file, "-o", out, *near, *options)
        assert done.returncode == 0, done.stderr
        found = {name: plane[16:] for name, plane in read(out).items()}  # below the white patch
        good = found["flags"] == 0
        assert good.mean() > 0.98
        shape = np.hypot(found["lobe.e1"], found["lobe.e2"])
        for sign, mu_deg in ((1, 8.0), (-1, 5.0)):
            mu = np.exp(found["lobe.ln_mu_deg"] + sign * shape)[good]
            assert np.percentile(np.abs(mu / mu_deg - 1), 90) < 0.01
        rho = np.degrees(0.5 * np.arctan2(found["lobe.e2"], found["lobe.e1"]))[good]
        assert np.percentile(np.abs(rho - 25), 90) < 0.5
        assert np.percentile(np.abs(found["N.Z"] - 1)[good], 90) < 1e-5
        assert np.percentile(np.abs(found["lobe.weight"] / expected - 1)[good], 90) < 0.02


def test_what_a_set_up_can_see_is_said_before_anything_is_fitted(togishi, photographs):
    file, _ = photographs
    done = togishi("--json", "capture", "lights", file, "--plan")
    assert done.returncode == 0, done.stderr
    reach = json.loads(done.stdout)["reach"]
    assert reach["mu_sure_deg"] == pytest.approx(0.65 * reach["spacing_deg"], rel=1e-6)
    assert reach["mu_mostly_deg"] < reach["mu_sure_deg"] < reach["mu_widest_deg"]


def test_a_prior_fills_only_when_asked_and_says_so(togishi, photographs, tmp_path):
    """Eight samples cannot show narrow lobes in all pixels: with a wrong noise the fit is unsure everywhere."""
    file, _ = photographs
    without, filled = tmp_path / "without.exr", tmp_path / "filled.exr"
    options = ["--snr", "12"]
    assert togishi("capture", "lights", file, "-o", without, *options).returncode == 0
    done = togishi(
        "--json", "capture", "lights", file, "-o", filled, *options, "--prior", "8", "5", "20"
    )
    assert done.returncode == 0, done.stderr
    inferred = 32
    assert not (read(without)["flags"].astype(int) & inferred).any()
    flags = read(filled)["flags"].astype(int)
    assert (flags & inferred > 0).sum() == json.loads(done.stdout)["inferred"]


def test_bad_input_is_named(togishi, photographs, tmp_path):
    file, _ = photographs
    out = tmp_path / "maps.exr"

    def run(*options: object) -> subprocess.CompletedProcess[str]:
        return togishi("capture", "lights", file, "-o", out, *options)

    text = file.read_text(encoding="utf-8-sig")
    broken = tmp_path / "broken.lp"
    broken.write_text(text.replace(NAME, f"{file.parent}/{NAME}").replace("40\n", "41\n", 1))
    refused(togishi("capture", "lights", broken, "-o", out), "broken.lp", "count", "41")
    broken.write_text(text)
    refused(togishi("capture", "lights", broken, "-o", out), "line 2", "picture", "missing")
    refused(togishi("capture", "lights", tmp_path / "none.lp", "-o", out), "none.lp", "missing")
    refused(togishi("capture", "lights", file, "-o", tmp_path / "maps.png"), ".exr")
    refused(togishi("capture", "lights", file, "-o", tmp_path / "no" / "maps.exr"), "output folder")
    refused(run("--positions"), "scale")
    refused(run("--model", "velvet"), "velvet", "ji, hamon")
    refused(run("--snr", "0"), "snr")
    refused(run("--band-rows", "65"), "multiple of 64")
    refused(run("--white-patch", "140", "0", "20", "20"), "white patch")
    refused(run("--normal", "0", "0", "-1"), "normal")
    refused(run("--bracket", "x.lp"), "--bracket")
    refused(run("--channel", "Z"), "channel")
    small = tmp_path / "small.tif"
    Image.fromarray(np.zeros((8, 8), np.uint16)).save(small)
    lines = text.splitlines()
    lines = [lines[0]] + [f"{file.parent}/{line}" for line in lines[1:]]
    lines[3] = lines[3].replace(f"{file.parent}/{NAME}002.tif", str(small))
    broken.write_text("\n".join(lines))
    refused(togishi("capture", "lights", broken, "-o", out), "small.tif", "size is 8 x 8")
    arc = [
        lines[0],
        *(f"{' '.join(line.split()[:-3])} {0.02 * i} 0 1" for i, line in enumerate(lines[1:])),
    ]
    arc[3] = arc[3].replace(str(small), f"{file.parent}/{NAME}002.tif")
    broken.write_text("\n".join(arc))
    refused(togishi("capture", "lights", broken, "-o", out), "all in one plane")
    arc[7] = arc[7].replace(" 0 1", " 0 -1")
    broken.write_text("\n".join(arc))
    refused(togishi("capture", "lights", broken, "-o", out), "line 8", "horizon")
    few = [lines[0].replace("40", "6"), *lines[5:11]]
    broken.write_text("\n".join(few))
    refused(togishi("capture", "lights", broken, "-o", out), "lights is 6", "at least 7")
    assert not out.exists()
    assert not list(tmp_path.glob(".*"))
