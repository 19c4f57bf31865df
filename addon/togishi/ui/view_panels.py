"""The tab "Togishi" beside the 3-D view."""

from __future__ import annotations

import bpy

from .. import blade_object, properties
from ..core import native
from ..core.light_presets import PRESETS
from .light_panels import draw_spectrum
from .light_size import size_sentence
from .material_panels import draw_maps, draw_nodes, draw_steel
from .sentences import draw_sentence


class _ViewPanel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Togishi"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return not native.problem()


class TOGISHI_PT_view_blade(_ViewPanel, bpy.types.Panel):
    bl_label = "Blade"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        blade = blade_object.find_blade(context)
        layout.operator("mesh.togishi_katana_add", text="Add Katana", icon="ADD")
        if blade is None:
            layout.operator("object.togishi_material_assign", icon="MATERIAL")
            layout.label(text="No blade in this scene yet", icon="INFO")
            return
        layout.label(text=blade.name, icon="OBJECT_DATA")
        if blade.togishi.katana_json:
            layout.operator_context = "INVOKE_DEFAULT"
            layout.operator("object.togishi_katana_edit", text="Edit Dimensions…")
        if blade_object.blade_material(blade) is None:
            layout.operator("object.togishi_material_assign", icon="MATERIAL")


class _BladePanel(_ViewPanel):
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not native.problem() and blade_object.edited_material(context) is not None

    def material(self, context: bpy.types.Context) -> bpy.types.Material:
        material = blade_object.edited_material(context)
        assert material is not None
        return material


class TOGISHI_PT_view_steel(_BladePanel, bpy.types.Panel):
    bl_label = "Steel"

    def draw(self, context: bpy.types.Context) -> None:
        draw_steel(self.layout, self.material(context))


class TOGISHI_PT_view_pattern(_BladePanel, bpy.types.Panel):
    bl_label = "Hamon and Hada"
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        draw_maps(self.layout, self.material(context))


class TOGISHI_PT_view_lights(_ViewPanel, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        for row in PRESETS:
            column.operator(
                "object.togishi_light_preset", text=row.label, icon="LIGHT"
            ).preset = row.identifier
        active = context.active_object
        if active is not None and active.type == "LIGHT":
            layout.separator()
            layout.label(text=active.name, icon="LIGHT_DATA")
            draw_spectrum(layout, active.data.togishi, properties.light_spectrum(active.data))
            # A sun has an irradiance, in W/m², where other lamps have a power.
            layout.prop(
                active.data, "energy", text="Strength" if active.data.type == "SUN" else "Power"
            )
            draw_sentence(layout, size_sentence(active.data), "LIGHT")


class TOGISHI_PT_view_nodes(_BladePanel, bpy.types.Panel):
    bl_label = "Cycles and EEVEE"

    def draw(self, context: bpy.types.Context) -> None:
        draw_nodes(self.layout, self.material(context))


CLASSES = (
    TOGISHI_PT_view_blade,
    TOGISHI_PT_view_steel,
    TOGISHI_PT_view_pattern,
    TOGISHI_PT_view_lights,
    TOGISHI_PT_view_nodes,
)
