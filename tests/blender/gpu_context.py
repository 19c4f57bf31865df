"""A GPU context without a window. Imports Blender only when asked for one."""

from __future__ import annotations


def ensure_gpu_context() -> None:
    """Blender 5 makes one on request; Blender 4 makes one when it first draws."""
    import bpy
    import gpu

    if hasattr(gpu, "init"):
        gpu.init()
        return
    scene = bpy.data.scenes.new("gpu context")
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.camera = bpy.data.objects.new("gpu context", bpy.data.cameras.new("gpu context"))
    bpy.ops.render.render(scene=scene.name)
    bpy.data.cameras.remove(scene.camera.data)
    bpy.data.scenes.remove(scene)
