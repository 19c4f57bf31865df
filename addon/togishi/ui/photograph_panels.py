"""From photographs to maps: the same panel beside the 3-D view and beside the photograph."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..core import native
from .sentences import draw_sentence

_ICONS = ("CHECKBOX_DEHLT", "CHECKBOX_HLT")


class TOGISHI_UL_landmarks(bpy.types.UIList):
    """Landmarks: whether each is on the blade and in the photograph, and how far off it lies."""

    def draw_item(self, _context, layout, _data, item, _icon, _active, _property, *_rest):  # type: ignore[no-untyped-def]
        row = layout.row(align=True)
        row.label(text=item.name)
        row.label(text="", icon=_ICONS[item.has_point])
        row.label(text="", icon=_ICONS[item.has_pixel])
        row.label(text=f"{item.residual_mm:.2f} mm" if item.residual_mm >= 0.0 else "–")


def _pictures(layout: bpy.types.UILayout, kept: object, names: dict[str, str]) -> None:
    row = layout.row(align=True)
    for name, text in names.items():
        if getattr(kept, name) is not None:
            row.operator(
                "scene.togishi_photographs_show", text=text, icon="IMAGE_DATA"
            ).picture = name


def _draw_landmarks(layout: bpy.types.UILayout, kept: bpy.types.PropertyGroup, area: str) -> None:
    layout.label(text="Landmarks")
    row = layout.row()
    row.template_list(
        "TOGISHI_UL_landmarks", "", kept, "landmarks", kept, "active_landmark", rows=4
    )
    column = row.column(align=True)
    column.operator_menu_enum("scene.togishi_landmark_add", "place", text="", icon="ADD")
    column.operator("scene.togishi_landmark_remove", text="", icon="REMOVE")
    if area == "IMAGE_EDITOR":
        layout.operator("image.togishi_landmark_mark", icon="CURSOR")
    else:
        layout.operator("view3d.togishi_landmark_pick", icon="CURSOR")
    row = layout.row(align=True)
    row.prop(kept, "camera_kind", expand=True)
    row.prop(kept, "side", text="")
    row = layout.row(align=True)
    row.operator("scene.togishi_camera_solve", icon="CAMERA_DATA")
    row.operator("scene.togishi_camera_outline", icon="MESH_DATA")
    if kept.rms_mm >= 0.0:
        layout.label(text=f"Camera found, {kept.rms_mm:.2f} mm rms", icon="CHECKMARK")
    if kept.outline_mm >= 0.0:
        layout.label(text=f"Outline found, {kept.outline_mm:.2f} mm rms", icon="CHECKMARK")
    if not kept.camera_json:
        draw_sentence(layout, "The camera is not known yet", "INFO")


class _PhotographPanel:
    bl_region_type = "UI"
    bl_category = "Togishi"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return not native.problem()

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        kept = context.scene.togishi_photographs
        layout.operator(
            "scene.togishi_photographs", text="Photographs to Maps…", icon="FILE_FOLDER"
        )
        if not kept.filepath:
            return
        layout.label(text=Path(kept.filepath).name, icon="FILE_TICK")
        for sentence in kept.plan.splitlines():
            draw_sentence(layout, sentence)
        _pictures(layout, kept, {"photograph": "Photograph", "plan_image": "Plan"})
        row = layout.row(align=True)
        row.operator("scene.togishi_photographs_plan", icon="FILE_REFRESH")
        row.operator("scene.togishi_photographs_run", icon="PLAY")
        for sentence in kept.found.splitlines():
            draw_sentence(layout, sentence)
        _pictures(layout, kept, {"w_image": "w", "mu_image": "μ"})
        layout.separator()
        _draw_landmarks(layout, kept, context.area.type if context.area else "")
        layout.separator()
        if kept.earlier:
            column = layout.column(align=True)
            column.label(text="Blended with")
            for one in kept.earlier:
                column.prop(one, "use", text=Path(one.filepath).name)
        layout.operator("scene.togishi_photographs_apply", icon="MATERIAL")


class TOGISHI_PT_view_photographs(_PhotographPanel, bpy.types.Panel):
    bl_label = "Photographs"
    bl_space_type = "VIEW_3D"


class TOGISHI_PT_image_photographs(_PhotographPanel, bpy.types.Panel):
    bl_label = "Photographs"
    bl_space_type = "IMAGE_EDITOR"


CLASSES = (
    TOGISHI_UL_landmarks,
    TOGISHI_PT_view_photographs,
    TOGISHI_PT_image_photographs,
)
