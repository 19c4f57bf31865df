"""Frame times of our viewport beside EEVEE's and beside the 61-wavelength loop; first picture; a light's new spectrum.

Both sides draw the same blade from the same camera with the same four moving lamps at 1920x1080, in turns, in one process,
without overlays and without a view transform; a frame ends when a pixel of it has been read back.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import bench_gpu
import bpy
import gpu
import numpy as np
import togishi
from bench_rows import (
    Measurement,
    Row,
    command_line,
    median_and_spread,
    ratio_and_spread,
    write_measurement,
)
from togishi.engine.renderer import Renderer
from togishi.engine.scene_sync import SceneSync
from viewport_scene import SIZE, BenchScene, build, plain_eevee
from wavelength_loop import wavelengths_block

Say = Callable[[str], None]
MIN_COVERAGE = 0.25


# --- the two sides --------------------------------------------------------------------------------


class Ours:
    """What a viewport does for a picture after a change: evaluate, read what changed, draw, put on the screen."""

    def __init__(self, bench: BenchScene) -> None:
        self.bench = bench
        self.renderer, self.sync = Renderer(), SceneSync()
        self.screen = gpu.types.GPUOffScreen(*SIZE, format="RGBA16F")

    def draw(self, frame: int) -> None:
        self.bench.sweep(frame)
        scene = self.sync.update(bpy.context.evaluated_depsgraph_get())
        picture = self.renderer.draw(scene, self.bench.view(), SIZE)
        with self.screen.bind():
            framebuffer = gpu.state.active_framebuffer_get()
            framebuffer.clear(color=(0, 0, 0, 1))
            self.renderer.copy(picture.colour)
            framebuffer.read_color(0, 0, 1, 1, 4, 0, "FLOAT")


class Eevee:
    """EEVEE's own viewport drawing into a texture."""

    def __init__(self, bench: BenchScene) -> None:
        self.bench = bench
        plain_eevee(bench.scene)
        self.screen = gpu.types.GPUOffScreen(*SIZE, format="RGBA16F")
        window = bpy.context.window_manager.windows[0]
        area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
        self.space = area.spaces.active
        self.region = next(region for region in area.regions if region.type == "WINDOW")
        self.space.shading.type = "RENDERED"
        self.space.overlay.show_overlays = False
        self.space.show_gizmo = False

    def draw(self, frame: int) -> None:
        self.bench.sweep(frame)
        self.redraw()

    def redraw(self) -> None:
        """Where nothing has changed, EEVEE only shows its picture again."""
        bpy.context.evaluated_depsgraph_get()
        view, projection = self.bench.matrices()
        self.screen.draw_view3d(
            self.bench.scene,
            bpy.context.view_layer,
            self.space,
            self.region,
            view,
            projection,
            do_color_management=False,
        )
        with self.screen.bind():
            gpu.state.active_framebuffer_get().read_color(0, 0, 1, 1, 4, 0, "FLOAT")

    def picture(self) -> np.ndarray:
        buffer = self.screen.texture_color.read()
        buffer.dimensions = SIZE[0] * SIZE[1] * 4
        return np.array(buffer, np.float32).reshape(SIZE[1], SIZE[0], 4)


# --- rows -----------------------------------------------------------------------------------------


