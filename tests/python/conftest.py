"""What tests outside Blender share: the togishi command, as a shell runs it."""

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session")
def togishi_cli() -> Path:
    """The togishi executable: TOGISHI_CLI, else that of the release build."""
    path = Path(os.environ.get("TOGISHI_CLI", REPOSITORY / "build/release/cpp_core/cli/togishi"))
    if not path.is_file():
        pytest.fail(f"{path} is missing: build it, or name it in TOGISHI_CLI")
    return path


@pytest.fixture(scope="session")
def togishi(togishi_cli: Path) -> Run:
    """Runs togishi with the arguments; returns the finished process with its texts."""

    def run(
        *arguments: str | Path, before: Sequence[str] = (), **options: object
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*before, str(togishi_cli), *map(str, arguments)],
            stdout=options.pop("stdout", subprocess.PIPE),
            stderr=subprocess.PIPE,
            text=True,
            timeout=120,
            check=False,
            **options,
        )

    return run


@pytest.fixture
def full_disk() -> dict[str, Callable[[], None]]:
    """Options for the `togishi` fixture: no file of the process may grow beyond 4 KiB.

    A quota, as the kernel has it; a full disk fails the same call of the same write.
    """
    return {
        "preexec_fn": lambda: resource.setrlimit(
            resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY)
        )
    }


@pytest.fixture
def as_user() -> list[str]:
    """Option `before` for the `togishi` fixture: root, too, is bound by a folder's permissions."""
    if os.geteuid() != 0:
        return []
    setpriv = shutil.which("setpriv")
    assert setpriv, "setpriv (util-linux) is missing: root writes to read-only folders without it"
    return [setpriv, "--bounding-set=-all"]
