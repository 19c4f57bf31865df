"""A wheel around one compiled module."""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path

from elf import needs
from fixed_zip import write_zip

NAME = "togishi_core"
SUMMARY = "Core of Togishi: spectra, reflection tables, blades and steel patterns for Blender"


class WheelError(ValueError):
    """A module that no wheel can be made of; the message names the file and what is wrong with it."""


def python_tag(module: Path) -> str:
    """cp311 of togishi_core.cpython-311-x86_64-linux-gnu.so."""
    match = re.fullmatch(rf"{NAME}\.cpython-(\d+)-x86_64-linux-gnu\.so", module.name)
    if match is None:
        raise WheelError(f"{module}: not named {NAME}.cpython-<version>-x86_64-linux-gnu.so")
    return f"cp{match[1]}"


def write_wheel(module: Path, stub: Path, version: str, folder: Path, epoch_s: int) -> Path:
    """Writes the wheel of `module` into `folder`. Its platform tag is the C library that the module really needs.

    Its version is `version` and a hash of the content. Blender takes a wheel of the version that it has unpacked
    already for the same wheel, and would go on using the old module when an extension of unchanged version is
    installed again."""
    python = python_tag(module)
    major, minor = needs(module).glibc
    return write_files(
        {module.name: module.read_bytes(), stub.name: stub.read_bytes()},
        f"{python}-{python}-manylinux_{major}_{minor}_x86_64",
        version,
        folder,
        epoch_s,
    )


def write_files(
    files: dict[str, bytes], tag: str, version: str, folder: Path, epoch_s: int
) -> Path:
    """Writes a wheel of these top-level files; returns its path."""
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + files[name])
    full_version = f"{version}+{digest.hexdigest()[:12]}"
    info = f"{NAME}-{full_version}.dist-info"
    metadata = (
        f"Metadata-Version: 2.1\nName: {NAME}\nVersion: {full_version}\nSummary: {SUMMARY}\n"
        f"License: GPL-3.0-or-later\nRequires-Python: >=3.11\n"
    )
    kind = f"Wheel-Version: 1.0\nGenerator: togishi\nRoot-Is-Purelib: false\nTag: {tag}\n"
    content = {
        **files,
        f"{info}/METADATA": metadata.encode(),
        f"{info}/WHEEL": kind.encode(),
    }
    record = "".join(
        f"{name},sha256={_record_hash(data)},{len(data)}\n"
        for name, data in sorted(content.items())
    )
    content[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    path = folder / f"{NAME}-{full_version}-{tag}.whl"
    write_zip(path, content, epoch_s)
    return path


def _record_hash(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
