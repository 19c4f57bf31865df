"""Blender's cameras as the renderer's."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..core.scene_data import F64, Camera


@dataclass(frozen=True)
class Region:
    """A part of the whole picture, in pixels from the lower left corner."""

    x: int
    y: int
    width: int
    height: int


def whole_size(render: bpy.types.RenderSettings) -> tuple[int, int]:
    """The picture's size with the resolution's percentage."""
    share = render.resolution_percentage
    return max(render.resolution_x * share // 100, 1), max(render.resolution_y * share // 100, 1)


def border_region(render: bpy.types.RenderSettings, size: tuple[int, int]) -> Region:
    """What is rendered: all, or the border."""
    if not render.use_border:
        return Region(0, 0, *size)

    def edge(share: float, pixels: int, low: int, high: int) -> int:
        # In single precision, as Blender does: its result refuses a picture of another size.
        return min(max(int(np.float32(share) * np.float32(pixels)), low), high)

    left = edge(render.border_min_x, size[0], 0, size[0] - 1)
    bottom = edge(render.border_min_y, size[1], 0, size[1] - 1)
    right = edge(render.border_max_x, size[0], left + 1, size[0])
    top = edge(render.border_max_y, size[1], bottom + 1, size[1])
    return Region(left, bottom, right - left, top - bottom)


def crop(projection: F64, size: tuple[int, int], region: Region) -> F64:
    """The projection of one region of the picture alone."""
    result = projection.copy()
    for axis, (start, length, whole) in enumerate(
        ((region.x, region.width, size[0]), (region.y, region.height, size[1]))
    ):
        scale = whole / length
        centre = 2.0 * (start + 0.5 * length) / whole - 1.0
        result[axis] = scale * (projection[axis] - centre * projection[3])
    return result


def render_camera(
    engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, camera: bpy.types.Object
) -> Camera:
    """The scene's camera over the whole picture: shift, sensor fit, clipping, pixel aspect, stereo."""
    render = depsgraph.scene_eval.render
    width, height = whole_size(render)
    evaluated = camera.evaluated_get(depsgraph)
    projection = evaluated.calc_matrix_camera(
        depsgraph,
        x=width,
        y=height,
        scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y,
    )
    to_world = np.array(engine.camera_model_matrix(evaluated), np.float64).reshape(4, 4)
    # A camera's scale does not change what it sees.
    to_world[:3, :3] /= np.maximum(np.linalg.norm(to_world[:3, :3], axis=0), 1e-30)
    return Camera(np.linalg.inv(to_world), np.array(projection, np.float64))


def region_camera(region_3d: bpy.types.RegionView3D) -> Camera:
    """What a viewport sees."""
    return Camera(
        np.array(region_3d.view_matrix, np.float64), np.array(region_3d.window_matrix, np.float64)
    )
