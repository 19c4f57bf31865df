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
    """Raises subprocess.CalledProcessError where `library` is no ELF file."""

    def readelf(option: str) -> str:
        done = subprocess.run(
            ["readelf", "--wide", option, str(library)], capture_output=True, text=True, check=True
        )
        return done.stdout

    versions = re.findall(r"Name: GLIBC_(\d+)\.(\d+)", readelf("--version-info"))
    libraries = re.findall(r"\(NEEDED\).*\[(.+)\]", readelf("--dynamic"))
    glibc = max(((int(major), int(minor)) for major, minor in versions), default=(2, 0))
    return Needs(glibc, frozenset(libraries))
