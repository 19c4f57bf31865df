"""What a user sees where the native module or the graphics card cannot be used: why, and what to do."""

from __future__ import annotations

import bpy

from .. import graphics
from ..core import native
from .sentences import draw_sentence


def problem() -> str:
    """Why Togishi cannot be used, or why its engine cannot draw, and what to do; "" when all is well."""
    # Without a window there may be no GPU context to ask; nobody reads panels there.
    return native.problem() or ("" if bpy.app.background else graphics.problem())


class TOGISHI_PT_problem(bpy.types.Panel):
    bl_label = "Togishi cannot run"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Togishi"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return bool(problem())

    def draw(self, _context: bpy.types.Context) -> None:
        draw_sentence(self.layout.box(), problem(), icon="ERROR")


CLASSES = (TOGISHI_PT_problem,)
