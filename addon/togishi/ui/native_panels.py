"""What a user sees where the native module or the graphics card cannot be used: why, and what to do."""

from __future__ import annotations

import textwrap

import bpy

from .. import graphics
from ..core import native


def problem() -> str:
    """Why Togishi cannot be used, or why its engine cannot draw, and what to do; "" when all is well."""
    # Without a window there may be no GPU context to ask; nobody reads panels there.
    return native.problem() or ("" if bpy.app.background else graphics.problem())


def draw_problem(layout: bpy.types.UILayout, width: int = 40) -> None:
    column = layout.box().column(align=True)
    column.scale_y = 0.8  # lines of one sentence
    lines = textwrap.wrap(problem(), width)
    for index, line in enumerate(lines):
        column.label(text=line, icon="ERROR" if index == 0 else "BLANK1")


class TOGISHI_PT_problem(bpy.types.Panel):
    bl_label = "Togishi cannot run"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Togishi"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return bool(problem())

    def draw(self, context: bpy.types.Context) -> None:
        draw_problem(self.layout, max(24, context.region.width // 8) if context.region else 40)


CLASSES = (TOGISHI_PT_problem,)
