"""Spectrum pickers of lights and worlds."""

from __future__ import annotations

import bpy

from .. import properties
from ..core import native, spectrum_spec

_FIELD = {
    spectrum_spec.BLACKBODY: "blackbody_k",
    spectrum_spec.DAYLIGHT: "daylight_k",
    spectrum_spec.LINE: "line_nm",
    spectrum_spec.CSV: "csv_path",
}


def draw_spectrum(layout: bpy.types.UILayout, settings: properties.TogishiSpectrum) -> None:
    layout.use_property_split = True
    layout.prop(settings, "choice")
    field = _FIELD.get(settings.kind)
    if field is not None:
        layout.prop(settings, field)


class TOGISHI_PT_light(bpy.types.Panel):
    bl_label = "Spectrum"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not native.problem() and context.light is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        draw_spectrum(layout, context.light.togishi)
        if context.light.togishi.kind == spectrum_spec.AUTOMATIC:
            layout.label(text=f"Now {properties.light_spectrum(context.light)}", icon="INFO")
        if context.light.type == "AREA":
            layout.label(text="Togishi draws it as a point light", icon="ERROR")


class TOGISHI_PT_world(bpy.types.Panel):
    bl_label = "Spectrum"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "world"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not native.problem() and context.world is not None

    def draw(self, context: bpy.types.Context) -> None:
        draw_spectrum(self.layout, context.world.togishi)


CLASSES = (TOGISHI_PT_light, TOGISHI_PT_world)
