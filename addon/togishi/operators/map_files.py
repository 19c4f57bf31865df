"""Import and export of a material's maps as OpenEXR."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .. import blade_object, map_files, map_images
from ..core.map_channels import MapError
from .poll import NEEDS_BLADE_MATERIAL, allowed, editable


def _has_maps(material: bpy.types.Material | None) -> tuple[tuple[object, str], ...]:
    maps = material is not None and material.togishi.lobes_image is not None
    return (
        (material, NEEDS_BLADE_MATERIAL),
        (maps, "This material has no maps; 'Bake Pattern' or 'Import Maps' makes them"),
    )


class TOGISHI_OT_maps_export(bpy.types.Operator, ExportHelper):
    """Save the maps of this blade as an OpenEXR file with named channels"""

    bl_idname = "material.togishi_maps_export"
    bl_label = "Export Maps"
    bl_options = {"REGISTER"}

    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, *_has_maps(blade_object.edited_material(context)))

    def execute(self, context: bpy.types.Context) -> set[str]:
        path = Path(bpy.path.abspath(self.filepath))
        try:
            written = map_files.save(map_images.read(blade_object.edited_material(context)), path)
        except (MapError, OSError) as error:
            self.report({"ERROR"}, f"Nothing was saved: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, "Saved " + ", ".join(str(path) for path in written))
        return {"FINISHED"}


class TOGISHI_OT_maps_import(bpy.types.Operator, ImportHelper):
    """Load maps from an OpenEXR file with named channels, such as `togishi bake` writes"""

    bl_idname = "material.togishi_maps_import"
    bl_label = "Import Maps"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, *editable(blade_object.edited_material(context)))

    def execute(self, context: bpy.types.Context) -> set[str]:
        path = Path(bpy.path.abspath(self.filepath))
        try:
            map_images.assign(blade_object.edited_material(context), map_files.load(path))
        except (MapError, OSError) as error:
            self.report({"ERROR"}, f"The maps were left as they are: {error}")
            return {"CANCELLED"}
        return {"FINISHED"}


class TOGISHI_OT_maps_clear(bpy.types.Operator):
    """Take the maps off this material; the lobes of its parts apply again"""

    bl_idname = "material.togishi_maps_clear"
    bl_label = "Remove Maps"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        material = blade_object.edited_material(context)
        return allowed(cls, *_has_maps(material), *editable(material))

    def execute(self, context: bpy.types.Context) -> set[str]:
        map_images.clear(blade_object.edited_material(context))
        return {"FINISHED"}


CLASSES = (TOGISHI_OT_maps_export, TOGISHI_OT_maps_import, TOGISHI_OT_maps_clear)
