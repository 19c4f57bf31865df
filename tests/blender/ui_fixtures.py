"""What the tests of the add-on share: the add-on registered once, an empty file for each test."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "addon"), str(Path(__file__).parent)]

togishi = importlib.import_module("togishi")

# One vertex in fifty is enough for what these tests ask.
DETAIL = 0.02


@pytest.fixture
def addon() -> Iterator[None]:
    """The add-on in an empty file. The engine's tests keep it enabled for a whole run: it is enabled anew here, and
    left for them as it was."""
    kept = bool(togishi._registered)
    if kept:
        togishi.unregister()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    togishi.register()
    yield
    togishi.unregister()
    if kept:
        togishi.register()


def add_katana(**settings: object) -> bpy.types.Object:
    """A coarse blade without maps."""
    settings = {"detail": DETAIL, "with_pattern": False, **settings}
    assert bpy.ops.mesh.togishi_katana_add(**settings) == {"FINISHED"}
    return bpy.context.active_object


def environment() -> dict[str, str]:
    """For a second process that runs the add-on from this checkout."""
    module = Path(importlib.import_module("togishi_core").__file__).parent
    paths = [str(ROOT / "addon"), str(module), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in paths if p)}
