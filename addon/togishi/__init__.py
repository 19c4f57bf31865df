"""Togishi: Japanese swords as they really look, from measured spectra.

Nothing is imported here but the names of the modules that register something: the native module, the
`gpu` module and the shaders are loaded when they are first needed, so that the extension can always be
enabled, and can say what is wrong.
"""

from __future__ import annotations

import atexit
import importlib
from types import ModuleType

# In the order of registration; each has register() and unregister(). All must import without the
# native module and without a GPU context.
_MODULE_NAMES = (
    "properties",
    "measurement",
    "photographs",
    "landmark_marks",
    "scan_marks",
    "engine",
    "nodes",
    "operators",
    "ui",
    "cli",
)

_registered: list[ModuleType] = []


def register() -> None:
    # The bpy module hangs at exit (4.5) while classes with dynamic menus are registered.
    atexit.unregister(unregister)
    atexit.register(unregister)
    for name in _MODULE_NAMES:
        module = importlib.import_module(f"{__name__}.{name}")
        module.register()
        _registered.append(module)


def unregister() -> None:
    while _registered:
        _registered.pop().unregister()
