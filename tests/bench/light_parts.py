"""What each part of the light costs where a scene has it but hardly uses it: what a scene without it saves, as its programs
hold none of it.

    python tests/bench/light_parts.py --out ROWS

One blade with maps under one small lamp, 960x540, at rest. Beside it the same scene with the part: a lamp too dim to be
seen, surroundings as dim, a thing far away that could cast a shadow or be mirrored, a white picture.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable

import bench_gpu
import bpy
import numpy as np
import togishi
from bench_rows import Measurement, Row, command_line, ratio_and_spread, write_measurement
from togishi.core.scene_data import (
    Instance,
    LampPicture,
    Light,
    LightKind,
    MeshData,
    MeshGroup,
    PlainMaterial,
    SceneData,
    World,
)
from togishi.core.surroundings import prepare
from togishi.engine.renderer import Renderer
from togishi.engine.scene_sync import SceneSync
from viewport_scene import build

Say = Callable[[str], None]
SIZE = (960, 540)
DIM = 1.0e-6
DOWN = {"x_axis": (1.0, 0.0, 0.0), "y_axis": (0.0, 1.0, 0.0), "z_axis": (0.0, 0.0, 1.0)}


def far_thing() -> MeshData:
    corners = np.array([(0, 0, -1e4), (1, 0, -1e4), (0, 1, -1e4)], np.float32)
    normal = np.tile(np.array((0, 0, 1, 0), np.float32), (3, 1))
    return MeshData(
        corners, normal, None, None, (MeshGroup(0, False, np.array([[0, 1, 2]], np.uint32)),)
    )


def scenes(base: SceneData) -> dict[str, tuple[SceneData, SceneData]]:
    """Of each part: the scene with it and the one without."""
    lamp = dataclasses.replace(base.lights[0], shadows=False)
    blade = dataclasses.replace(base, lights=(lamp,), world=World(), mirror_things=False)
    away = dataclasses.replace(
        blade,
        meshes={**base.meshes, "far": far_thing()},
        materials={**base.materials, "far": PlainMaterial()},
        instances=(*base.instances, Instance("far", np.eye(4), ("far",))),
    )
    rectangle = Light(
        LightKind.RECTANGLE, position=(0.3, -0.4, 0.8), power=DIM, half_u=0.2, half_v=0.1, **DOWN
    )  # fmt: skip
    lit = dataclasses.replace(blade, lights=(lamp, rectangle))
    white = LampPicture(np.ones((64, 64, 3), np.float32))
    room = prepare(np.full((64, 128, 3), 0.5, np.float32))

    def more(light: Light) -> SceneData:
        return dataclasses.replace(blade, lights=(lamp, light))

    dim = {"position": (0.3, -0.4, 0.8), "power": DIM}
    return {
        "spots": (more(Light(LightKind.SPOT, **dim)), blade),
        "suns": (more(Light(LightKind.SUN, power=DIM)), blade),
        "rectangles": (lit, blade),
        "rounds": (more(Light(LightKind.POINT, radius=0.1, **dim)), blade),
        "pictures": (
            more(dataclasses.replace(rectangle, picture=white)),
            lit,
        ),
        "environment": (
            dataclasses.replace(blade, world=World((DIM, DIM, DIM), environment=room)),
            blade,
        ),
        "world": (dataclasses.replace(blade, world=World((DIM, DIM, DIM))), blade),
        "shadows": (
            dataclasses.replace(away, lights=(dataclasses.replace(lamp, shadows=True),)),
            away,
        ),
        "mirror": (dataclasses.replace(away, mirror_things=True), away),
        "filter": (dataclasses.replace(blade, filtered=True), dataclasses.replace(blade, filtered=False)),
    }  # fmt: skip


def measure(quick: bool, say: Say) -> Measurement:
    machine = bench_gpu.start()
    togishi.register()
    frames = 3 if quick else 9
    bench = build(maps=True)
    base = SceneSync().update(bpy.context.evaluated_depsgraph_get())
    renderer = Renderer()
    rows = []

    def drawer(scene: SceneData) -> Callable[[int], None]:
        return lambda _frame: renderer.draw(scene, bench.view(), SIZE).framebuffer.read_color(
            0, 0, 1, 1, 4, 0, "FLOAT"
        )

    for name, (having, lacking) in scenes(base).items():
        times = bench_gpu.in_turns({"with": drawer(having), "without": drawer(lacking)}, frames)
        ratio, spread = ratio_and_spread(times["with"], times["without"])
        rows.append(
            Row(
                f"light.saving.{name}_ratio",
                ratio,
                "",
                spread=spread,
                how=f"a frame of {SIZE[0]}x{SIZE[1]} with the part, hardly used, over one without it; {frames} in turns",
            )
        )
        say(f"      {name}: {ratio:.2f}")
    return Measurement(rows, machine=machine)


if __name__ == "__main__":
    options = command_line(__doc__ or "").parse_args()
    write_measurement(
        options.out, measure(options.quick, lambda text: print(text, file=sys.stdout, flush=True))
    )
    bench_gpu.leave()
