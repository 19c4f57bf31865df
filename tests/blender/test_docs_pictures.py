"""The guide's pictures show what this build draws: each is made again, smaller, and compared."""

from __future__ import annotations

import subprocess
import sys

import bpy
import pytest
from ui_fixtures import ROOT, environment


@pytest.mark.skipif(
    bpy.app.version >= (5, 0, 0), reason="the guide's pictures are those of 4.5 LTS"
)
def test_pictures_of_the_guide_are_not_stale():
    command = [sys.executable, str(ROOT / "blend_files" / "docs_pictures.py"), "--check"]
    done = subprocess.run(
        command, env=environment(), capture_output=True, text=True, timeout=220, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    compared = [line for line in done.stdout.splitlines() if " of 0." in line]
    pictures = list((ROOT / "docs" / "guide" / "pictures").glob("*.jpg"))
    assert len(compared) == len(pictures) >= 10, done.stdout
