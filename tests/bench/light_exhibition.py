"""The exhibition scene: three area lamps and an HDRI on an anisotropic blade with maps, a stand; 1920x1080, beside EEVEE.

Both sides draw it from the same camera in turns, in one process, while the lamps move: ours at the level of quality that it
has while something moves, whose error against the picture at rest is stated. Then ours at rest.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

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
from mathutils import Vector
from togishi.engine.render_engine import REST_S
from togishi.engine.renderer import read_texture
from viewport import Eevee, Ours
from viewport_scene import SIZE, BenchScene, build

Say = Callable[[str], None]
HDRI_SIZE = (1024, 512)


def room() -> bpy.types.Image:
    """A grey room with a bright ceiling and two windows, linear."""
    width, height = HDRI_SIZE
    up = np.linspace(-1.0, 1.0, height)[:, None] * np.ones((1, width))
    around = np.linspace(0.0, 1.0, width)[None, :] * np.ones((height, 1))
    grey = 0.02 + 0.05 * np.clip(up, 0.0, 1.0) ** 2
    for centre in (0.2, 0.65):
        grey += 1.5 * ((np.abs(around - centre) < 0.03) & (up > 0.05) & (up < 0.35))
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = grey[..., None] * (0.9, 1.0, 1.15)
    image = bpy.data.images.new("room", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels.reshape(-1))
    image.pack()
    return image


def exhibition() -> BenchScene:
    bench = build(maps=True)
    bench.lamps, bench.rest = bench.lamps[:3], bench.rest[:3]
    for extra in [o for o in bench.scene.objects if o.type == "LIGHT" and o not in bench.lamps]:
        bpy.data.objects.remove(extra)
    middle = bench.blade.matrix_world @ Vector((0.3, 0.0, 0.0))
    for lamp in bench.lamps:
        name = lamp.data.name
        lamp.data.type = "AREA"
        light = bpy.data.lights[name]  # of another class now
        light.shape, light.size, light.size_y, light.use_shadow = "RECTANGLE", 0.5, 0.15, False
        lamp.rotation_euler = (middle - lamp.location).to_track_quat("-Z", "Y").to_euler()
    nodes = bench.scene.world.node_tree
    texture = nodes.nodes.new("ShaderNodeTexEnvironment")
    texture.image = room()
    nodes.links.new(texture.outputs["Color"], nodes.nodes["Background"].inputs["Color"])
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=middle + Vector((0.0, -0.08, -0.12)))
    stand = bpy.context.object
    stand.scale = (0.2, 0.05, 0.15)
    matt = bpy.data.materials.new("stand")
    matt.use_nodes = True
    matt.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (
        0.1,
        0.05,
        0.03,
        1,
    )
    stand.data.materials.append(matt)
    bpy.context.view_layer.update()
    return bench


class Exhibited(Ours):
    """moving: the level of quality."""

    def __init__(self, bench: BenchScene, *, moving: bool) -> None:
        super().__init__(bench)
        self.moving = moving
        self.step = 1  # side of the pixels, as the viewport chooses it

    def draw(self, frame: int) -> None:
        self.bench.sweep(frame)
        scene = self.sync.update(bpy.context.evaluated_depsgraph_get())
        step = self.step
        if self.moving:
            picture, self.step = self.renderer.draw_moving(scene, self.bench.view(), SIZE, step)
        else:
            picture = self.renderer.draw(scene, self.bench.view(), SIZE)
        with self.screen.bind():
            framebuffer = gpu.state.active_framebuffer_get()
            framebuffer.clear(color=(0, 0, 0, 1))
            self.renderer.copy(picture.colour, step=step)
            framebuffer.read_color(0, 0, 1, 1, 4, 0, "FLOAT")


def errors(ours: Exhibited, bench: BenchScene) -> tuple[float, float]:
    """Largest and mean difference of the two levels as they are on the screen, % of the picture's brightest."""
    scene = ours.sync.update(bpy.context.evaluated_depsgraph_get())
    screen = gpu.types.GPUTexture(SIZE, format="RGBA32F")
    step = ours.step
    picture, _next = ours.renderer.draw_moving(scene, bench.view(), SIZE, step)
    with gpu.types.GPUFrameBuffer(color_slots=[screen]).bind():
        ours.renderer.copy(picture.colour, step=step)
    rough = read_texture(screen)[..., :3]
    fine = ours.renderer.draw(scene, bench.view(), SIZE, float32=True).read()[..., :3]
    apart = 100.0 * np.abs(rough - fine) / fine.max()
    return float(apart.max()), float(apart.mean())


def measure(quick: bool, say: Say) -> Measurement:
    machine = bench_gpu.start()
    togishi.register()
    frames = 2 if quick else 6
    bench = exhibition()
    eevee, moving = Eevee(bench), Exhibited(bench, moving=True)
    rest = Exhibited(bench, moving=False)
    times = bench_gpu.in_turns(
        {"EEVEE": eevee.draw, "moving": moving.draw, "rest": rest.draw},
        frames,
        # Programs are compiled, then the pixels reach the size that this machine needs.
        warm_up=4,
        progress=lambda text: say(f"      {text}"),
    )
    largest, mean = errors(moving, bench)
    ratio, spread = ratio_and_spread(times["moving"], times["EEVEE"])
    how = (
        f"{frames} frames in turns, {SIZE[0]}x{SIZE[1]}, 3 moving rectangles, HDRI of {HDRI_SIZE[0]}x{HDRI_SIZE[1]}, maps of 4096x512, a stand; "
        "EEVEE: one Principled BSDF with the same images, 1 sample, no shadows, no ray tracing"
    )
    coarse = f"{how}; ours drew pixels of {moving.step} x {moving.step} of the screen's, as it chooses on this machine"
    rows = [
        Row("light.ratio_eevee_moving", ratio, "", 0.7, "<=", spread, coarse),
        Row("light.moving_pixel", moving.step, "px", how="side of a pixel while something moves"),
        Row(
            "light.moving_error_max_pct",
            largest,
            "%",
            how="of the brightest, what the screen shows while something moves against the picture at rest",
        ),
        Row(
            "light.moving_error_mean_pct",
            mean,
            "%",
            how="of the brightest, what the screen shows while something moves against the picture at rest",
        ),
    ]
    for name, seconds in times.items():
        middle, around = median_and_spread(np.array(seconds) * 1e3)
        rows.append(
            Row(f"light.exhibition.{name.lower()}_ms", middle, "ms", spread=around, how=how)
        )
        say(f"      {name}: {middle:.0f} ms")
    refined, around = median_and_spread(np.array(times["rest"]) + REST_S)
    rows.append(
        Row(
            "light.refined_s",
            refined,
            "s",
            1.0,
            "<=",
            around,
            f"from the last change to the refined picture: {REST_S} s of rest and its drawing",
        ),
    )
    say(
        f"      moving: ratio {ratio:.3f}, off by {largest:.1f} / {mean:.3f} %; refined after {refined:.2f} s"
    )
    return Measurement(rows, machine=machine)


if __name__ == "__main__":
    options = command_line(__doc__ or "").parse_args()
    write_measurement(
        options.out, measure(options.quick, lambda text: print(text, file=sys.stdout, flush=True))
    )
    bench_gpu.leave()
