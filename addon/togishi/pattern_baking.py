"""From a pattern recipe to the maps of a material: the computation itself needs no Blender data, so
that it can run beside the user interface."""

from __future__ import annotations

import json
from typing import Any

import bpy

from . import map_images, properties
from .background_job import BackgroundJob, running

# Fields of the pattern settings that are the size of the maps, not the recipe.
_SIZE = ("width_px", "height_px")


def pattern_dict(material: bpy.types.Material) -> dict[str, Any]:
    """The recipe as togishi_core.steel_pattern takes it."""
    group = material.togishi.pattern
    names = [
        p.identifier for p in group.bl_rna.properties if p.identifier not in ("rna_type", "name")
    ]
    return {name: getattr(group, name) for name in names if name not in _SIZE}


class PatternJob(BackgroundJob):
    """The maps of one material. Its result is the maps by channel."""

    thread_name = "togishi-pattern"

    def __init__(self, material: bpy.types.Material, katana: dict[str, Any]) -> None:
        super().__init__()
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

    def _compute(self) -> dict[str, Any]:
        return self._core.steel_pattern(*self._arguments, progress=self._progress)


def is_running(material: bpy.types.Material) -> bool:
    """Whether maps for this material are being computed."""
    return any(
        isinstance(job, PatternJob) and job.material_uid == material.session_uid
        for job in running()
    )


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
