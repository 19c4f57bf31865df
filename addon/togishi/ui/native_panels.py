"""What a user sees where the native module cannot be used: why, and what to do."""

from __future__ import annotations

import textwrap

import bpy

from ..core import native


def draw_problem(layout: bpy.types.UILayout, width: int = 40) -> None:
    box = layout.box()
    lines = textwrap.wrap(native.problem(), width)
    for index, line in enumerate(lines):
        box.label(text=line, icon="ERROR" if index == 0 else "BLANK1")


class TOGISHI_PT_problem(bpy.types.Panel):
    bl_label = "Togishi cannot run"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Togishi"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return bool(native.problem())

    def draw(self, context: bpy.types.Context) -> None:
        draw_problem(self.layout, max(24, context.region.width // 8) if context.region else 40)


CLASSES = (TOGISHI_PT_problem,)
