"""A scanned sword: what was found, and the user's corrections."""

from __future__ import annotations

from pathlib import Path

import bpy

from .. import scan_import
from ..core import native, scan_report
from .sentences import draw_pairs, draw_sentence


class TOGISHI_PT_view_scan(bpy.types.Panel):
    bl_label = "Scanned Sword"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Togishi"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return not native.problem()

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator("import_scene.togishi_scan", text="Import Scanned Sword…", icon="IMPORT")
        obj = scan_import.scanned_blade(context)
        if obj is None:
            return
        report = scan_import.report_of(obj)
        layout.label(text=Path(obj.togishi.scan.filepath).name, icon="FILE_TICK")
        draw_sentence(layout, report["verdict"]["text"])
        draw_sentence(layout, report["unit"]["text"])
        for sentence in report["notes"]:
            draw_sentence(layout, sentence, "INFO")
        draw_pairs(layout, scan_report.rows(report["dimensions"]))
        layout.prop(obj.togishi.scan, "show_dimensions")
        row = layout.row(align=True)
        row.operator_menu_enum("object.togishi_scan_correct", "change", text="Correct")
        row.operator("object.togishi_scan_handle", text="", icon="EMPTY_ARROWS")
        if context.mode == "EDIT_MESH":
            layout.operator_menu_enum("mesh.togishi_scan_paint_part", "part", text="Set Part")
        layout.operator("export_scene.togishi_scan_record", text="Save Record…", icon="EXPORT")


CLASSES = (TOGISHI_PT_view_scan,)
