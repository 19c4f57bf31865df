"""Panels. Nothing here bakes, reads files or touches pixels."""

from __future__ import annotations

import bpy

from . import (
    fit_panels,
    light_panels,
    material_panels,
    native_panels,
    photograph_panels,
    render_panels,
    scan_panels,
    shared_panels,
    view_panels,
)

_MODULES = (
    native_panels,
    material_panels,
    light_panels,
    render_panels,
    view_panels,
    fit_panels,
    photograph_panels,
    scan_panels,
)


def register() -> None:
    for module in _MODULES:
        for cls in module.CLASSES:
            bpy.utils.register_class(cls)
    shared_panels.register()


def unregister() -> None:
    shared_panels.unregister()
    for module in reversed(_MODULES):
        for cls in reversed(module.CLASSES):
            bpy.utils.unregister_class(cls)
