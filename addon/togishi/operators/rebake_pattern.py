"""Bake the steel pattern of a blade material into its maps."""

from __future__ import annotations

import time

import bpy

from .. import blade_object, map_images, pattern_baking, properties
from ..core import native


class TOGISHI_OT_pattern_bake(bpy.types.Operator):
    """Make the maps of hamon, hada and polish from the settings. Esc cancels"""

    bl_idname = "material.togishi_pattern_bake"
    bl_label = "Bake Pattern"
    bl_options = {"REGISTER", "UNDO"}

    _timer: bpy.types.Timer | None = None
    _job: pattern_baking.PatternJob | None = None
    _material: str = ""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if native.problem():
            cls.poll_message_set(native.problem())
            return False
        blade = blade_object.find_blade(context)
        if (
            blade is None
            or not blade.togishi.katana_json
            or blade_object.blade_material(blade) is None
        ):
            cls.poll_message_set("Needs a generated blade with a blade material")
            return False
        return True

    def _targets(self, context: bpy.types.Context) -> tuple[bpy.types.Material, dict[str, object]]:
        blade = blade_object.find_blade(context)
        material = blade_object.blade_material(blade)
        parameters = properties.katana_parameters(blade)
        assert material is not None
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
        material, parameters = self._targets(context)
        self._material = material.name
        self._job = pattern_baking.PatternJob(material, parameters)
        self._job.start()
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        assert self._job is not None
        if event.type == "ESC":
            # The thread ends by itself; its result is not taken.
            self._finish(context)
            self.report({"INFO"}, "Baking was cancelled; the maps are as they were")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not self._job.done:
            seconds = time.monotonic() - self._job.started_s
            context.workspace.status_text_set(
                f"Togishi bakes the steel pattern: {seconds:.0f} s. Esc cancels"
            )
            return {"RUNNING_MODAL"}
        self._finish(context)
        material = bpy.data.materials.get(self._material)
        if material is None:
            self.report(
                {"WARNING"}, f"Material {self._material!r} is gone; its maps were not written"
            )
            return {"CANCELLED"}
        try:
            map_images.assign(material, self._job.result())
        except native.core().InputError as error:
            return self._fail(error)
        return {"FINISHED"}

    def _finish(self, context: bpy.types.Context) -> None:
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        context.workspace.status_text_set(None)

    def cancel(self, context: bpy.types.Context) -> None:
        self._finish(context)


CLASSES = (TOGISHI_OT_pattern_bake,)
