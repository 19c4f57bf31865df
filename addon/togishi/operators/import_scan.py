"""A scanned sword: import, corrections by the user, its record."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .. import scan_import, scan_read
from ..core import atomic, native, scan_report
from .modal_job import ModalJob
from .poll import LINKED, NEEDS_OBJECT_MODE, allowed, local

NEEDS_SCAN = "Needs a blade that came from a scan; 'Import Scanned Sword' brings one"
# Corrections that ask for a value, and the setting that holds it.
_ASKS = {"unit": "unit"}


class _ScanWork(ModalJob):
    """An operator that reads a scan and works on it: at once without a window, else beside the user interface."""

    doing = "Togishi measures the scan"
    cancelled = "The import was cancelled; nothing was changed"

    def begin_scan(
        self,
        context: bpy.types.Context,
        path: Path,
        options: dict[str, Any],
        painted: dict[str, Any] | None = None,
        sha256: str = "",
    ) -> set[str]:
        core = native.core()
        try:
            context.window_manager.progress_begin(0, 1)
            scan = scan_read.read(path) if scan_read.by_blender(path) else None
        except (core.InputError, OSError) as error:
            self.report({"ERROR"}, f"The scan was not imported: {error}")
            return {"CANCELLED"}
        finally:
            context.window_manager.progress_end()
        job = scan_import.ScanJob(path, scan, options, painted, sha256)
        if bpy.app.background or context.window is None:
            job.start()
            return self.take(context, job)
        return self.begin(context, job)

    def found(self, job: scan_import.ScanJob) -> Any | None:
        """What came out, or None after telling why nothing did."""
        try:
            sword = job.result()
        except InterruptedError:
            self.report({"INFO"}, self.cancelled)
            return None
        except (native.core().InputError, OSError) as error:
            self.report({"ERROR"}, f"The scan was not imported: {error}")
            return None
        verdict = sword.report["verdict"]
        if not verdict["is_blade"]:
            self.report({"ERROR"}, f"The scan was not imported: {verdict['text']}")
            return None
        for sentence in sword.report["notes"]:
            self.report({"WARNING"}, sentence)
        return sword


class TOGISHI_OT_scan_import(_ScanWork, bpy.types.Operator, ImportHelper):
    """Import a scanned sword (.ply, .obj, .stl, .gltf, .glb): cleaned, turned upright, measured, its parts told, with
    the chart that every material and map of Togishi needs"""

    bl_idname = "import_scene.togishi_scan"
    bl_label = "Import Scanned Sword"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    filename_ext = ""
    filter_glob: StringProperty(default=scan_read.FILTER, options={"HIDDEN"})
    unit: EnumProperty(
        name="Unit",
        description="Of the file's numbers. What was taken is shown with the dimensions",
        items=(
            ("auto", "By Length", "The unit in which it is as long as a sword"),
            ("mm", "Millimetres", ""),
            ("cm", "Centimetres", ""),
            ("m", "Metres", ""),
            ("inch", "Inches", ""),
        ),
    )
    error_mm: FloatProperty(
        name="Distance (mm)",
        description="How far the lighter mesh may lie from the scan, in mm; finer shape goes into the normal map. "
        "0: 0.05 mm, or eight times the scan's noise",
        default=0.0,
        min=0.0,
        max=5.0,
        precision=3,
    )
    close_holes_mm: FloatProperty(
        name="Close Holes up to (mm)",
        description="Length of the border up to which holes are closed, in mm; what is closed is recorded as inferred",
        default=0.0,
        min=0.0,
        max=500.0,
    )
    texture_px: IntProperty(
        name="Map Width",
        description="Texels along the blade",
        default=8192,
        min=256,
        max=16384,
        subtype="PIXEL",
    )
    replicates: IntProperty(
        name="Fits for Uncertainty",
        description="How often the scan is measured again with its own noise added, from which the uncertainties "
        "come. 0: none, and several times as fast",
        default=16,
        min=0,
        max=200,
    )
    with_pattern: BoolProperty(
        name="Steel pattern",
        description="Also make maps of hamon, hada and polish, which a scan does not show",
        default=False,
    )
    object_id: StringProperty(name="Object", description="Inventory number, for the record")
    title: StringProperty(name="Title", description="What the sword is called, for the record")
    holder: StringProperty(name="Holder", description="Who keeps the sword, for the record")
    rights: StringProperty(name="Rights", description="Rights or licence, for the record")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, (context.mode == "OBJECT", NEEDS_OBJECT_MODE))

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("unit", "error_mm", "close_holes_mm", "texture_px", "replicates"):
            layout.prop(self, name)
        layout.prop(self, "with_pattern")
        layout.label(text="Record")
        for name in ("object_id", "title", "holder", "rights"):
            layout.prop(self, name)

    def import_options(self) -> dict[str, Any]:
        return {
            "mm_per_unit": scan_report.UNITS.get(self.unit, 0.0),
            "error_mm": self.error_mm,
            "close_holes_mm": self.close_holes_mm,
            "texture_px": self.texture_px,
            "replicates": self.replicates,
        }

    def about(self) -> dict[str, str]:
        return {name: getattr(self, name) for name in ("object_id", "title", "holder", "rights")}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.begin_scan(
            context, Path(bpy.path.abspath(self.filepath)), self.import_options()
        )

    def take(self, context: bpy.types.Context, job: scan_import.ScanJob) -> set[str]:
        sword = self.found(job)
        if sword is None:
            return {"CANCELLED"}
        obj = scan_import.place(context, job, sword, self.about())
        if self.with_pattern:
            bpy.ops.material.togishi_pattern_bake("INVOKE_DEFAULT")
        nagasa = next((d for d in sword.report["dimensions"] if d["key"] == "nagasa_mm"), None)
        told = "" if nagasa is None else f", nagasa {scan_report.value_text(nagasa)}"
        self.report(
            {"INFO"},
            f"{obj.name}: {sword.report['verdict']['text'].rstrip('.')}{told}. {sword.report['unit']['text']}",
        )
        return {"FINISHED"}


class TOGISHI_OT_scan_correct(_ScanWork, bpy.types.Operator):
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
            ("unit", "Unit…", "Another unit of the file's numbers"),
        ),
    )
    unit: EnumProperty(
        name="Unit", items=[(name, name, "") for name in scan_report.UNITS], default="mm"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = scan_import.scanned_blade(context)
        return allowed(
            cls,
            (obj, NEEDS_SCAN),
            (obj is None or local(obj, obj.data), LINKED),
            (context.mode == "OBJECT", NEEDS_OBJECT_MODE),
        )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if self.change in _ASKS:
            return context.window_manager.invoke_props_dialog(self)
        return self.execute(context)

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.prop(self, _ASKS[self.change])

    def _options(self, obj: bpy.types.Object) -> dict[str, Any]:
        options: dict[str, Any] = json.loads(obj.togishi.scan.options_json)
        if self.change == "unit":
            options["mm_per_unit"] = scan_report.UNITS[self.unit]
        else:
            options[self.change] = not options.get(self.change, False)
        return options

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = scan_import.scanned_blade(context)
        assert obj is not None
        self._uid = obj.session_uid
        path = Path(bpy.path.abspath(obj.togishi.scan.filepath))
        options = self._options(obj)
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


class TOGISHI_OT_scan_record(bpy.types.Operator, ExportHelper):
    """Save the record of the import, as JSON-LD with the terms of CIDOC-CRM and CRMdig"""

    bl_idname = "export_scene.togishi_scan_record"
    bl_label = "Save Record"

    filename_ext = ".jsonld"
    filter_glob: StringProperty(default="*.jsonld", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = scan_import.scanned_blade(context)
        return allowed(
            cls,
            (obj, NEEDS_SCAN),
            (
                obj is None or obj.togishi.scan.record is not None,
                "The record's text was removed from this file",
            ),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = scan_import.scanned_blade(context)
        assert obj is not None
        try:
            atomic.write_text(
                Path(bpy.path.abspath(self.filepath)), obj.togishi.scan.record.as_string()
            )
        except OSError as error:
            self.report({"ERROR"}, f"The record was not saved: {error}")
            return {"CANCELLED"}
        return {"FINISHED"}


def _menu(self: Any, _context: bpy.types.Context) -> None:
    self.layout.operator(
        TOGISHI_OT_scan_import.bl_idname, text="Scanned Sword (.ply/.obj/.stl/.glb)"
    )


CLASSES = (
    TOGISHI_OT_scan_import,
    TOGISHI_OT_scan_correct,
    TOGISHI_OT_scan_paint_part,
    TOGISHI_OT_scan_record,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(_menu)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
