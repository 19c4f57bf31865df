"""What a review found in the engine: borders, doubled curves, lamps without Normalize, links through Reroutes."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from test_engine_blender import add_camera, add_light, scene  # noqa: F401
from togishi import blender_versions
from togishi.engine.camera_read import border_region, whole_size
from togishi.engine.light_read import read_light

pytestmark = pytest.mark.gpu


def test_border_has_blenders_size(scene):  # noqa: F811
    """Blender multiplies in single precision: its result refuses a picture that is a pixel larger."""
    add_camera(scene)
    render = scene.render
    render.resolution_x = render.resolution_y = 100
    render.use_border = render.use_crop_to_border = True
    scene.togishi.samples = 1
    for low, high in ((0.7, 1.0), (0.29, 0.58), (0.01, 0.57)):
        render.border_min_x = render.border_min_y = low
        render.border_max_x = render.border_max_y = high
        first, last = (int(np.float32(v) * np.float32(100)) for v in (low, high))
        region = border_region(render, (100, 100))
        assert (region.x, region.width, region.height) == (first, last - first, last - first)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath, check_existing=False)
        assert tuple(image.size) == (last - first, last - first)


def test_percentage_in_whole_numbers(empty_file):
    render = empty_file.render
    for pixels, percentage in ((1000, 29), (100, 57), (1920, 33), (4, 10)):
        render.resolution_x, render.resolution_y = pixels, pixels
        render.resolution_percentage = percentage
        expected = max(pixels * percentage // 100, 1)
        assert whole_size(render) == (expected, expected)
