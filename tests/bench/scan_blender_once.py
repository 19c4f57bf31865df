"""Imports one scan in Blender and draws it; prints JSON: seconds, peak memory, steps. Run by scan_blender.py in a fresh
process, so that time and memory are its own."""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path

import bench_gpu
import bpy
import numpy as np
import togishi

SIZE = (1920, 1080)


def peak_gib() -> float:
    line = next(
        line
        for line in Path("/proc/self/status").read_text().splitlines()
        if line.startswith("VmHWM")
    )
    return int(line.split()[1]) / 2**20  # KiB


def draw(blade: bpy.types.Object) -> float:
    """One frame of Togishi's viewport, the whole blade under a sun. Returns its brightest value."""
    from togishi.core.scene_data import Camera
    from togishi.engine.renderer import Renderer
    from togishi.engine.scene_sync import SceneSync

    scene = bpy.context.scene
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.rotation_euler = (math.radians(-80), 0.0, 0.0)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    length_m = blade.dimensions.x
    camera.location = (0.35 * length_m, 2.0 * length_m, 0.0)  # omote looks to +Y
    camera.rotation_euler = (math.radians(90), 0.0, math.radians(180))
    for obj in (sun, camera):
        scene.collection.objects.link(obj)
    scene.render.engine = "TOGISHI"
    depsgraph = bpy.context.evaluated_depsgraph_get()
    view = Camera(
        np.array(camera.matrix_world.inverted(), np.float64),
        np.array(camera.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1]), np.float64),
    )
    picture = Renderer().draw(SceneSync().update(depsgraph), view, SIZE)
    bench_gpu.finish(picture.framebuffer)
    return float(picture.read()[..., :3].max())


def main(path: str) -> None:
    machine = bench_gpu.start()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    togishi.register()
    started, started_cpu = time.perf_counter(), time.process_time()
    assert bpy.ops.import_scene.togishi_scan(filepath=path) == {"FINISHED"}
    imported_s, imported_gib = time.perf_counter() - started, peak_gib()
    blade = bpy.context.view_layer.objects.active
    assert blade.data.materials[0].togishi.normal_image is not None
    brightest = draw(blade)
    seconds = time.perf_counter() - started
    assert brightest > 0, "the picture is black"
    from togishi import scan_import

    found = {
        "seconds": seconds,
        "cpu_s": time.process_time() - started_cpu,
        "peak_gib": peak_gib(),
        "imported_s": imported_s,
        "imported_gib": imported_gib,
        "faces": len(blade.data.polygons),
        "steps": scan_import.report_of(blade)["seconds"],
        "machine": machine,
    }
    print("RESULT " + json.dumps(found), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
    bench_gpu.leave()
