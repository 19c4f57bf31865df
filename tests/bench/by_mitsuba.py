"""Mitsuba 3 in an environment of its own, .venv-mitsuba, made where it is missing: nothing of Togishi is on its path."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

BENCH = Path(__file__).resolve().parent
REPOSITORY = BENCH.parents[1]


def run(script: str, job: Mapping[str, Any]) -> None:
    """A script of this folder, with its job on standard input. Raises CalledProcessError."""
    subprocess.run(
        [str(REPOSITORY / "tools/setup_python.sh"), ".venv-mitsuba", "3.11", "mitsuba"],
        cwd=REPOSITORY,
        check=True,
    )
    subprocess.run(
        [str(REPOSITORY / ".venv-mitsuba/bin/python"), str(BENCH / script)],
        input=json.dumps(job),
        text=True,
        check=True,
        env={key: value for key, value in os.environ.items() if key != "PYTHONPATH"},
    )
