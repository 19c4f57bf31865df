"""Zip archives that depend on their content alone: sorted, one date, one mode."""

from __future__ import annotations

import time
import zipfile
from collections.abc import Mapping
from pathlib import Path

# Packed already: a second packing would only cost time.
STORED = (".whl", ".png")
_REGULAR_FILE_MODE = 0o100644
_OLDEST = 315532800  # 1980-01-01, the first date that a zip can hold


def write_zip(path: Path, files: Mapping[str, bytes], epoch_s: int) -> None:
    """Writes `files` (name in the archive -> content), all dated `epoch_s` (seconds since 1970, UTC), in the order
    of their names. Whole or not at all."""
    date = time.gmtime(max(epoch_s, _OLDEST))[:6]
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.part")
    try:
        with zipfile.ZipFile(temporary, "w") as archive:
            for name in sorted(files):
                entry = zipfile.ZipInfo(name, date)
                entry.create_system = 3  # Unix: the mode below means something
                entry.external_attr = _REGULAR_FILE_MODE << 16
                stored = name.endswith(STORED)
                entry.compress_type = zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED
                archive.writestr(entry, files[name], compresslevel=9)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
