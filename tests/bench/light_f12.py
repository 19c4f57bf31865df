"""Final pictures of the exhibition scene: how long ours and Cycles' take to come within 5 and 1 % of their own converged ones.

    python tests/bench/light_f12.py --out ROWS

Cycles has the add-on's node group on the blade and the same lamps, HDRI and stand, on the CPU. A picture's time is all of it: reading
the scene, preparing it (programs and the HDRI on our side, the light tree and the importance map on theirs), and its samples.
"""

from __future__ import annotations

import base64
import io
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import bench_gpu
import bpy
import matplotlib as mpl
import numpy as np
import togishi
from bench_rows import Measurement, Row, command_line, write_measurement
from light_exhibition import exhibition
from togishi import blade_object
from togishi.engine import final_render
from togishi.engine.camera_read import Region
from togishi.engine.renderer import Renderer
from togishi.engine.scene_sync import SceneSync
from togishi.nodes import steel_group
from viewport_scene import BenchScene

mpl.use("agg")
from matplotlib import pyplot

SIZE = (480, 270)
# Rec.709
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
OURS = (1, 2, 4, 8, 16)
CYCLES = (1, 4, 16, 64, 128)
CONVERGED = {"ours": 128, "Cycles": 512}
PERCENT = (5, 1)


@dataclass
class Point:
    samples: int
    seconds: float
    error_pct: float


def ours(bench: BenchScene, samples: int) -> np.ndarray:
    """What a final render does, without Blender's saving of it. Luminance."""
    data = SceneSync().update(bpy.context.evaluated_depsgraph_get())
    picture = final_render.render_final(
        Renderer(), data, bench.view(), SIZE, Region(0, 0, *SIZE), samples=samples
    )
    assert picture is not None
    return picture.colour[..., :3].astype(np.float64) @ LUMINANCE


@contextmanager
def quiet() -> Iterator[None]:
    """Without the lines that Blender prints of each stage of a render."""
    sys.stdout.flush()
    kept = os.dup(1)
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def prepare_cycles(bench: BenchScene) -> None:
    steel_group.connect(bench.material)
    blade_object.turn_tangents(bench.blade.data)
    scene = bench.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.use_persistent_data = False
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    # Lamps and surroundings without light between objects: what ours draws, and the least work for Cycles.
    cycles.max_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0


