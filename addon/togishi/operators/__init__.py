"""Operators: each reads settings, calls the core, reports and finishes."""

from __future__ import annotations

import bpy

from .. import background_job
from . import (
    add_katana,
    bake_surroundings,
    blade_material,
    connect_nodes,
    correct_scan,
    fit_measurement,
    import_scan,
    landmarks,
    light_preset,
    map_files,
    photographs,
    rebake_pattern,
)

_CLASSES = tuple(
    cls
    for module in (
        blade_material,
        rebake_pattern,
        map_files,
        light_preset,
        bake_surroundings,
        connect_nodes,
        fit_measurement,
        photographs,
        landmarks,
        correct_scan,
    )
    for cls in module.CLASSES
)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    add_katana.register()
    import_scan.register()


def unregister() -> None:
    background_job.stop_all()
    import_scan.unregister()
    add_katana.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
