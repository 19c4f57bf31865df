"""Give a blade material its node groups for Cycles and EEVEE, baked for one light."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from .. import bake_cost_cache, blade_object, properties
from ..core import native
from ..nodes import steel_group
from .poll import allowed, editable


def _lights(scene: bpy.types.Scene) -> list[bpy.types.Light]:
    """The lights that a render of the scene has."""
    return [
        obj.data
        for obj in scene.objects
        if obj.type == "LIGHT" and not obj.hide_render and obj.data.energy > 0.0
    ]


def _bake(operator: bpy.types.Operator, context: bpy.types.Context, spectrum: str) -> set[str]:
    """Bake for a spectrum, or for the material's own where it is empty; what is wrong with it is reported."""
    material = blade_object.edited_material(context)
    assert material is not None
    before = material.togishi.node_spectrum
    try:
        with properties.held_updates():
            if spectrum:
                material.togishi.node_spectrum = spectrum
        steel_group.connect(material)
        # The groups read the stroke direction as it is stored.
        for obj in bpy.data.objects:
            wears = any(slot.material == material for slot in obj.material_slots)
            if wears and obj.type == "MESH" and obj.data.library is None:
                blade_object.turn_tangents(obj.data)
        bake_cost_cache.store(material)
    except native.core().InputError as error:
        with properties.held_updates():
            material.togishi.node_spectrum = before
        operator.report({"ERROR"}, f"The node groups were left as they are: {error}")
        return {"CANCELLED"}
    return {"FINISHED"}


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
        return allowed(cls, *editable(blade_object.edited_material(context)))

    def execute(self, context: bpy.types.Context) -> set[str]:
        return _bake(self, context, self.spectrum)


class TOGISHI_OT_nodes_light(bpy.types.Operator):
    """Bake the node groups for the spectrum of the strongest light of the scene"""

    bl_idname = "material.togishi_nodes_bake_for_scene"
    bl_label = "Bake for the Scene's Light"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(
            cls,
            *editable(blade_object.edited_material(context)),
            (_lights(context.scene), "The scene has no light that shines to bake for"),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        strongest = max(
            _lights(context.scene), key=lambda light: (light.type != "SUN", light.energy)
        )
        return _bake(self, context, properties.light_spectrum(strongest))


CLASSES = (TOGISHI_OT_nodes_connect, TOGISHI_OT_nodes_light)