def theirs(bench: BenchScene, samples: int, folder: Path) -> np.ndarray:
    scene = bench.scene
    scene.cycles.samples, scene.cycles.seed = samples, samples
    scene.render.filepath = str(folder / "cycles.exr")
    with quiet():
        bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    flat = np.empty(SIZE[0] * SIZE[1] * 4, np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(SIZE[1], SIZE[0], 4)[..., :3].astype(np.float64) @ LUMINANCE


def curve(
    draw: Callable[[int], np.ndarray],
    counts: tuple[int, ...],
    converged: int,
    name: str,
    *,
    random: bool,
) -> list[Point]:
    """Root mean square of the difference from the converged picture, in % of that picture's mean. random: samples of
    different counts are independent, so that the converged picture's own noise can be taken off."""
    taken = []
    for count in counts:
        started = time.perf_counter()
        picture = draw(count)
        taken.append((count, time.perf_counter() - started, picture))
    reference = draw(converged)
    points = []
    for count, seconds, picture in taken:
        error = 100 * float(np.sqrt(np.mean((picture - reference) ** 2)) / reference.mean())
        if random:
            error /= math.sqrt(1.0 + count / converged)
        points.append(Point(count, seconds, error))
        print(f"      {name}: {count} samples, {seconds:.2f} s, {error:.2f} %", flush=True)
    return points


def samples_to(points: list[Point], percent: float) -> float:
    """On the line in logarithms between measured counts; beyond the last on that of the last two. (The square root of
    random samples would be too much to ask of Cycles, whose samples are better spread.) A curve that is within at its
    first point needs that one."""
    if points[0].error_pct <= percent:
        return float(points[0].samples)
    for low, high in pairwise(points):
        if high.error_pct <= percent < low.error_pct:
            share = math.log(low.error_pct / percent) / math.log(low.error_pct / high.error_pct)
            return low.samples * (high.samples / low.samples) ** share
    low, high = points[-2:]
    slope = math.log(low.error_pct / high.error_pct) / math.log(high.samples / low.samples)
    return high.samples * (high.error_pct / percent) ** (1.0 / max(slope, 0.5))


def seconds_of(points: list[Point], samples: float) -> float:
    """A fixed part and one for each sample, from the fewest and the most samples."""
    first, last = points[0], points[-1]
    each = (last.seconds - first.seconds) / (last.samples - first.samples)
    return first.seconds + each * (samples - first.samples)


def plot(curves: dict[str, list[Point]]) -> str:
    figure, axes = pyplot.subplots(figsize=(6.4, 4.0), layout="constrained", dpi=110)
    for (name, points), colour in zip(curves.items(), ("#2f5d8a", "#b4532a"), strict=True):
        seconds, errors = [p.seconds for p in points], [p.error_pct for p in points]
        axes.plot(seconds, errors, marker="o", color=colour, label=name)
        for point in points:
            axes.annotate(
                str(point.samples),
                (point.seconds, point.error_pct),
                (5, 4),
                textcoords="offset points",
                fontsize=8,
            )
    for percent in PERCENT:
        axes.axhline(percent, color="black", linewidth=0.6, linestyle=":")
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(mpl.ticker.StrMethodFormatter("{x:g}"))
    axes.margins(0.08)
    axes.xaxis.set_minor_locator(mpl.ticker.LogLocator(subs=(2, 5)))
    axes.xaxis.set_minor_formatter(mpl.ticker.StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(mpl.ticker.NullFormatter())
    axes.set_xlabel("time of the whole picture, s; numbers: samples a pixel")
    axes.set_ylabel("error, % of the picture's mean (rms)")
    axes.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    axes.legend(fontsize=8, frameon=False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    pyplot.close(figure)
    return base64.b64encode(buffer.getvalue()).decode()


def measure(quick: bool) -> Measurement:
    machine = bench_gpu.start()
    togishi.register()
    final_render.MAX_SAMPLES = CONVERGED["ours"]
    bench = exhibition()
    bench.scene.render.film_transparent = True
    divide = 8 if quick else 1
    ours(bench, 1)  # programs that the driver has not seen yet
    of_ours = curve(
        lambda count: ours(bench, count),
        OURS[:3] if quick else OURS,
        CONVERGED["ours"] // divide,
        "ours",
        random=False,
    )
    prepare_cycles(bench)
    with tempfile.TemporaryDirectory() as folder:
        of_cycles = curve(
            lambda count: theirs(bench, count, Path(folder)),
            CYCLES[:4] if quick else CYCLES,
            CONVERGED["Cycles"] // divide,
            "Cycles",
            random=True,
        )
    rows = []
    for percent in PERCENT:
        need = {
            name: samples_to(points, percent)
            for name, points in (("ours", of_ours), ("Cycles", of_cycles))
        }
        seconds = (seconds_of(of_ours, need["ours"]), seconds_of(of_cycles, need["Cycles"]))
        rows.append(
            Row(
                f"light.f12_ratio_cycles_{percent}pct",
                seconds[1] / seconds[0],
                "",
                10.0,
                ">=",
                how=f"Cycles' time over ours, the whole picture; {SIZE[0]}x{SIZE[1]}; rms over the picture's mean, luminance; ours {need['ours']:.3g} samples in "
                f"{seconds[0]:.3g} s, Cycles {need['Cycles']:.4g} in {seconds[1]:.3g} s (CPU, no light between objects, no denoiser"
                + "".join(
                    f"; samples of {name} beyond the {points[-1].samples} measured as the last two fall"
                    for name, points in (("ours", of_ours), ("Cycles", of_cycles))
                    if need[name] > points[-1].samples
                )
                + ")",
            )
        )
    for name, points in (("ours", of_ours), ("cycles", of_cycles)):
        rows += [
            Row(
                f"light.f12.{name}_{point.samples}.error_pct",
                point.error_pct,
                "%",
                how=f"{point.samples} samples, {point.seconds:.3g} s",
            )
            for point in points
        ]
    picture = plot({"ours, on this GPU": of_ours, "Cycles with our node group, CPU": of_cycles})
    return Measurement(
        rows, machine=machine, pictures={"Final pictures: error against time": picture}
    )


if __name__ == "__main__":
    options = command_line(__doc__.splitlines()[0]).parse_args()
    measured = measure(options.quick)
    write_measurement(options.out, measured)
    for row in measured.rows:
        print(f"      {row.id} {row.value:.4g} {row.unit}", flush=True)
    togishi.unregister()
    sys.stdout.flush()
    bench_gpu.leave()