def against_eevee(name: str, maps: bool, frames: int, say: Say) -> list[Row]:
    bench = build(maps=maps)
    eevee, ours = Eevee(bench), Ours(bench)
    times = bench_gpu.in_turns(
        {"EEVEE": eevee.draw, "ours": ours.draw}, frames, progress=lambda text: say(f"      {text}")
    )
    unchanged = []
    for _ in range(5):
        started = time.perf_counter()
        eevee.redraw()
        unchanged.append((time.perf_counter() - started) * 1e3)
    covered = ours.renderer.gbuffer(
        ours.sync.update(bpy.context.evaluated_depsgraph_get()), bench.view(), SIZE
    ).covered
    coverage = float(covered.mean())
    assert coverage >= MIN_COVERAGE, f"the blade covers only {coverage:.0%} of the picture"
    seen = eevee.picture()[covered][:, :3].max(axis=1) > 0
    assert seen.mean() > 0.2, (
        f"EEVEE shows only {seen.mean():.0%} of the blade: not the same picture"
    )
    ratio, spread = ratio_and_spread(times["ours"], times["EEVEE"])
    our_ms, our_spread = median_and_spread(np.array(times["ours"]) * 1e3)
    their_ms, their_spread = median_and_spread(np.array(times["EEVEE"]) * 1e3)
    again_ms, again_spread = median_and_spread(unchanged[1:])
    say(f"      {name}: ours {our_ms:.0f} ms, EEVEE {their_ms:.0f} ms, ratio {ratio:.3f}")
    triangles = sum(len(polygon.vertices) - 2 for polygon in bench.blade.data.polygons)
    parts = "maps of 4096x512" if maps else "constant parts"
    how = (
        f"{frames} frames in turns, {SIZE[0]}x{SIZE[1]}, {triangles} triangles, {coverage:.0%} covered, 4 moving point lamps, {parts}; "
        "EEVEE: one Principled BSDF"
        + (" with the same images" if maps else "")
        + " (cheaper for it than the add-on's node group), 1 sample, no shadows, no ray tracing"
    )
    bound = {"ratio_eevee": 0.5, "ratio_eevee_maps": 0.7}[name]
    label = name.removeprefix("ratio_")
    return [
        Row(f"viewport.{name}", ratio, "", bound, "<=", spread, how),
        Row(
            f"viewport.{label}_ours_ms",
            our_ms,
            "ms",
            spread=our_spread,
            how="our frame in that comparison",
        ),
        Row(
            f"viewport.{label}_theirs_ms",
            their_ms,
            "ms",
            spread=their_spread,
            how="EEVEE's frame in that comparison",
        ),
        Row(
            f"viewport.{label}_theirs_unchanged_ms",
            again_ms,
            "ms",
            spread=again_spread,
            how="EEVEE's redraw where neither lamp nor camera has moved: it shows its picture again, shades nothing",
        ),
    ]


def against_61(maps: bool, frames: int, say: Say) -> tuple[float, tuple[float, float], str]:
    """Ratio of shading times, each less that of a picture without the blade."""
    bench = build(maps=maps)
    scene = SceneSync().update(bpy.context.evaluated_depsgraph_get())
    camera = bench.view()
    renderer = Renderer()
    material = next(iter(scene.materials.values()))
    spectra = list(dict.fromkeys(light.spectrum for light in scene.lights))
    renderer.wavelengths = wavelengths_block(material.steel.metal, spectra, scene.colour.space)
    empty = replace(scene, instances=())
    same = [
        renderer.draw(scene, camera, SIZE, bench_61=loop, float32=True).read()[..., :3]
        for loop in (False, True)
    ]
    error = np.abs(same[0] - same[1]).max() / same[1].max()
    assert error < 2e-3, f"the two shaders do not draw the same picture: {error:.1e} of the peak"

    def drawer(data, loop: bool, every_lamp: bool = False) -> Callable[[int], None]:
        own = Renderer()
        own.wavelengths = renderer.wavelengths
        return lambda _frame: bench_gpu.finish(
            own.draw(data, camera, SIZE, bench_61=loop, every_lamp=every_lamp).framebuffer
        )

    times = bench_gpu.in_turns(
        {
            "table": drawer(scene, False),
            "61": drawer(scene, True),
            "61 of every lamp": drawer(scene, True, every_lamp=True),
            "empty": drawer(empty, False),
        },
        frames,
    )
    nothing = float(np.median(times["empty"]))
    ratio, spread = ratio_and_spread(
        np.array(times["table"]) - nothing, np.array(times["61"]) - nothing
    )
    medians = {name: float(np.median(seconds)) * 1e3 for name, seconds in times.items()}
    described = ", ".join(f"{key} {value:.0f} ms" for key, value in medians.items())
    paper = (medians["table"] - medians["empty"]) / (medians["61 of every lamp"] - medians["empty"])
    described += f"; against a loop that computes every lamp, as the paper's does: {paper:.3f}"
    say(f"      {'maps' if maps else 'constant parts'}: {described}, ratio {ratio:.3f}")
    return ratio, spread, described


