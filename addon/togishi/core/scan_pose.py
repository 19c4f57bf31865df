"""What a handle that was moved says of a scan's pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

# Options of togishi_core.scan_import that the user gives as corrections of what was found.
CORRECTIONS = ("swap_ends", "swap_edge_and_back", "machi", "kissaki_mm")
# Less than this the handle was not moved, mm: single precision in the scene.
_MOVED_MM = 0.01


def turned(axes: Any) -> tuple[bool, bool]:
    """Whether ends, and edge and back, are the other way round. axes: (3, 3), columns the handle's directions in the
    blade's; of its turns by half a circle the nearest counts."""
    matrix = np.asarray(axes, float)
    matrix = matrix / np.maximum(np.linalg.norm(matrix, axis=0), 1e-12)
    x, y, z = np.diagonal(matrix)
    turns = {(False, False): x + y + z, (True, False): -x - y + z}
    turns |= {(False, True): x - y - z, (True, True): -x + y - z}
    return max(turns, key=lambda turn: float(turns[turn]))


def place_in_scan(
    pose: Mapping[str, Any], mm_per_unit: float, blade_mm: Sequence[float]
) -> list[float]:
    """A place in blade coordinates (mm) as the scan's file has it, in its unit. pose: of the import's report."""
    rotation = np.asarray(pose["rotation"], float)
    place = np.asarray(pose["origin_mm"], float) + rotation.T @ np.asarray(blade_mm, float)
    return [float(v) for v in place / mm_per_unit]


def corrected(
    options: Mapping[str, Any], report: Mapping[str, Any], axes: Any, place_mm: Sequence[float]
) -> dict[str, Any]:
    """The import's options with what the handle says. report: of the import; axes: as turned() has them; place_mm: of
    the handle, in blade coordinates. ValueError where it says nothing new."""
    result = dict(options)
    swaps = turned(axes)
    for name, swapped in zip(CORRECTIONS, swaps, strict=False):
        result[name] = bool(options.get(name, False)) != swapped
    moved = float(np.linalg.norm(place_mm)) > _MOVED_MM
    if moved:
        unit = float(report["unit"]["mm_per_unit"])
        result["machi"] = place_in_scan(report["pose"], unit, place_mm)
    if not moved and not any(swaps):
        raise ValueError("The pose handle was neither moved nor turned the other way round")
    return result
