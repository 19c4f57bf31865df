"""What the scripts of this folder share. They run inside Blender, from a user's point of view, and write what they
find to the JSON file that their first argument names."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from types import ModuleType

import bpy

NAME = "bl_ext.user_default.togishi"
REPORT = Path(sys.argv[1])
ARGUMENTS = sys.argv[2:]
_found: dict[str, object] = {}


def report(**values: object) -> None:
    """Adds to what is reported; written at once, for a crash may follow."""
    _found.update(values)
    REPORT.write_text(json.dumps(_found))


def install(zip_path: str) -> str:
    """Installs and enables; returns what Blender says against it, or ""."""
    try:
        bpy.ops.extensions.package_install_files(
            filepath=zip_path, repo="user_default", enable_on_install=True
        )
    except RuntimeError as error:
        return str(error)
    return ""


def enabled() -> bool:
    return NAME in bpy.context.preferences.addons


def part(name: str) -> ModuleType:
    """A module of the installed extension."""
    return importlib.import_module(f"{NAME}.{name}")


def problem() -> str:
    return part("core.native").problem()


def add_katana() -> bpy.types.Object:
    bpy.ops.mesh.togishi_katana_add(detail=0.02, with_pattern=False)
    return bpy.context.active_object


def say_state() -> None:
    """Whether it is enabled, what it says is wrong, and whether its operator would run."""
    report(
        enabled=enabled(),
        problem=problem(),
        panel=bpy.types.TOGISHI_PT_problem.poll(bpy.context),
        can_add=bpy.ops.mesh.togishi_katana_add.poll(),
    )
