"""A GPU context without a window (docs: Mesa's llvmpipe will do)."""

from __future__ import annotations

import bpy

_ready = False


def ensure_gpu() -> None:
    """Make the `gpu` module usable. Blender 5 has gpu.init(); before it, a first picture by Workbench
    makes the context. Nothing may touch `gpu` before, or the process can crash."""
    global _ready
    if _ready:
        return
    import gpu

    if hasattr(gpu, "init"):
        gpu.init()
    else:
        scene = bpy.data.scenes.new("togishi gpu warm-up")
        scene.render.engine = "BLENDER_WORKBENCH"
        scene.render.resolution_x = scene.render.resolution_y = 8
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(scene.camera)
        bpy.ops.render.render(scene=scene.name)
        camera = scene.camera
        data = camera.data
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
    _ready = True
