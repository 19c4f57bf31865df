"""Spectrum pickers of lights and worlds."""

from __future__ import annotations

import bpy

from .. import properties
from ..core import native, spectrum_spec
from .light_size import size_sentence
from .sentences import draw_sentence

# Property and label: the properties' own names are too long for a sidebar.
_FIELD = {
    spectrum_spec.BLACKBODY: ("blackbody_k", "Kelvin"),
    spectrum_spec.DAYLIGHT: ("daylight_k", "Kelvin"),
    spectrum_spec.LINE: ("line_nm", "Line (nm)"),
    spectrum_spec.CSV: ("csv_path", "File"),
}


def draw_spectrum(
    layout: bpy.types.UILayout, settings: properties.TogishiSpectrum, in_use: str
) -> None:
    """in_use: the spectrum that the choice comes to, shown where the choice does not say it."""
    layout.use_property_split = True
    layout.prop(settings, "choice")
    field = _FIELD.get(settings.kind)
    if field is not None:
        name, label = field
        layout.prop(settings, name, text=label)
    if settings.kind == spectrum_spec.CSV and not settings.csv_path:
        draw_sentence(layout, f"No file is chosen: {in_use} is used", "ERROR")
    elif settings.kind == spectrum_spec.AUTOMATIC:
        layout.label(text=f"{in_use} is used", icon="INFO")


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
        draw_spectrum(layout, context.light.togishi, properties.light_spectrum(context.light))
        draw_sentence(layout, size_sentence(context.light), "LIGHT")


class TOGISHI_PT_world(bpy.types.Panel):
    bl_label = "Spectrum"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "world"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not native.problem() and context.world is not None

    def draw(self, context: bpy.types.Context) -> None:
        draw_spectrum(self.layout, context.world.togishi, properties.world_spectrum(context.world))
        if context.world.use_nodes and context.world == context.scene.world:
            self.layout.operator("world.togishi_bake_surroundings")


CLASSES = (TOGISHI_PT_light, TOGISHI_PT_world)
