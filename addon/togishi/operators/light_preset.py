"""Light presets aimed at the blade."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from .. import blade_object, light_rig
from ..core.light_presets import PRESETS
from .poll import NEEDS_OBJECT_MODE, allowed


class TOGISHI_OT_light_preset(bpy.types.Operator):
    """Add a set of lights around the blade or the active object"""

    bl_idname = "object.togishi_light_preset"
    bl_label = "Add Lights"
    bl_options = {"REGISTER", "UNDO"}

    preset: EnumProperty(
        name="Lights",
        items=[(row.identifier, row.label, row.description) for row in PRESETS],
        default="MUSEUM_SPOT",
    )
    strength: FloatProperty(
        name="Strength",
        description="Factor on the power of all its lamps",
        default=1.0,
        min=0.0,
        soft_max=10.0,
    )
    replace: BoolProperty(
        name="Replace", description="Remove the lights of an earlier preset first", default=True
    )
    set_world: BoolProperty(
        name="Set surroundings",
        description="Also set the world's colour, which the blade mirrors",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        active = context.active_object
        target = blade_object.find_blade(context) or (active is not None and active.type == "MESH")
        return allowed(
            cls,
            (target, "Needs a blade or an active mesh to aim at"),
            (context.mode == "OBJECT", NEEDS_OBJECT_MODE),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        target = blade_object.find_blade(context) or context.active_object
        if self.replace:
            light_rig.clear(context.scene)
        context.view_layer.update()
        light_rig.add(context.scene, target, self.preset, self.strength, self.set_world)
        return {"FINISHED"}


CLASSES = (TOGISHI_OT_light_preset,)
