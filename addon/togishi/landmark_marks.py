"""Landmarks drawn where they are: a cross and a name in the Image Editor that shows the photograph, and on the blade
in the 3-D view, the chosen one bright."""

from __future__ import annotations

from typing import NamedTuple

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from . import blade_object, photographs

ARM_PX = 7.0
PLAIN, CHOSEN = (0.95, 0.62, 0.15, 0.9), (1.0, 1.0, 1.0, 1.0)
TEXT_POINTS = 11


class Mark(NamedTuple):
    """A landmark in a region, in pixels from its lower left corner."""

    x: float
    y: float
    name: str
    chosen: bool


def in_photograph(
    kept: photographs.TogishiPhotographs, view: bpy.types.View2D, image: bpy.types.Image | None
) -> list[Mark]:
    """Those that are marked, where this editor shows the photograph."""
    if image is None or image != kept.photograph:
        return []
    width, height = image.size
    if not (width and height):
        return []
    marks = []
    for index, one in enumerate(kept.landmarks):
        if one.has_pixel:
            x, y = view.view_to_region(
                one.pixel[0] / width, 1.0 - one.pixel[1] / height, clip=False
            )
            marks.append(Mark(x, y, one.name, index == kept.active_landmark))
    return marks


def on_blade(
    kept: photographs.TogishiPhotographs,
    blade: bpy.types.Object,
    unit_m: float,
    region: bpy.types.Region,
    view: bpy.types.RegionView3D,
) -> list[Mark]:
    """Those that have a place, where the view shows the blade."""
    marks = []
    for index, one in enumerate(kept.landmarks):
        if not one.has_point:
            continue
        local = [v * blade_object.MM / unit_m for v in one.point_mm]
        world = blade.matrix_world @ Vector(local)
        at = view3d_utils.location_3d_to_region_2d(region, view, world)
        if at is not None:
            marks.append(Mark(at[0], at[1], one.name, index == kept.active_landmark))
    return marks


def draw(marks: list[Mark]) -> None:
    """Crosses and names, in the region's pixels."""
    if not marks:
        return
    # Not above: the add-on is enabled where there is no GPU.
    import blf
    import gpu
    from gpu_extras.batch import batch_for_shader

    scale = bpy.context.preferences.system.ui_scale or 1.0  # 0 without a window
    arm = ARM_PX * scale
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    blend = gpu.state.blend_get()
    gpu.state.blend_set("ALPHA")
    for chosen, colour in ((False, PLAIN), (True, CHOSEN)):
        lines = [
            end
            for mark in marks
            if mark.chosen == chosen
            for end in (
                (mark.x - arm, mark.y, 0.0),
                (mark.x + arm, mark.y, 0.0),
                (mark.x, mark.y - arm, 0.0),
                (mark.x, mark.y + arm, 0.0),
            )
        ]
        if lines:
            shader.uniform_float("color", colour)
            batch_for_shader(shader, "LINES", {"pos": lines}).draw(shader)
    blf.size(0, TEXT_POINTS * scale)
    for mark in marks:
        blf.color(0, *(CHOSEN if mark.chosen else PLAIN))
        blf.position(0, mark.x + arm, mark.y + arm, 0.0)
        blf.draw(0, mark.name)
    gpu.state.blend_set(blend)


def _draw_in_photograph() -> None:
    context = bpy.context
    kept = context.scene.togishi_photographs
    if kept.landmarks:
        draw(in_photograph(kept, context.region.view2d, context.space_data.image))


def _draw_on_blade() -> None:
    context = bpy.context
    kept = context.scene.togishi_photographs
    if not kept.landmarks or not context.space_data.overlay.show_overlays:
        return
    blade = blade_object.find_blade(context)
    if blade is None or not blade.togishi.katana_json:
        return
    unit_m = context.scene.unit_settings.scale_length or 1.0
    draw(on_blade(kept, blade, unit_m, context.region, context.region_data))


_HANDLERS = {"SpaceImageEditor": _draw_in_photograph, "SpaceView3D": _draw_on_blade}
_added: list[tuple[type, object]] = []


def register() -> None:
    for space, handler in _HANDLERS.items():
        kind = getattr(bpy.types, space)
        _added.append((kind, kind.draw_handler_add(handler, (), "WINDOW", "POST_PIXEL")))


def unregister() -> None:
    while _added:
        kind, handle = _added.pop()
        kind.draw_handler_remove(handle, "WINDOW")
