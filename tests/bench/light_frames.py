"""Highlights while the camera moves: how much their light changes from picture to picture, and what keeping it costs.

    python tests/bench/light_frames.py --out ROWS [--frames 200]

A camera goes round the generated katana at 480p, one sample a pixel. Of every picture the light of all highlights is
added up, with highlight anti-aliasing and without, and compared with 1024 samples a pixel of the same picture.
"""

from __future__ import annotations

import base64
import dataclasses
import io
import math
import sys
from collections.abc import Iterator
from typing import Any

import accuracy_scenes
import bench_gpu
import matplotlib as mpl
import numpy as np
import togishi
import togishi_core
from bench_rows import Measurement, Row, command_line, ratio_and_spread, write_measurement
from togishi.core import materials
from togishi.core.scene_data import Camera, Instance, Light, LightKind, SceneData
from togishi.engine.camera_read import Region, crop
from togishi.engine.renderer import Renderer

mpl.use("agg")
from matplotlib import pyplot

SIZE = (854, 480)
SIDE = 32  # of a pixel's 1024 samples
TILE = 96
FRAMES = 200
ORBIT_DEG = 12.0
MUNE = 4  # shaders/shared/parts.glsl
# Rec.709
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def polished() -> dict[str, Any]:
    """The default material with a finer polish: lobes of .3 by .1 degrees, highlights long across the strokes."""
    material = togishi_core.default_material()
    for name in ("ji", "shinogi_ji", "mune", "kissaki"):
        material["parts"][name].update({"mu_t_deg": 0.3, "mu_b_deg": 0.1})
    return material


def camera_at(turn_deg: float) -> Camera:
    """Round the blade's middle, which lies along x."""
    middle = np.array([0.33, 0.0, 0.0])
    turn = math.radians(turn_deg)
    eye = middle + 1.4 * np.array([math.sin(turn), math.cos(turn), 0.9])
    return accuracy_scenes.look_at(eye, middle, np.array([0.0, 0.0, 1.0]), 16.0, SIZE[0] / SIZE[1])


def scene() -> SceneData:
    """A katana with a round back (maru-mune), seen from behind and above: at this size the line along its back is far
    narrower than a pixel, in which the normal turns by more than ten degrees. Six lamps, each where a point of the back
    mirrors it into the camera in the middle of its way."""
    mesh = accuracy_scenes.blade_mesh(mune="maru")
    place = mesh.position.astype(np.float64)
    normal = mesh.normal_part[:, :3].astype(np.float64)
    eye = -camera_at(0.0).view[:3, :3].T @ camera_at(0.0).view[:3, 3]
    back = (mesh.normal_part[:, 3] == MUNE) & (normal @ (eye / np.linalg.norm(eye)) > 0.8)
    seen = np.flatnonzero(back & (place[:, 0] > 0.05) & (place[:, 0] < 0.65))
    lamps = []
    for vertex in np.random.default_rng(7).choice(seen, 6, replace=False):
        view = eye - place[vertex]
        view /= np.linalg.norm(view)
        towards = 2 * np.dot(normal[vertex], view) * normal[vertex] - view
        position = tuple((place[vertex] + 1.5 * towards).tolist())
        lamps.append(Light(LightKind.POINT, position=position, power=5.0))
    return SceneData(
        meshes={"blade": mesh},
        materials={"steel": materials.blade_material(polished(), None)},
        instances=(Instance("blade", np.eye(4), ("steel",)),),
        lights=tuple(lamps),
    )


def luminance(
    renderer: Renderer, data: SceneData, camera: Camera, size: tuple[int, int]
) -> np.ndarray:
    picture = renderer.draw(data, camera, size, float32=True).read()[..., :3]
    return picture.astype(np.float64) @ LUMINANCE


def lit_tiles(bright: np.ndarray) -> Iterator[Region]:
    """Squares of the picture that hold every pixel with light, and those next to them."""
    wide = bright.copy()
    for axis in (0, 1):
        wide |= np.roll(wide, 1, axis) | np.roll(wide, -1, axis)
    for y in range(0, SIZE[1], TILE):
        for x in range(0, SIZE[0], TILE):
            part = wide[y : y + TILE, x : x + TILE]
            if part.any():
                rows, columns = np.flatnonzero(part.any(1)), np.flatnonzero(part.any(0))
                yield Region(
                    x + int(columns[0]),
                    y + int(rows[0]),
                    int(columns[-1] - columns[0]) + 1,
                    int(rows[-1] - rows[0]) + 1,
                )


def reference_energy(
    renderer: Renderer, data: SceneData, camera: Camera, bright: np.ndarray
) -> float:
    total = 0.0
    for region in lit_tiles(bright):
        view = Camera(camera.view, crop(camera.projection, SIZE, region))
        size = (region.width * SIDE, region.height * SIDE)
        total += float(luminance(renderer, data, view, size).sum())
    return total / SIDE**2


