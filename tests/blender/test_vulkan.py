"""Blender 5's Vulkan backend draws the same pictures as OpenGL. Each backend has a process of its own; both run on
Mesa's software drivers, llvmpipe and lavapipe."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from ui_fixtures import environment

SCRIPT = Path(__file__).with_name("vulkan_pictures.py")
# Relative, of values over a thousandth. Measured: 6.3e-5; the compilers of shaders order sums otherwise.
TOLERANCE = 1.0e-3

pytestmark = pytest.mark.gpu


def _pictures(backend: str, folder: Path) -> dict[str, np.ndarray]:
    drivers = sorted(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
    if backend == "VULKAN" and not drivers:
        pytest.skip("no lavapipe: the Debian package mesa-vulkan-drivers is not installed")
    settings = environment()
    settings["PYTHONPATH"] += os.pathsep + str(SCRIPT.parent)
    settings["BLENDER_USER_RESOURCES"] = str(folder / "user")
    if drivers:
        settings["VK_DRIVER_FILES"] = settings["VK_ICD_FILENAMES"] = str(drivers[0])
    file = folder / f"{backend}.npz"
    done = subprocess.run(
        [sys.executable, str(SCRIPT), backend, str(file)],
        env=settings,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    if done.returncode == 3:
        pytest.skip(f"{backend} does not start here: {done.stdout.strip()}")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[0].startswith(f"{backend}: ")
    with np.load(file) as arrays:
        return dict(arrays)


@pytest.mark.skipif(
    bpy.app.version < (5, 0, 0), reason="Blender has Vulkan without a window from 5.0"
)
def test_vulkan_draws_what_opengl_draws(tmp_path):
    opengl, vulkan = _pictures("OPENGL", tmp_path), _pictures("VULKAN", tmp_path)
    assert opengl.keys() == vulkan.keys()
    assert len(opengl) >= 15
    for name, expected in opengl.items():
        drawn = vulkan[name]
        assert np.isfinite(drawn).all(), name
        assert float(np.ptp(expected)) > 0.1 or name == "no blade: part", f"{name} is flat"
        difference = np.abs(drawn - expected) / np.maximum(np.abs(expected), 1.0e-3)
        assert float(difference.max()) < TOLERANCE, f"{name}: {difference.max():.2e}"
