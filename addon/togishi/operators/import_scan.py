"""A scanned sword: import and its record."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .. import scan_import, scan_read
from ..core import atomic, scan_report
from .poll import NEEDS_OBJECT_MODE, allowed
from .scan_work import NEEDS_SCAN, ScanWork


class TOGISHI_OT_scan_import(ScanWork, bpy.types.Operator, ImportHelper):
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
    swap_ends: BoolProperty(
        name="Swap Tip and Tang",
        description="Where they were found the wrong way round",
        default=False,
    )
    swap_edge_and_back: BoolProperty(
        name="Swap Edge and Back",
        description="Where they were found the wrong way round",
        default=False,
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
        for name in ("swap_ends", "swap_edge_and_back", "with_pattern"):
            layout.prop(self, name)
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
            "swap_ends": self.swap_ends,
            "swap_edge_and_back": self.swap_edge_and_back,
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