def changes(energy: np.ndarray, reference: np.ndarray) -> float:
    """Root mean square of what changes from picture to picture and should not, in shares of the mean energy."""
    error = (energy - reference) / reference.mean()
    return float(np.sqrt(np.mean(np.diff(error) ** 2)))


def plot(series: dict[str, np.ndarray]) -> str:
    figure, axes = pyplot.subplots(figsize=(6.4, 3.4), layout="constrained", dpi=110)
    styles = {
        "without": {"color": "#b4532a", "linewidth": 0.8},
        "with highlight anti-aliasing": {"color": "#2f5d8a", "linewidth": 1.4},
        "1024 samples a pixel": {"color": "black", "linewidth": 0.8, "linestyle": "--"},
    }
    for name, values in series.items():
        axes.plot(values / series["1024 samples a pixel"].mean(), label=name, **styles[name])
    axes.set_xlabel("picture of the orbit")
    axes.set_ylabel("light of the highlights, mean = 1")
    axes.grid(visible=True, linewidth=0.5, alpha=0.5)
    axes.legend(fontsize=8, frameon=False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    pyplot.close(figure)
    return base64.b64encode(buffer.getvalue()).decode()


def flicker(frames: int) -> tuple[list[Row], str]:
    data = scene()
    filtered = dataclasses.replace(data, filtered=True)
    # One for each: a Renderer keeps the programs and textures of one kind of picture.
    with_it, without, fine = Renderer(), Renderer(), Renderer()
    energies = np.zeros((3, frames))
    for frame in range(frames):
        camera = camera_at(ORBIT_DEG * (frame / max(frames - 1, 1) - 0.5))
        picture = luminance(with_it, filtered, camera, SIZE)
        plain = luminance(without, data, camera, SIZE)
        bright = (picture > 1e-5 * picture.max()) | (plain > 0.0)
        energies[:, frame] = (
            plain.sum(),
            picture.sum(),
            reference_energy(fine, data, camera, bright),
        )
        if frame % 20 == 0:
            print(f"      picture {frame} of {frames}", flush=True)
    off, on = (changes(energies[i], energies[2]) for i in (0, 1))
    how = f"{frames} pictures, {SIZE[0]}x{SIZE[1]}, katana, 6 point lamps, lobes .3 by .1 degrees, {ORBIT_DEG:g} degrees of orbit"
    mean = energies.mean(axis=1)
    rows = [
        Row("light.flicker_ratio", off / on, "", 10.0, ">=", how=how),
        Row("light.flicker_with_pct", 100 * on, "%", how="rms change of the error of the energy"),
        Row("light.flicker_without_pct", 100 * off, "%", how="the same"),
        Row("light.blade_energy_pct", 100 * abs(mean[1] / mean[2] - 1), "%", 10.0, "<=", how=how),
        Row("light.blade_energy_without_pct", 100 * abs(mean[0] / mean[2] - 1), "%", how=how),
    ]
    names = ("without", "with highlight anti-aliasing", "1024 samples a pixel")
    return rows, plot(dict(zip(names, energies, strict=True)))


def cost(frames: int) -> list[Row]:
    data = scene()
    scenes = {"without": data, "with": dataclasses.replace(data, filtered=True)}
    renderers = {name: Renderer() for name in scenes}

    def drawer(name: str):
        def draw(frame: int) -> None:
            camera = camera_at(0.05 * frame)
            bench_gpu.finish(renderers[name].draw(scenes[name], camera, SIZE).framebuffer)

        return draw

    times = bench_gpu.in_turns({name: drawer(name) for name in scenes}, frames, warm_up=4)
    ratio, spread = ratio_and_spread(times["with"], times["without"])
    how = f"{frames} pictures of each in turns, {SIZE[0]}x{SIZE[1]}, the camera moving"
    return [
        Row("light.flicker_time_ratio", ratio, "", spread=spread, how=f"{how}; goal 1.25"),
        *(
            Row(f"light.flicker_time_{name}_ms", 1000 * float(np.median(values)), "ms", how=how)
            for name, values in times.items()
        ),
    ]


def main() -> None:
    parser = command_line(__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=FRAMES)
    options = parser.parse_args()
    togishi.register()
    measured = Measurement(machine=bench_gpu.start())
    rows, picture = flicker(12 if options.quick else options.frames)
    measured.rows += rows
    measured.pictures["Light of a blade's highlights while the camera moves"] = picture
    measured.rows += cost(10 if options.quick else 60)
    write_measurement(options.out, measured)
    for row in measured.rows:
        print(f"      {row.id} {row.value:.4g} {row.unit}")
    togishi.unregister()


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    bench_gpu.leave()
