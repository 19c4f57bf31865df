"""Bake the steel pattern of a blade material into its maps."""

from __future__ import annotations

import bpy

from .. import blade_object, data_blocks, map_images, pattern_baking, properties
from ..core import native
from .modal_job import ModalJob
from .poll import LINKED, allowed, local


def _patterned(
    context: bpy.types.Context, material: bpy.types.Material | None
) -> bpy.types.Object | None:
    """The blade with a recipe and this material: the one at hand where it has it, for a material may be on several."""
    if material is None:
        return None
    blade = blade_object.find_blade(context)
    own = blade is not None and any(slot.material == material for slot in blade.material_slots)
    if own and blade_object.has_recipe(blade):
        return blade
    return blade_object.blade_owner(material)


class TOGISHI_OT_pattern_bake(ModalJob, bpy.types.Operator):
    """Make the maps of hamon, hada and polish from the settings. Esc cancels"""

    bl_idname = "material.togishi_pattern_bake"
    bl_label = "Bake Pattern"
    bl_options = {"REGISTER", "UNDO"}

    doing = "Togishi bakes the steel pattern"
    cancelled = "Baking was cancelled; the maps are as they were"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        material = blade_object.edited_material(context)
        return allowed(
            cls,
            (
                _patterned(context, material),
                "Needs a generated or scanned blade with a blade material",
            ),
            (local(material), LINKED),
            (
                material is None or not pattern_baking.is_running(material),
                "This pattern is being baked. Esc in the 3-D view cancels it",
            ),
        )

    def _targets(self, context: bpy.types.Context) -> tuple[bpy.types.Material, dict[str, object]]:
        material = blade_object.edited_material(context)
        assert material is not None
        blade = _patterned(context, material)
        assert blade is not None
        parameters = properties.blade_recipe(blade)
        assert parameters is not None
        return material, parameters

    def _fail(self, error: Exception) -> set[str]:
        self.report({"ERROR"}, f"The maps were left as they are: {error}")
        return {"CANCELLED"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Without a window, and in scripts: at once."""
        try:
            pattern_baking.bake_now(*self._targets(context))
        except native.core().InputError as error:
            return self._fail(error)
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        return self.begin(context, pattern_baking.PatternJob(*self._targets(context)))

    def take(self, _context: bpy.types.Context, job: pattern_baking.PatternJob) -> set[str]:
        material = data_blocks.by_uid(bpy.data.materials, job.material_uid)
        if material is None:
            self.report({"WARNING"}, "The blade's material is gone; its maps were not written")
            return {"CANCELLED"}
        try:
            map_images.assign(material, job.result())
        except native.core().InputError as error:
            return self._fail(error)
        return {"FINISHED"}


CLASSES = (TOGISHI_OT_pattern_bake,)
