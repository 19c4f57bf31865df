"""Assign a blade material; load it from and save it to a TOML file."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .. import blade_object, properties
from ..core import atomic, native
from ..nodes import steel_group
from .poll import LINKED, NEEDS_BLADE_MATERIAL, allowed, editable, local


class TOGISHI_OT_material_assign(bpy.types.Operator):
    """Give the selected meshes a blade material; a blade material they have already is kept"""

    bl_idname = "object.togishi_material_assign"
    bl_label = "Assign Blade Material"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        return allowed(
            cls,
            (obj is not None and obj.type == "MESH", "Needs a mesh as the active object"),
            (obj is None or local(obj, obj.data), LINKED),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = {context.active_object, *context.selected_objects}
        material = blade_object.blade_material(context.active_object)
        for obj in objects:
            if obj.type != "MESH" or blade_object.blade_material(obj) is not None:
                continue
            if not local(obj, obj.data):
                self.report({"WARNING"}, f"{obj.name!r} was left as it is: {LINKED}")
                continue
            if material is None:
                material = blade_object.new_material()
            if obj.material_slots:
                obj.active_material = material
            else:
                obj.data.materials.append(material)
        return {"FINISHED"}


class TOGISHI_OT_material_steel(bpy.types.Operator):
    """Make this material blade steel"""

    bl_idname = "material.togishi_make_steel"
    bl_label = "Make Blade Steel"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        material = cls._target(context)
        return allowed(
            cls,
            (material, "The active object has no material to change"),
            (local(material), LINKED),
        )

    @staticmethod
    def _target(context: bpy.types.Context) -> bpy.types.Material | None:
        obj = context.active_object
        return getattr(context, "material", None) or (obj.active_material if obj else None)

    def execute(self, context: bpy.types.Context) -> set[str]:
        material = self._target(context)
        assert material is not None
        with properties.held_updates():
            material.togishi.is_blade = True
            properties.set_material_dict(
                material, {**native.core().default_material(), "name": material.name}
            )
        steel_group.connect(material)
        return {"FINISHED"}


class TOGISHI_OT_material_load(bpy.types.Operator, ImportHelper):
    """Load a blade material from a TOML file"""

    bl_idname = "material.togishi_load"
    bl_label = "Load Blade Material"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".toml"
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, *editable(blade_object.edited_material(context)))

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            values = native.core().load_material(bpy.path.abspath(self.filepath))
        except (native.core().InputError, OSError) as error:
            self.report({"ERROR"}, f"The material was left as it is: {error}")
            return {"CANCELLED"}
        properties.set_material_dict(blade_object.edited_material(context), values)
        return {"FINISHED"}


class TOGISHI_OT_material_save(bpy.types.Operator, ExportHelper):
    """Save this blade material as a TOML file"""

    bl_idname = "material.togishi_save"
    bl_label = "Save Blade Material"
    bl_options = {"REGISTER"}

    filename_ext = ".toml"
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, (blade_object.edited_material(context), NEEDS_BLADE_MATERIAL))

    def execute(self, context: bpy.types.Context) -> set[str]:
        path = Path(bpy.path.abspath(self.filepath))
        try:
            text = native.core().material_to_toml(
                properties.material_dict(blade_object.edited_material(context), with_fits=True)
            )
            atomic.write_text(path, text)
        except (native.core().InputError, OSError) as error:
            self.report({"ERROR"}, f"Nothing was saved: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Saved {path}")
        return {"FINISHED"}


CLASSES = (
    TOGISHI_OT_material_assign,
    TOGISHI_OT_material_steel,
    TOGISHI_OT_material_load,
    TOGISHI_OT_material_save,
)
