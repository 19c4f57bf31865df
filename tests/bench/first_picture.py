"""Prints the time from opening a .blend to the first picture of our viewport. Run by viewport.py in a fresh process."""

from __future__ import annotations

import sys
import time

import bench_gpu
import bpy
import numpy as np
import togishi

SIZE = (1920, 1080)


def main(path: str) -> None:
    bench_gpu.start()
    togishi.register()
    started = time.perf_counter()
    bpy.ops.wm.open_mainfile(filepath=path)
    from togishi.core.scene_data import Camera
    from togishi.engine.renderer import Renderer
    from togishi.engine.scene_sync import SceneSync

    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = bpy.context.scene.camera
    view = Camera(
        np.array(camera.matrix_world.inverted(), np.float64),
        np.array(camera.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1]), np.float64),
    )
    picture = Renderer().draw(SceneSync().update(depsgraph), view, SIZE)
    bench_gpu.finish(picture.framebuffer)
    took = time.perf_counter() - started
    assert picture.read()[..., :3].max() > 0, "the picture is black"
    print(f"first picture {took:.3f} s")


if __name__ == "__main__":
    main(sys.argv[1])
    bench_gpu.leave()
