"""The GPU's picture against the double-precision sum over wavelengths: rows accuracy.gpu_*.

gpu_xyz_rel: walls of tiles (accuracy_scenes.py), every metal and lobe under every light at every incidence; a wall is one
picture (a narrow lobe's highlight can miss its tile near grazing: there is nothing to judge in its far tail). gpu_de00: a generated blade with its maps under nine lamps of three spectra.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field

import bench_gpu
import numpy as np
import togishi_core
from accuracy_reference import reference_picture, to_xyz
from accuracy_scenes import LOBES, TILE_PIXELS, blade_scene, tile_scene
from bench_rows import Measurement, Row, command_line, write_measurement
from togishi.engine.renderer import Gbuffer, Renderer

INCIDENCES_DEG = (0.0, 10.0, 25.0, 40.0, 55.0, 65.0, 75.0, 82.0, 86.0, 88.0, 89.0, 89.5, 89.9)
LINES = ("line:436", "line:546.1", "line:589.3", "line:632.8", "line:672.5")
COMPUTED = ("daylight:4000", "daylight:10000", "blackbody:2000", "blackbody:3200")
LAST_DEG = 89.9
"""Nearer to the horizon, one float's rounding of a normal is a visible part of its cosine."""
DARK = 1.0e-4
"""Pixels below this share of their picture's peak are not judged."""
D65_WHITE = np.array([0.95047, 1.0, 1.08883])


@dataclass
class Worst:
    """The largest error so far, and where it was."""

    value: float = 0.0
    where: str = ""
    pixels: int = 0
    values: list[float] = field(default_factory=list)

    def see(self, errors: np.ndarray, where: Callable[[int], str]) -> None:
        if not len(errors):
            return
        self.pixels += len(errors)
        self.values.append(float(errors.max()))
        # NaN counts as the worst.
        at = int(np.argmax(np.where(np.isnan(errors), np.inf, errors)))
        if not errors[at] <= self.value:
            self.value, self.where = float(errors[at]), where(at)


def relative_errors(
    got: np.ndarray, expected: np.ndarray, peak: float
) -> tuple[np.ndarray, np.ndarray]:
    """Largest error of X, Y, Z over the pixel's Y, and which pixels are judged: those above DARK of the picture's peak."""
    luminance = expected[:, 1]
    judged = luminance > DARK * peak
    return (np.abs(got - expected).max(axis=1) / np.maximum(luminance, 1e-300))[judged], judged


def beyond_the_range(gbuffer: Gbuffer) -> np.ndarray:
    """(H, W) where light or view stand closer to the horizon than 89.9 degrees."""
    normal = gbuffer.normal.astype(np.float64)
    cosines = (
        np.sum(normal * gbuffer.view, axis=-1),
        np.sum(normal * gbuffer.directions[:, :, 0], axis=-1),
    )
    return np.minimum(*cosines) < np.cos(np.radians(LAST_DEG))


def every_light() -> list[str]:
    return [light["name"] for light in togishi_core.lights()] + [*COMPUTED, *LINES]