def rows_61(frames: int, say: Say) -> list[Row]:
    measured = {
        "with maps": against_61(True, frames, say),
        "constant parts": against_61(False, frames, say),
    }
    worst = max(measured, key=lambda name: measured[name][0])
    how = (
        "shading by the table over the same shader with the sum over 61 wavelengths, its Fresnel once per light, wavelength and "
        "model; time of an empty picture subtracted from both; the worse of maps and constant parts: "
    )
    rows = [
        Row(
            "viewport.ratio_61",
            measured[worst][0],
            "",
            1 / 8,
            "<=",
            measured[worst][1],
            f"{how}{worst}; {frames} frames: {measured[worst][2]}",
        )
    ]
    for name, (ratio, spread, described) in measured.items():
        rows.append(
            Row(
                f"viewport.ratio_61_{name.replace(' ', '_')}",
                ratio,
                "",
                spread=spread,
                how=described,
            )
        )
    return rows


def first_picture(runs: int, say: Say) -> Row:
    """In a fresh process with Blender running and the add-on enabled: from opening the file to the first picture."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "light_sweep.blend"
        build(maps=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
        seconds = []
        for _ in range(runs):
            done = subprocess.run(
                [sys.executable, str(Path(__file__).with_name("first_picture.py")), str(path)],
                capture_output=True,
                text=True,
                check=False,
            )
            line = next(
                (line for line in done.stdout.splitlines() if line.startswith("first picture ")),
                None,
            )
            if done.returncode != 0 or line is None:
                raise RuntimeError(f"first_picture.py: {done.stderr[-2000:]}")
            seconds.append(float(line.split()[2]))
    value, spread = median_and_spread(seconds)
    say(f"      first picture after {value:.2f} s")
    return Row(
        "viewport.first_picture_s",
        value,
        "s",
        2.0,
        "<=",
        spread,
        f"median of {runs} fresh processes, {SIZE[0]}x{SIZE[1]}, maps of 4096x512 packed in the file; Blender runs, the add-on is enabled, "
        "nothing of it was used before: opening, native module, reading, map levels, shaders, drawing",
    )


def light_update(repeats: int, say: Say) -> Row:
    """CPU time from a new spectrum on a lamp to its row on the GPU."""
    bench = build(maps=False)
    scene = SceneSync().update(bpy.context.evaluated_depsgraph_get())
    renderer = Renderer()
    bench_gpu.finish(renderer.draw(scene, bench.view(), (64, 36)).framebuffer)
    milliseconds = []
    for repeat in range(repeats):
        # Temperatures that were never asked for: nothing is kept of them.
        new = replace(scene.lights[0], spectrum=f"blackbody:{2500 + 3.7 * repeat:g}")
        changed = replace(scene, lights=(new, *scene.lights[1:]))
        started = time.thread_time()
        renderer.prepare_lights(changed)
        milliseconds.append((time.thread_time() - started) * 1e3)
    value, spread = median_and_spread(milliseconds)
    assert renderer.counters.mesh_uploads == 1, "a light's spectrum must not upload a mesh"
    say(f"      light's new spectrum: {value:.3f} ms")
    return Row(
        "viewport.light_update_ms",
        value,
        "ms",
        1.0,
        "<=",
        spread,
        f"median CPU time of {repeats} new blackbody spectra on one of four lamps: table row baked, packed and uploaded",
    )


def measure(quick: bool, say: Say) -> Measurement:
    machine = bench_gpu.start()
    togishi.register()
    frames = 3 if quick else 20
    rows = []
    rows += against_eevee("ratio_eevee", False, frames, say)
    rows += against_eevee("ratio_eevee_maps", True, frames, say)
    rows += rows_61(frames, say)
    rows.append(light_update(20 if quick else 200, say))
    rows.append(first_picture(1 if quick else 5, say))
    return Measurement(rows, machine=machine)


if __name__ == "__main__":
    options = command_line(__doc__ or "").parse_args()
    write_measurement(
        options.out, measure(options.quick, lambda text: print(text, file=sys.stdout, flush=True))
    )
    bench_gpu.leave()
