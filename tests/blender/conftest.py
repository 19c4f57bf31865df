"""Tests inside Blender (the bpy wheels of 4.5 and 5.2). The add-on is enabled once; every test starts from an
empty file."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
for folder in (ROOT / "addon", ROOT / "tests", Path(__file__).resolve().parent):
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


def pytest_unconfigure(config):
    """Leave at once. The bpy module ends itself when its last reference goes; hypothesis keeps one in the frames
    that it remembers, and then Blender 4.5 waits at exit for its own sound thread (`delayed_close_thread_run`),
    for ever. How the add-on behaves at exit is tested in processes of its own (test_headless.py)."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or "bpy" not in sys.modules:
        return
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(int(reporter._session.exitstatus))
