"""What importing and correcting a scan share: the work beside the user interface, and what is told of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from .. import scan_import, scan_read
from ..core import native
from .modal_job import ModalJob

NEEDS_SCAN = "Needs a blade that came from a scan; 'Import Scanned Sword' brings one"


class ScanWork(ModalJob):
    """An operator that reads a scan and works on it: at once without a window, else beside the user interface."""

    doing = "Togishi measures the scan"
    cancelled = "The import was cancelled; nothing was changed"

    def begin_scan(
        self,
        context: bpy.types.Context,
        path: Path,
        options: dict[str, Any],
        painted: dict[str, Any] | None = None,
        sha256: str = "",
    ) -> set[str]:
        core = native.core()
        try:
            context.window_manager.progress_begin(0, 1)
            scan = scan_read.read(path) if scan_read.by_blender(path) else None
        except (core.InputError, OSError) as error:
            self.report({"ERROR"}, f"The scan was not imported: {error}")
            return {"CANCELLED"}
        finally:
            context.window_manager.progress_end()
        job = scan_import.ScanJob(path, scan, options, painted, sha256)
        if bpy.app.background or context.window is None:
            job.start()
            return self.take(context, job)
        return self.begin(context, job)

    def found(self, job: scan_import.ScanJob) -> Any | None:
        """What came out, or None after telling why nothing did."""
        try:
            sword = job.result()
        except InterruptedError:
            self.report({"INFO"}, self.cancelled)
            return None
        except (native.core().InputError, OSError) as error:
            self.report({"ERROR"}, f"The scan was not imported: {error}")
            return None
        verdict = sword.report["verdict"]
        if not verdict["is_blade"]:
            self.report({"ERROR"}, f"The scan was not imported: {verdict['text']}")
            return None
        for sentence in sword.report["notes"]:
            self.report({"WARNING"}, sentence)
        return sword