def walls(quick: bool, say: Callable[[str], None]) -> tuple[Worst, Worst]:
    """float32 pictures, and the half-float ones that a viewport shows."""
    metals = [metal["name"] for metal in togishi_core.metals()]
    lights = ["D65", "line:589.3", "LED-B3"] if quick else every_light()
    incidences = INCIDENCES_DEG[::3] if quick else INCIDENCES_DEG
    renderer = Renderer()
    whole, half = Worst(), Worst()
    for turn, incidence in enumerate(incidences):
        for light in lights:
            scene, camera, size = tile_scene(
                metals, light, incidence, point_light=turn % 2 == 0, room=0.1 * (turn % 3 == 0)
            )
            gbuffer = renderer.gbuffer(scene, camera, size)
            expected = reference_picture(scene, camera, gbuffer)
            expected[beyond_the_range(gbuffer)] = np.nan
            for worst, float32 in ((whole, True), (half, False)):
                colour = renderer.draw(scene, camera, size, float32=float32).read()[..., :3]
                picture = to_xyz(colour, scene.colour.space)
                peak = float(np.nanmax(expected[..., 1]))
                for row, lobe in enumerate(LOBES):
                    for column, metal in enumerate(metals):
                        tile = (
                            slice(row * TILE_PIXELS, (row + 1) * TILE_PIXELS),
                            slice(column * TILE_PIXELS, (column + 1) * TILE_PIXELS),
                        )
                        reference = expected[tile].reshape(-1, 3)
                        lit = np.nan_to_num(reference[:, 1]) > 0
                        if not float32:
                            # Half floats end at 65504, and lose digits below 6e-5.
                            lit &= (reference.max(axis=1) < 1e4) & (reference[:, 1] > 1e-3)
                        if not lit.any():
                            continue
                        errors, _ = relative_errors(
                            picture[tile].reshape(-1, 3)[lit], reference[lit], peak
                        )
                        worst.see(
                            errors,
                            lambda _at, metal=metal, lobe=lobe, light=light, incidence=incidence: (
                                f"{metal}, {light}, {incidence}°, "
                                f"μ {lobe.mu_t_deg}/{lobe.mu_b_deg}° {'ha' if lobe.rough else 'ji'}"
                            ),
                        )
        say(f"      incidence {incidence}°: worst so far {whole.value:.2e} ({whole.where})")
    return whole, half


def blade_de00(quick: bool, say: Callable[[str], None]) -> Row:
    scene, camera, size = blade_scene((480, 270) if quick else (960, 540))
    renderer = Renderer()
    gbuffer = renderer.gbuffer(scene, camera, size)
    expected = reference_picture(scene, camera, gbuffer)[gbuffer.covered]
    colour = renderer.draw(scene, camera, size).read()[..., :3]
    got = to_xyz(colour, scene.colour.space)[gbuffer.covered]
    scale = 1 / np.percentile(expected[:, 1], 99)
    lit = float(np.mean(expected[:, 1] * scale > 1e-3))
    assert lit >= 0.5, f"only {lit:.0%} of the blade is lit: the figure would be of a dark picture"
    errors = togishi_core.delta_e00(got * scale, expected * scale, D65_WHITE)
    say(f"      blade: {len(errors)} pixels, {lit:.0%} lit, ΔE00 worst {errors.max():.4f}")
    return Row(
        "accuracy.gpu_de00",
        float(errors.max()),
        "ΔE00",
        0.1,
        "<=",
        (float(np.median(errors)), float(np.percentile(errors, 99))),
        f"all {len(errors)} blade pixels of {size[0]}x{size[1]}, half float as in the viewport, {lit:.0%} of them lit; "
        "nine lamps: D65, A and FL11; Lab under D65, 99th percentile of luminance scaled to 1; "
        "spread: median and 99th percentile",
    )


def measure(quick: bool, say: Callable[[str], None]) -> Measurement:
    machine = bench_gpu.start()
    whole, half = walls(quick, say)
    how = (
        f"{whole.pixels} pixels above 1e-4 of their picture's peak: every built-in metal, {len(LOBES)} lobes (0.2 to 12°, to 20:1), "
        f"every built-in light, {len(COMPUTED)} computed, {len(LINES)} lines, incidence 0 to 89.9°; worst at "
    )
    rows = [
        Row("accuracy.gpu_xyz_rel", whole.value, "", 2e-3, "<=", spread(whole), how + whole.where),
        Row(
            "accuracy.gpu_half_xyz_rel",
            half.value,
            "",
            spread=spread(half),
            how="the same pictures in half float, as a viewport shows them, where they lie between 1e-3 and 1e4; worst at "
            + half.where,
        ),
        blade_de00(quick, say),
    ]
    return Measurement(rows, machine=machine)


def spread(worst: Worst) -> tuple[float, float]:
    """Median and 99th percentile of the tiles' worst."""
    return float(np.median(worst.values)), float(np.percentile(worst.values, 99))


if __name__ == "__main__":
    options = command_line(__doc__ or "").parse_args()
    write_measurement(
        options.out, measure(options.quick, lambda text: print(text, file=sys.stdout, flush=True))
    )
    bench_gpu.leave()
