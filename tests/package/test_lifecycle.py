"""The life of tests/window/lifecycle.py without a window, in each version. What needs a window is left out by name;
`make test-window` does it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import pytest
from clean_blender import ROOT

SCRIPTS = ROOT / "tests/window"
sys.path.insert(0, str(SCRIPTS))

from console import problems  # noqa: E402

# Steps that are about windows. Everything else is done in every version.
IN_A_WINDOW = {
    "the viewport's pixels are the renderer's",
    "cancel a bake by Esc",
    "undo and redo 50 times",
    "undo and redo an added blade",
    "switch shading and engine back and forth",
    "disable while a bake runs",
}


@pytest.mark.timeout(660)
def test_the_whole_life(blender, package, tmp_path):
    blender.user.mkdir(parents=True)
    console = tmp_path / "console.log"
    command = [blender.row.interpreter, "-S", SCRIPTS / "lifecycle.py"]
    command += ["--zip", package, "--out", tmp_path, "--console", console]
    with console.open("wb") as stream:
        done = subprocess.run(
            [str(part) for part in command],
            env={
                "PATH": os.environ["PATH"],
                "HOME": str(tmp_path),
                "BLENDER_USER_RESOURCES": str(blender.user),
                "PYTHONPATH": str(blender._modules()),
            },
            stdout=stream,
            stderr=subprocess.STDOUT,
            timeout=600,
            check=False,
        )
    text = console.read_text(errors="replace")
    assert done.returncode == 0, text
    assert problems(text) == []
    (report,) = tmp_path.glob("lifecycle-*.json")
    life = json.loads(report.read_text())
    assert life["passed"] is True
    assert {step["name"] for step in life["steps"] if step["skipped"]} == IN_A_WINDOW
    assert life["rss_growth_mb_per_100_redraws"] is not None
    kept = ROOT / "out/window"
    kept.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(report, kept / report.name)
