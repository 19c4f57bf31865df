"""What the import of a scanned sword found, as panels, drawings and records say it. Numbers are in mm."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}
_HASH_BLOCK = 1 << 20


class Line(NamedTuple):
    """A dimension drawn over the blade, in mm of the blade's own coordinates."""

    text: str
    points_mm: tuple[tuple[float, float, float], ...]


def value_text(dimension: Mapping[str, Any]) -> str:
    """ "736.04 ± 0.08 mm": as many digits as the uncertainty has two of."""
    value, sigma, unit = dimension["value"], dimension["sigma"], dimension["unit"]
    digits = 1 if sigma >= 0.95 else 2 if sigma >= 0.0095 else 3
    text = f"{value:.{digits}f} ± {max(sigma, 10.0**-digits):.{digits}f} {unit}".rstrip()
    return f"{text} (inferred)" if dimension["inferred"] else text


def rows(dimensions: Sequence[Mapping[str, Any]]) -> list[tuple[str, str, bool]]:
    """Name, value and whether it was measured, for a table."""
    return [(d["label"], value_text(d), not d["inferred"]) for d in dimensions]


def lines(dimensions: Sequence[Mapping[str, Any]]) -> list[Line]:
    """Those that have a place on the blade."""
    return [
        Line(
            f"{d['label']} {value_text(d)}",
            tuple((float(x), float(y), float(z)) for x, y, z in d["points_mm"]),
        )
        for d in dimensions
        if len(d.get("points_mm") or ()) >= 2
    ]


def file_facts(path: Path, role: str) -> dict[str, Any]:
    """Name without folders, what the file is, its SHA-256 and size, for the record."""
    digest = hashlib.sha256()
    size = 0
    with path.open("rb") as file:
        while block := file.read(_HASH_BLOCK):
            digest.update(block)
            size += len(block)
    return {"name": path.name, "role": role, "sha256": digest.hexdigest(), "bytes": size}
