"""A scanned sword: the user's corrections of how it lies, of its unit, yokote and parts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty

from .. import blade_object, scan_handle, scan_import
from ..core import scan_pose, scan_report
from .poll import LINKED, NEEDS_OBJECT_MODE, allowed, local
from .scan_work import NEEDS_SCAN, ScanWork

# Corrections that ask for a value, and the setting that holds it.
_ASKS = {"unit": "unit", "yokote": "kissaki_mm"}


def _correctable(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    obj = scan_import.scanned_blade(context)
    return allowed(
        cls,
        (obj, NEEDS_SCAN),
        (obj is None or local(obj, obj.data), LINKED),
        (context.mode == "OBJECT", NEEDS_OBJECT_MODE),
    )


class TOGISHI_OT_scan_handle(bpy.types.Operator):
    """Put a handle at the blade's machi, X to the tip and Z to the back. Move it to where the machi is, or turn it
    the right way round; 'Take Pose Handle' then does all again"""

    bl_idname = "object.togishi_scan_handle"
    bl_label = "Pose Handle"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _correctable(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = scan_import.scanned_blade(context)
        assert obj is not None
        handle = scan_handle.find(obj) or scan_handle.add(obj)
        blade_object.select_only(context, handle)
        return {"FINISHED"}


class TOGISHI_OT_scan_correct(ScanWork, bpy.types.Operator):
    """Read the scan again with another idea of how the blade lies; what was measured, its parts and its chart follow.
    Materials stay; painted parts are taken over"""

    bl_idname = "object.togishi_scan_correct"
    bl_label = "Correct Scan"
    bl_options = {"REGISTER", "UNDO"}

    change: EnumProperty(
        name="Change",
        items=(
            ("swap_ends", "Swap Tip and Tang", "The other end is the tip; omote and ura follow"),
            (
                "swap_edge_and_back",
                "Swap Edge and Back",
                "The other side is the edge; omote and ura follow",
            ),
            ("yokote", "Yokote…", "Another place of the yokote, or none"),
            (
                "handle",
                "Take Pose Handle",
                "The machi is beside the handle; its X points to the tip, its Z to the back",
            ),
            ("unit", "Unit…", "Another unit of the file's numbers"),
            ("as_found", "As Found", "Without any of these corrections; the unit stays"),
        ),
    )
    unit: EnumProperty(
        name="Unit", items=[(name, name, "") for name in scan_report.UNITS], default="mm"
    )

    kissaki_mm: FloatProperty(
        name="Kissaki (mm)",
        description="Straight from the yokote on the mune to the tip, in mm. 0: this blade has no yokote",
        default=0.0,
        min=0.0,
        max=300.0,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _correctable(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if self.change == "yokote":
            self.kissaki_mm = self._found_kissaki_mm(context)
        if self.change in _ASKS:
            return context.window_manager.invoke_props_dialog(self)
        return self.execute(context)

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.prop(self, _ASKS[self.change])

    def _found_kissaki_mm(self, context: bpy.types.Context) -> float:
        report = scan_import.report_of(scan_import.scanned_blade(context))
        return next((d["value"] for d in report["dimensions"] if d["key"] == "kissaki_mm"), 0.0)

    def _options(self, context: bpy.types.Context, obj: bpy.types.Object) -> dict[str, Any]:
        options: dict[str, Any] = json.loads(obj.togishi.scan.options_json)
        if self.change == "unit":
            return {**options, "mm_per_unit": scan_report.UNITS[self.unit]}
        if self.change == "yokote":
            return {**options, "kissaki_mm": self.kissaki_mm}
        if self.change == "handle":
            context.view_layer.update()
            handle = scan_handle.find(obj)
            if handle is None:
                raise ValueError("There is no pose handle; 'Pose Handle' brings one")
            return scan_pose.corrected(options, *scan_handle.moved(obj, handle))
        if self.change == "as_found":
            return {k: v for k, v in options.items() if k not in scan_pose.CORRECTIONS}
        return {**options, self.change: not options.get(self.change, False)}

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = scan_import.scanned_blade(context)
        assert obj is not None
        self._uid = obj.session_uid
        path = Path(bpy.path.abspath(obj.togishi.scan.filepath))
        try:
            options = self._options(context, obj)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        painted = scan_import.painted(obj, options["mm_per_unit"])
        return self.begin_scan(context, path, options, painted, obj.togishi.scan.sha256)

    def take(self, context: bpy.types.Context, job: scan_import.ScanJob) -> set[str]:
        sword = self.found(job)
        if sword is None:
            return {"CANCELLED"}
        obj = scan_import.by_uid(self._uid)
        if obj is None:
            self.report({"WARNING"}, "The blade is gone; what was found was not kept")
            return {"CANCELLED"}
        scan_import.replace(context, obj, job, sword)
        scan_handle.put_back(obj)
        return {"FINISHED"}


class TOGISHI_OT_scan_paint_part(bpy.types.Operator):
    """Say which part the selected faces are (Edit Mode). It stays when the scan is corrected"""

    bl_idname = "mesh.togishi_scan_paint_part"
    bl_label = "Set Part"
    bl_options = {"REGISTER", "UNDO"}

    part: EnumProperty(
        name="Part",
        items=(
            ("1", "Ji", ""),
            ("2", "Shinogi-ji", ""),
            ("3", "Ha", ""),
            ("4", "Mune", ""),
            ("5", "Kissaki", ""),
            ("6", "Boshi", ""),
            ("7", "Nakago", ""),
            ("0", "Other", "A fitting, such as the habaki"),
        ),
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.edit_object
        return allowed(
            cls,
            (
                obj is not None and obj.type == "MESH" and bool(obj.togishi.scan.report_json),
                "Works on the selected faces of a scanned blade in Edit Mode",
            ),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        count = scan_import.paint_part(context.edit_object, int(self.part))
        if not count:
            self.report({"ERROR"}, "No faces are selected")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} faces")
        return {"FINISHED"}


CLASSES = (TOGISHI_OT_scan_handle, TOGISHI_OT_scan_correct, TOGISHI_OT_scan_paint_part)
