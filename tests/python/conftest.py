"""What tests outside Blender share."""

import os
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def togishi_cli() -> Path:
    """The togishi executable: TOGISHI_CLI, else that of the release build."""
    path = Path(os.environ.get("TOGISHI_CLI", REPOSITORY / "build/release/cpp_core/cli/togishi"))
    if not path.is_file():
        pytest.fail(f"{path} is missing: build it, or name it in TOGISHI_CLI")
    return path
