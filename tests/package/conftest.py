"""The extension's zip, and clean Blenders to install it into. The zip is made around the modules of `make core` and
`make core-5.2`, unless $TOGISHI_PACKAGE names one."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))

from clean_blender import CleanBlender, make_package
from version_table import WHEELS, BlenderVersion


def at_hand(row: BlenderVersion) -> bool:
    """Whether the version can be tested here. In CI every version is."""
    if row.module is not None:
        return True
    assert not os.environ.get("CI"), f"Blender {row.label}: no togishi_core in {row.environment}"
    return False


@pytest.fixture(scope="session")
def package(tmp_path_factory) -> Path:
    if given := os.environ.get("TOGISHI_PACKAGE"):
        return Path(given).resolve()
    modules = [row.module for row in WHEELS if at_hand(row)]
    return make_package(tmp_path_factory.mktemp("package"), *modules)


@pytest.fixture(params=WHEELS, ids=[row.label for row in WHEELS])
def blender(request, tmp_path) -> CleanBlender:
    """Each version in turn, with an empty user folder."""
    if not at_hand(request.param):
        pytest.skip(f"Blender {request.param.label} is not set up: make core-5.2")
    return CleanBlender(request.param, tmp_path)


@pytest.fixture(scope="session")
def users() -> dict[str, Path]:
    """By version: a user folder in which the extension is installed, made when it is first asked for."""
    return {}


@pytest.fixture
def installed(blender, package, users, tmp_path_factory) -> CleanBlender:
    """Each version in turn, with the extension installed."""
    label = blender.row.label
    if label not in users:
        first = CleanBlender(blender.row, tmp_path_factory.mktemp(f"user-{label}"))
        answer = first.run("state", package)
        assert answer["said"] == answer["problem"] == "", answer.output
        users[label] = first.user
    shutil.copytree(users[label], blender.user)
    return blender
