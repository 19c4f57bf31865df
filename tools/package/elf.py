"""What a shared library asks of the machine it is loaded on, read by binutils' readelf."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Needs:
    glibc: tuple[int, int]  # the oldest C library that has every symbol
    libraries: frozenset[str]  # loaded beside it, by soname


def needs(library: Path) -> Needs:
    """Raises ValueError, with what readelf says, where `library` cannot be read as one."""

    def readelf(option: str) -> str:
        command = ["readelf", "--wide", option, str(library)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        # readelf returns 0 for some files that it cannot read.
        if done.returncode != 0 or done.stderr:
            raise ValueError(f"{library} is no shared library: {done.stderr.strip()}")
        return done.stdout

    versions = re.findall(r"Name: GLIBC_(\d+)\.(\d+)", readelf("--version-info"))
    libraries = re.findall(r"\(NEEDED\).*\[(.+)\]", readelf("--dynamic"))
    glibc = max(((int(major), int(minor)) for major, minor in versions), default=(2, 0))
    return Needs(glibc, frozenset(libraries))
