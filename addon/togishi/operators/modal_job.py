"""How an operator waits for a background job without holding Blender: a timer, its progress in the status bar, Esc."""

from __future__ import annotations

import bpy

from ..background_job import BackgroundJob


class ModalJob:
    """For operators, before bpy.types.Operator. They call begin() from invoke() and say what becomes of the result
    in take(); `doing` and `cancelled` are what the user reads."""

    doing: str
    cancelled: str

    _timer: bpy.types.Timer | None = None
    _job: BackgroundJob | None = None

    def take(self, context: bpy.types.Context, job: BackgroundJob) -> set[str]:
        """The job is done: put its result where it belongs."""
        raise NotImplementedError

    def begin(self, context: bpy.types.Context, job: BackgroundJob) -> set[str]:
        self._job = job
        job.start()
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        job = self._job
        assert job is not None
        if event.type == "ESC" and event.value == "PRESS":
            self._finish(context)
            self.report({"INFO"}, self.cancelled)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not job.done:
            if context.workspace is not None:
                context.workspace.status_text_set(f"{self.doing}: {job.share:.0%}. Esc cancels")
            # Other timers' events pass: an animation goes on playing.
            return {"PASS_THROUGH"}
        self._job = None
        self._finish(context)
        return self.take(context, job)

    def _finish(self, context: bpy.types.Context) -> None:
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if self._job is not None:
            self._job.cancel()
            self._job = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends it: another file is loaded, or the window closes."""
        self._finish(context)
