"""A quad on which the angle between normal and half vector runs through a lobe: one picture is a scan.

Camera and sun stand straight above, so the half vector is z; custom normals lean by up to `reach_deg` to both sides
along x (which is the tangent) or along y."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np

SIDE = 2.0
ROWS = 256


def build_quad(
    reach_deg: float, axis: str, part: int, uv_map: str = "togishi_uv"
) -> bpy.types.Object:
    """A strip of quads with smooth custom normals and the attributes of a blade."""
    count = 64
    along = np.linspace(-1.0, 1.0, count + 1)
    vertices, normals = [], []
    for value in along:
        lean = math.radians(reach_deg) * value
        for side in (-1.0, 1.0):
            if axis == "x":
                vertices.append((value, side, 0.0))
                normals.append((math.sin(lean), 0.0, math.cos(lean)))
            else:
                vertices.append((-side, value, 0.0))
                normals.append((0.0, math.sin(lean), math.cos(lean)))
    faces = [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(count)]
    mesh = bpy.data.meshes.new("probe")
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("use_smooth", np.ones(count, bool))
    mesh.uv_layers.new(name=uv_map)
    mesh.attributes.new("togishi_part", "INT", "FACE").data.foreach_set(
        "value", np.full(count, part, np.int32)
    )
    tangent = np.tile(np.array([1.0, 0.0, 0.0], np.float32), len(mesh.loops))
    mesh.attributes.new("togishi_tangent", "FLOAT_VECTOR", "CORNER").data.foreach_set(
        "vector", tangent
    )
    corner = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corner)
    from togishi import blender_versions

    blender_versions.set_corner_normals(mesh, np.array(normals, np.float32)[corner])
    mesh.update()
    obj = bpy.data.objects.new("probe", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def scene_for(
    engine: str, pixels: tuple[int, int], world_grey: float = 0.0, sun: float = 1.0
) -> bpy.types.Scene:
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y = pixels
    scene.render.resolution_percentage = 100
    # Samples at the pixels' centres: the scan's positions are then exact.
    scene.render.filter_size = 0.01
    scene.cycles.pixel_filter_type = "GAUSSIAN"
    scene.cycles.filter_width = 0.01
    scene.view_settings.view_transform = "Raw"
    scene.render.dither_intensity = 0.0
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = SIDE
    camera.location = (0.0, 0.0, 3.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    if sun:
        light = bpy.data.lights.new("sun", "SUN")
        light.energy = sun
        light.angle = 0.0
        scene.collection.objects.link(bpy.data.objects.new("sun", light))
    from togishi import light_rig

    world = bpy.data.worlds.new("probe")
    scene.world = world
    light_rig.set_world_grey(world, world_grey)
    return scene


def picture(scene: bpy.types.Scene, folder: Any) -> np.ndarray:
    """Linear pixels (H, W, 3), row 0 at the bottom."""
    path = str(folder / "probe.exr")
    from togishi import blender_versions

    settings = scene.render.image_settings
    blender_versions.set_file_format(settings, "OPEN_EXR")
    settings.color_depth = "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path, check_existing=False)
    width, height = image.size
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, -1)[..., :3]
