"""A round trip nobody tuned: known maps of a blade, photographed, captured, brought onto the blade, rendered again.

    python tests/bench/capture_round_trip.py --out ROWS [--seed 1] [--only reference mitsuba]

Two cameras look at neighbouring pieces of a generated katana, each with a strip light in two places (noise, blur, 12 bits);
one trip with photographs by the reference evaluation, one with a stranger's, by Mitsuba 3. The capture is told a camera that is
a millimetre and tenths of a degree off in the picture's plane, beside a picture against the light, and half widths that are 12 % wrong. The map on
the blade is then rendered by the reference evaluation under a soft box that no photograph had, and compared with that
picture of the known maps: for the second trip with Mitsuba's own.
"""

from __future__ import annotations

import base64
import importlib
import io
import json
import re
import subprocess
import sys
import tempfile
import tomllib
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import by_mitsuba
import numpy as np
import togishi_core as core
from bench_rows import Measurement, ResultsError, Row, command_line, write_measurement
from capture_diffuse import LIGHT, WRONG, material_off_by, togishi
from matplotlib.image import imsave
from PIL import Image
from scipy.ndimage import gaussian_filter
from togishi.core import photographs

STEPS = ("reference", "mitsuba")
PLACES_MM = (270.0, 330.0)
"""Where the two cameras look, along the blade; they share 20 mm of their 80."""
OFF_MM, OFF_DEG = 1.0, 0.3
"""How far the cameras that the capture is told are off: across the blade, and about the way that they look. What an outline
does not hold, how far the blade is turned about its length, is told rightly."""
TURN_DEG = 9.0
"""The soft box of the pictures that are compared stands so far from between the strips."""
HALF_MM = 98.0
BODY = (1, 3)
"""Parts ji and ha."""
SAMPLES = 1024


@cache
def image_io() -> ModuleType:
    """PyPI's openimageio, which the package tests install too."""
    subprocess.run(
        [str(by_mitsuba.REPOSITORY / "tools/setup_openimageio.sh")],
        cwd=by_mitsuba.REPOSITORY,
        check=True,
    )
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    sys.path.append(str(by_mitsuba.REPOSITORY / ".venv-openimageio" / version))
    return importlib.import_module("OpenImageIO")


def read_planes(path: Path) -> dict[str, np.ndarray]:
    return photographs.read_planes(image_io(), path)


def vector(text: str, key: str) -> np.ndarray:
    return np.array(json.loads(re.search(rf"^{key} = (\[.*\])$", text, re.M)[1]))


def with_vector(text: str, key: str, value: np.ndarray) -> str:
    return re.sub(rf"^{key} = \[.*\]$", f"{key} = {json.dumps(value.tolist())}", text, flags=re.M)


def turned(vectors: np.ndarray, axis: np.ndarray, deg: float) -> np.ndarray:
    """Rodrigues' rotation of (..., 3) about a unit axis."""
    angle = np.radians(deg)
    return (
        vectors * np.cos(angle)
        + np.cross(axis, vectors) * np.sin(angle)
        + np.multiply.outer(vectors @ axis, axis) * (1 - np.cos(angle))
    )


