"""From a pattern recipe to the maps of a material: the computation itself needs no Blender data, so
that it can run beside the user interface."""

from __future__ import annotations

import json
import threading
import time
from typing import Any

import bpy

from . import map_images, properties
from .core import native

# Fields of the pattern settings that are the size of the maps, not the recipe.
_SIZE = ("width_px", "height_px")


def pattern_dict(material: bpy.types.Material) -> dict[str, Any]:
    """The recipe as togishi_core.steel_pattern takes it."""
    group = material.togishi.pattern
    names = [
        p.identifier for p in group.bl_rna.properties if p.identifier not in ("rna_type", "name")
    ]
    return {name: getattr(group, name) for name in names if name not in _SIZE}


class PatternJob:
    """One computation in a thread of its own. The settings are copied when it is made."""

    def __init__(self, material: bpy.types.Material, katana: dict[str, Any]) -> None:
        group = material.togishi.pattern
        self._arguments = (
            katana,
            properties.material_dict(material),
            pattern_dict(material),
            group.width_px,
            group.height_px,
        )
        # The material's name is no part of the computation.
        self.key = json.dumps(
            [katana, {**self._arguments[1], "name": ""}, *self._arguments[2:]], sort_keys=True
        )
        self.material_uid = material.session_uid
        self.share = 0.0  # of the computation that is done
        self.cancelled = False
        self._core = native.core()
        self._maps: dict[str, Any] | None = None
        self._error: Exception | None = None
        self.started_s = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="togishi-pattern", daemon=True)

    def _run(self) -> None:
        try:
            self._maps = self._core.steel_pattern(*self._arguments, progress=self._progress)
        except Exception as error:  # handed to the main thread, which raises it again
            self._error = error
        finally:
            _running.discard(self)

    def _progress(self, share: float) -> bool:
        self.share = share
        return not self.cancelled

    def start(self) -> None:
        _running.add(self)
        self._thread.start()

    def cancel(self) -> None:
        """End the computation at its next report of progress. There is no result then."""
        self.cancelled = True

    def wait(self) -> None:
        self._thread.join()

    @property
    def done(self) -> bool:
        return not self._thread.is_alive()

    def result(self) -> dict[str, Any]:
        """The maps by channel; waits for them. Raises what the computation raised; InterruptedError after cancel()."""
        self.wait()
        if self._error is not None:
            raise self._error
        assert self._maps is not None
        return self._maps


_running: set[PatternJob] = set()


def is_running(material: bpy.types.Material) -> bool:
    """Whether maps for this material are being computed."""
    return any(job.material_uid == material.session_uid and not job.cancelled for job in _running)


def stop_all() -> None:
    """Cancel what runs and wait for it: no thread outlives the add-on, or Blender."""
    for job in list(_running):
        job.cancel()
        job.wait()


# The last result: the redo panel runs "Add Katana" again for every touch, mostly with the same pattern.
_last: tuple[str, dict[str, Any]] | None = None


def bake_now(material: bpy.types.Material, katana: dict[str, Any]) -> None:
    """Compute and write the maps before returning. Raises togishi_core.InputError."""
    global _last
    job = PatternJob(material, katana)
    if _last is None or _last[0] != job.key:
        job.start()
        _last = (job.key, job.result())
    map_images.assign(material, _last[1])
