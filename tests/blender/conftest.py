"""Tests inside Blender (the bpy wheels of 4.5 and 5.2). The add-on is enabled once; every test starts from an
empty file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
for folder in (ROOT / "addon", Path(__file__).resolve().parent):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))


@pytest.fixture(scope="session")
def addon():
    """The add-on, enabled for the whole run."""
    import togishi
    from togishi.core import native

    assert not native.problem(), native.problem()
    togishi.register()
    yield togishi
    togishi.unregister()


@pytest.fixture
def empty_file(addon):
    """An empty .blend with one scene, before and after a test."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    yield bpy.context.scene
    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.fixture(scope="session")
def gpu_context(addon):
    """The gpu module, usable."""
    from gpu_context import ensure_gpu_context

    ensure_gpu_context()
    import gpu

    return gpu
