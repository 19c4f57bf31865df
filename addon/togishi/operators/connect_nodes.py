"""Give a blade material its node groups for Cycles and EEVEE, baked for one light."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from .. import bake_cost_cache, properties
from ..core import native
from ..nodes import steel_group
from .blade_material import _material
from .poll import NEEDS_BLADE_MATERIAL, allowed


class TOGISHI_OT_nodes_connect(bpy.types.Operator):
    """Make or renew the node groups "Togishi Steel" of this material for Cycles and EEVEE"""

    bl_idname = "material.togishi_nodes_connect"
    bl_label = "Bake Node Groups"
    bl_options = {"REGISTER", "UNDO"}

    spectrum: StringProperty(
        name="Light",
        description="Spectrum to bake for, such as D65 or blackbody:2856; empty keeps the material's",
        default="",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, (_material(context), NEEDS_BLADE_MATERIAL))

    def execute(self, context: bpy.types.Context) -> set[str]:
        material = _material(context)
        before = material.togishi.node_spectrum
        try:
            with properties.held_updates():
                if self.spectrum:
                    material.togishi.node_spectrum = self.spectrum
            steel_group.connect(material)
            bake_cost_cache.store(material)
        except native.core().InputError as error:
            with properties.held_updates():
                material.togishi.node_spectrum = before
            self.report({"ERROR"}, f"The node groups were left as they are: {error}")
            return {"CANCELLED"}
        return {"FINISHED"}


class TOGISHI_OT_nodes_light(bpy.types.Operator):
    """Bake the node groups for the spectrum of the strongest light of the scene"""

    bl_idname = "material.togishi_nodes_bake_for_scene"
    bl_label = "Bake for the Scene's Light"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        lit = any(obj.type == "LIGHT" for obj in context.scene.objects)
        return allowed(
            cls,
            (_material(context), NEEDS_BLADE_MATERIAL),
            (lit, "The scene has no light to bake for"),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        lights = [obj.data for obj in context.scene.objects if obj.type == "LIGHT"]
        strongest = max(lights, key=lambda light: (light.type != "SUN", light.energy))
        return bpy.ops.material.togishi_nodes_connect(spectrum=properties.light_spectrum(strongest))


CLASSES = (TOGISHI_OT_nodes_connect, TOGISHI_OT_nodes_light)
