"""Places on a blade that a photograph's camera is found by."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]

SNAP_MM = 4.0


def edge_points(positions_mm: F64, s_mm: NDArray[np.float32], t_mm: NDArray[np.float32]) -> F64:
    """(N, 3): the vertices of the cutting edge from the machi to the tip, in order of s. They lie in the blade's
    middle plane, far from the mune."""
    at_edge = (np.abs(positions_mm[:, 1]) < 1e-3) & (t_mm > 0.5 * t_mm.max()) & (s_mm >= 0.0)
    points: F64 = positions_mm[at_edge]
    return np.take(points, np.argsort(s_mm[at_edge]), axis=0)


def snapped(
    point_mm: F64, places: Mapping[str, tuple[float, float, float]], edge: F64
) -> tuple[str, F64]:
    """(name, point): the nearest named place within SNAP_MM, else the nearest point of the edge within it, else the
    point itself."""
    names, points = list(places), np.array(list(places.values()), np.float64).reshape(-1, 3)
    if len(points):
        distance = np.linalg.norm(points - point_mm, axis=1)
        best = int(distance.argmin())
        if distance[best] <= SNAP_MM:
            return names[best], points[best]
    if len(edge):
        distance = np.linalg.norm(edge - point_mm, axis=1)
        best = int(distance.argmin())
        if distance[best] <= SNAP_MM:
            return f"edge at {edge[best, 0]:.0f} mm", edge[best]
    return f"point at {point_mm[0]:.0f} mm", np.asarray(point_mm, np.float64)
