"""A goniometer's measurement, its fit and what it is worth, in the 3-D view's sidebar."""

from __future__ import annotations

import bpy

from .. import blade_object, properties
from ..core import native
from ..core.fit_table import TARGETS, fit_table
from .sentences import draw_pairs, draw_sentence


def draw_table(layout: bpy.types.UILayout, record_json: str) -> None:
    table = fit_table(record_json)
    box = layout.box()
    draw_pairs(box, [(row.label, row.value, row.determined) for row in table.rows])
    for row in table.rows:
        if row.reason:
            icon = "INFO" if row.determined else "ERROR"
            draw_sentence(box, f"{row.label}: {row.reason}", icon)
    for sentence in (*table.summary, *table.notes):
        draw_sentence(box, sentence)


class TOGISHI_PT_view_measurement(bpy.types.Panel):
    bl_label = "Measurement"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Togishi"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return not native.problem()

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator(
            "scene.togishi_measurement_fit", text="Fit Measurement…", icon="FILE_FOLDER"
        )
        kept = context.scene.togishi_measurement
        if not len(kept.fits):
            return
        layout.label(text=kept.title, icon="FILE_TICK")
        material = blade_object.edited_material(context)
        labels = {name: label for name, label, _constant in properties.LOBE_PARTS}
        for index, fit in enumerate(kept.fits):
            layout.separator()
            model = fit_table(fit.record_json).model
            layout.label(text=model.capitalize())
            draw_table(layout, fit.record_json)
            row = layout.row(align=True)
            for plot, text in (("scans", "Scans"), ("mu_eff", "Half Width")):
                show = row.operator("scene.togishi_measurement_show", text=text, icon="IMAGE_DATA")
                show.index, show.plot = index, plot
            if material is None:
                continue
            column = layout.column(align=True)
            column.label(text=f"Apply to {material.name}:")
            for part in TARGETS[model][0]:
                apply = column.operator("scene.togishi_measurement_apply", text=labels[part])
                apply.index, apply.part = index, part


CLASSES = (TOGISHI_PT_view_measurement,)
