"""Render settings of the engine."""

from __future__ import annotations

import bpy

from .. import properties
from ..core import native
from .light_panels import draw_spectrum
from .shared_panels import ENGINE


class _RenderPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in cls.COMPAT_ENGINES


class TOGISHI_PT_render(_RenderPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        settings = context.scene.togishi
        layout.prop(settings, "viewport_samples", text="Viewport")
        layout.prop(settings, "samples", text="Render")
        layout.prop(settings, "filter_highlights")
        layout.prop(settings, "mirror_things")
        layout.prop(context.scene.render, "film_transparent")


class TOGISHI_PT_colour(_RenderPanel, bpy.types.Panel):
    bl_label = "Spectral Colour"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        settings = context.scene.togishi
        layout.prop(settings, "observer")
        layout.prop(settings, "adaptation")
        if settings.adaptation == "none":
            return
        layout.prop(settings, "adapted_to")
        if settings.adapted_to == "room" and not native.problem():
            draw_spectrum(layout, settings.white, properties.adapted_white(context.scene))


class TOGISHI_PT_passes(bpy.types.Panel):
    bl_label = "Passes"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "view_layer"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(context.scene.togishi, "use_pass_depth")
        layout.prop(context.scene.togishi, "use_pass_part")


CLASSES = (TOGISHI_PT_render, TOGISHI_PT_colour, TOGISHI_PT_passes)