class Trip:
    """The files of one trip."""

    def __init__(self, folder: Path, seed: int, quick: bool) -> None:
        self.folder, self.seed = folder, seed
        self.places_mm = (285.0, 315.0) if quick else PLACES_MM
        example = togishi("capture", "simulate", "--example", "blade")
        example = example.replace('light = "D65"', LIGHT)
        if quick:
            example = re.sub(r"^width_px = 200", "width_px = 100", example, flags=re.M)
            example = example.replace("centre_px = [100.0", "centre_px = [50.0")
        self.truth = folder / "truth.exr"
        togishi(
            *("bake", "--material", "sashikomi_katana", "--pattern", "hadori=0", "--float"),
            *("-o", self.truth),
        )
        example = re.sub(
            r"^\[simulate\]$", f'[simulate]\nmaps = "{self.truth}"', example, flags=re.M
        )
        head, *photographs = example.split("[[photograph]]")
        tail = photographs[-1][photographs[-1].index("[simulate]") :]
        self.strips = head + "".join("[[photograph]]" + p for p in photographs[:2]) + tail
        # Between the strips, turned about the blade's length.
        target = vector(head, "position_mm")
        centre = 0.5 * sum(vector(p, "centre_mm") for p in photographs[:2]) - target
        centre = turned(centre, np.array([1.0, 0, 0]), TURN_DEG)
        v = HALF_MM * np.cross(centre, [1.0, 0, 0]) / np.linalg.norm(centre)
        box = with_vector(with_vector(photographs[0], "centre_mm", target + centre), "half_v_mm", v)
        self.view = (
            re.sub(r"^bits = \d+", "bits = 0", head, flags=re.M)
            .replace("snr = 100.0", "snr = 0.0")
            .replace("read = 3e-04", "read = 0.0")
            .replace('transfer = "linear"', 'transfer = "linear"\nscale = 1.0')
            + "[[photograph]]"
            + box
            + tail.replace("blur_px = 0.6", "blur_px = 0.0")
        )

    def photographed(self) -> list[Path]:
        """Set-ups of the reference evaluation's photographs, their cameras exact."""
        setups = []
        for index, x_mm in enumerate(self.places_mm):
            text = with_vector(self.strips, "position_mm", np.array([x_mm, 3.0, -31.0]))
            setup = self.folder / f"strips_{index}.toml"
            setup.write_text(text, encoding="utf-8")
            out = self.folder / f"pictures_{index}"
            togishi("capture", "simulate", setup, "-o", out, "--seed", self.seed + index)
            setups.append(out / "setup.toml")
        return setups

    def captured(self, name: str, setups: list[Path]) -> dict[str, Any]:
        """The map on the blade, by cameras that are off, refined on the outline."""
        material = material_off_by(self.folder, WRONG)
        told, maps = [], []
        for index, exact in enumerate(setups):
            text = exact.read_text(encoding="utf-8")
            right, down = vector(text, "right"), vector(text, "down")
            forward = np.cross(right, down)
            deg = OFF_DEG * (-1) ** index
            place = vector(text, "position_mm") + OFF_MM * (-1) ** index * down
            for key, value in (
                ("right", turned(right, forward, deg)),
                ("down", turned(down, forward, deg)),
                ("position_mm", place),
            ):
                text = with_vector(text, key, value)
            text = text.replace("[camera]", '[camera]\nsilhouette = "silhouette.tif"')
            setup = exact.with_name(f"{name}.toml")
            setup.write_text(text, encoding="utf-8")
            out = exact.with_name(f"{name}.exr")
            togishi("--json", "capture", "diffuse", setup, "-o", out, "--material", material)
            told.append(setup)
            maps.append(out)
        blade = self.folder / f"{name}_blade.exr"
        report = json.loads(
            togishi(
                *("--json", "capture", "project", "-o", blade),
                *(argument for setup in told for argument in ("--setup", setup)),
                *(argument for path in maps for argument in ("--map", path)),
            )
        )
        return {**report, "map": blade}

    def pictured(self, name: str, maps: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """The soft box's picture of a blade with these maps by the reference, and what each pixel sees."""
        setup = self.folder / f"view_{name}.toml"
        setup.write_text(self.view.replace(str(self.truth), str(maps)), encoding="utf-8")
        out = self.folder / f"view_{name}"
        togishi("capture", "simulate", setup, "-o", out, "--format", "exr")
        (values,) = read_planes(out / "photograph_1.exr").values()
        return values, read_planes(out / "truth.exr")


def mitsuba_pictures(trip: Trip, setups: list[Path]) -> tuple[list[Path], np.ndarray]:
    """The same photographs by Mitsuba, with the camera's blur, noise and bits; and its picture of the soft box."""
    mesh = trip.folder / "blade.obj"
    togishi("katana", "-o", mesh)
    n, k = core.metal_nk("iron_johnson_christy", np.array([550.0]))
    random = np.random.default_rng(trip.seed)

    def rendered(setup: Path, seed: int) -> list[np.ndarray]:
        told = tomllib.loads(setup.read_text(encoding="utf-8"))
        files = [
            str(setup.with_name(f"m_{number}.npy")) for number in range(len(told["photograph"]))
        ]
        job = {
            "mesh": str(mesh),
            "maps": str(trip.truth),
            "eta": float(n[0]),
            "k": float(k[0]),
            "samples": SAMPLES,
            "seed": seed,
            "camera": told["camera"],
            "pictures": [
                {"file": file, **photograph["source"]}
                for file, photograph in zip(files, told["photograph"], strict=True)
            ],
        }
        by_mitsuba.run("mitsuba_blade.py", job)
        return [np.load(file) for file in files]

    out = []
    for index, exact in enumerate(setups):
        text = exact.read_text(encoding="utf-8")
        told = tomllib.loads(text)
        noise = told["noise"]
        for number, radiance in enumerate(rendered(exact, 100 * trip.seed + 10 * index), 1):
            signal = gaussian_filter(radiance, told["simulate"]["blur_px"], mode="nearest")
            signal = signal * told["scale"]
            sigma = np.sqrt(np.maximum(signal, 0) / noise["snr"] ** 2 + noise["read"] ** 2)
            value = np.clip(signal + sigma * random.standard_normal(signal.shape), 0, 1)
            levels = 2 ** noise["bits"] - 1
            value = np.rint(value * levels) / levels
            name = f"mitsuba_{number}.tif"
            Image.fromarray(np.rint(value * 65535).astype(np.uint16)).save(exact.with_name(name))
            text = text.replace(f"photograph_{number}.tif", name)
        setup = exact.with_name("mitsuba_setup.toml")
        setup.write_text(text, encoding="utf-8")
        out.append(setup)
    view = trip.folder / "view_mitsuba.toml"
    view.write_text(trip.view, encoding="utf-8")
    return out, rendered(view, 100 * trip.seed + 50)[0]


def png(planes: list[np.ndarray], top: float, times: int = 4) -> str:
    """Grey pictures one above the other."""
    gap = np.full((3, planes[0].shape[1]), top)
    rows = [part for plane in planes for part in (plane, gap)][:-1]
    values = np.clip(np.concatenate(rows) / top, 0, 1)
    values = np.repeat(np.repeat(values, times, 0), times, 1)
    out = io.BytesIO()
    imsave(out, values, cmap="gray", vmin=0, vmax=1, format="png")
    return base64.b64encode(out.getvalue()).decode()


def compared(
    prefix: str,
    by: str,
    trip: Trip,
    capture: dict[str, Any],
    truth: dict[str, np.ndarray],
    wanted: np.ndarray,
) -> Measurement:
    """Rows and pictures of a trip, `wanted` being the soft box's picture of the known maps, `truth` what its pixels see."""
    again, found = trip.pictured(prefix, capture["map"])
    coverage = read_planes(capture["map"].with_name(f"{capture['map'].stem}-coverage.exr"))
    (coverage,) = coverage.values()
    height, width = coverage.shape
    column = np.clip((truth["u"] * width).astype(int), 0, width - 1)
    row = np.clip(((1 - truth["v"]) * height).astype(int), 0, height - 1)
    body = (truth["seen"] > 0) & np.isin(truth["part"], BODY)
    told = body & (coverage[row, column] > 0)
    w_error = np.abs(found["w"] - truth["w"])[told]
    is_ha = truth["w"] > 0.5
    lead = {
        name: np.where(is_ha, planes["ha.ln_mu_deg"], planes["ji.ln_mu_deg"])
        for name, planes in (("found", found), ("truth", truth))
    }
    mu_error = 100 * np.abs(np.expm1(lead["found"] - lead["truth"]))[told]
    top = float(np.quantile(wanted[told], 0.99))
    picture_error = 100 * np.abs(again - wanted)[told] / top
    outline = [camera["outline"] for camera in capture["cameras"]]
    share = float(told.sum() / body.sum())
    how = (
        f"two cameras of 2.5 pixels/mm, two strips each, SNR 100, 12 bit, blur 0.6 pixels, cameras told {OFF_MM:g} mm and "
        f"{OFF_DEG:g}° off in the picture's plane alone (how far the blade is turned about its length is told rightly), lobes {round(100 * (WRONG - 1))} % off; {int(told.sum())} pixels; photographs by {by}; "
        f"seed {trip.seed}"
    )
    rows = [
        Row(f"{prefix}.w_p50", float(np.quantile(w_error, 0.5)), how=how),
        Row(f"{prefix}.w_p90", float(np.quantile(w_error, 0.9)), how=how),
        Row(
            f"{prefix}.mu_p50_pct",
            float(np.quantile(mu_error, 0.5)),
            "%",
            how=f"leading lobe; {how}",
        ),
        Row(
            f"{prefix}.mu_p90_pct",
            float(np.quantile(mu_error, 0.9)),
            "%",
            how=f"leading lobe, pixels that keep the prior's half width among them; {how}",
        ),
        Row(
            f"{prefix}.picture_p50_pct",
            float(np.quantile(picture_error, 0.5)),
            "%",
            how=f"of the picture's 99 % brightness, under a soft box that no photograph had; {how}",
        ),
        Row(f"{prefix}.picture_p90_pct", float(np.quantile(picture_error, 0.9)), "%", how=how),
        Row(
            f"{prefix}.covered",
            share,
            how="share of ji and ha in the compared view that has a measured value; the rest lies beside the outline and "
            "other parts, or was masked",
        ),
        Row(
            f"{prefix}.outline_rms_mm",
            max(one["rms_mm"] for one in outline),
            "mm",
            how=f"outline in the picture to the blade's, after refinement; before: "
            f"{max(one['before_rms_mm'] for one in outline):.2f} mm",
        ),
    ]
    pictures = {
        f"Round trip, photographs by {by}: the known maps under another light, the captured maps rendered again, four times "
        "their difference": png([wanted, again, 4 * np.abs(again - wanted) * told], top),
        f"Round trip, photographs by {by}: w as known, as captured and brought onto the blade, four times their difference "
        "(ji and ha alone are captured)": png(
            [truth["w"] * body, found["w"] * told, 4 * np.abs(found["w"] - truth["w"]) * told], 1.0
        ),
    }
    return Measurement(rows=rows, pictures=pictures)


def measure(only: list[str], seed: int, quick: bool) -> Measurement:
    measured = Measurement()
    with tempfile.TemporaryDirectory() as name:
        trip = Trip(Path(name), seed, quick)
        setups = trip.photographed()
        known, truth = trip.pictured("known", trip.truth)
        parts = []
        if "reference" in only:
            capture = trip.captured("reference", setups)
            parts.append(
                compared(
                    "capture.round_trip", "the reference evaluation", trip, capture, truth, known
                )
            )
        if "mitsuba" in only:
            strange, wanted = mitsuba_pictures(trip, setups)
            capture = trip.captured("mitsuba", strange)
            parts.append(
                compared("capture.round_trip_mitsuba", "Mitsuba 3", trip, capture, truth, wanted)
            )
        for part in parts:
            measured.rows += part.rows
            measured.pictures |= part.pictures
    return measured


def main() -> int:
    parser = command_line(__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", choices=STEPS, default=STEPS)
    options = parser.parse_args()
    write_measurement(options.out, measure(options.only, options.seed, options.quick))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (ResultsError, subprocess.CalledProcessError) as error:
        sys.exit(f"{Path(__file__).name}: {error}")
