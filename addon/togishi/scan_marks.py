"""A scanned blade's dimensions drawn over it in the 3-D view: a line where each was measured, with its value."""

from __future__ import annotations

from itertools import pairwise

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from . import blade_object, scan_import
from .core import scan_report

LINE, TEXT = (0.95, 0.62, 0.15, 0.9), (1.0, 0.9, 0.75, 1.0)
TEXT_POINTS = 11

# The report is JSON: parsed once per text, not at every draw.
_parsed: dict[str, list[scan_report.Line]] = {}


def lines_of(obj: bpy.types.Object) -> list[scan_report.Line]:
    text = obj.togishi.scan.report_json
    if text not in _parsed:
        _parsed.clear()
        _parsed[text] = scan_report.lines(scan_import.report_of(obj)["dimensions"])
    return _parsed[text]


def _draw() -> None:
    context = bpy.context
    if not context.space_data.overlay.show_overlays:
        return
    obj = scan_import.scanned_blade(context)
    if obj is None or not obj.togishi.scan.show_dimensions or not obj.visible_get():
        return
    # Not above: the add-on is enabled where there is no GPU.
    import blf
    import gpu
    from gpu_extras.batch import batch_for_shader

    scale = bpy.context.preferences.system.ui_scale or 1.0
    unit_m = obj.togishi.scan.unit_m
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    blend = gpu.state.blend_get()
    gpu.state.blend_set("ALPHA")
    ends, texts = [], []
    for line in lines_of(obj):
        places = [
            view3d_utils.location_3d_to_region_2d(
                context.region,
                context.region_data,
                obj.matrix_world @ Vector([v * blade_object.MM / unit_m for v in point]),
            )
            for point in line.points_mm
        ]
        if any(place is None for place in places):
            continue
        for a, b in pairwise(places):
            ends += [(a[0], a[1], 0.0), (b[0], b[1], 0.0)]
        texts.append((0.5 * (places[0] + places[-1]), line.text))
    if ends:
        shader.uniform_float("color", LINE)
        batch_for_shader(shader, "LINES", {"pos": ends}).draw(shader)
    blf.size(0, TEXT_POINTS * scale)
    blf.color(0, *TEXT)
    taken: list[tuple[float, float, float]] = []
    for place, text in texts:
        x, y = place[0] + 6 * scale, place[1] + 4 * scale
        width, height = blf.dimensions(0, text)
        # Labels of lines that lie together are put above one another.
        while any(
            abs(y - ty) < height + 2 * scale and x < tx + tw and tx < x + width
            for tx, ty, tw in taken
        ):
            y += height + 3 * scale
        taken.append((x, y, width))
        blf.position(0, x, y, 0.0)
        blf.draw(0, text)
    gpu.state.blend_set(blend)


_handle: list[object] = []


def register() -> None:
    _handle.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    while _handle:
        bpy.types.SpaceView3D.draw_handler_remove(_handle.pop(), "WINDOW")
