"""The stroke direction of a blade's mesh, and how it follows a mesh that was turned.

Blender turns positions and normals when a rotation is applied to a mesh (Ctrl+A), but no attribute. The chart's own
direction, that of growing u, is then right; the stored one, which is exact to a tenth of a degree where the chart errs by
one, is turned after it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene_data import F32

F64 = NDArray[np.float64]
_AGREE_DEG = 3.0


def uv_tangents(position: F32, uv: F32, triangles: NDArray[np.integer[Any]]) -> F32:
    """(V, 3) direction of growing u at each vertex, not yet perpendicular to the normal; zero where
    the UVs have no area."""
    p, t = position[triangles], uv[triangles]
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    d1, d2 = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    area = d1[:, 0] * d2[:, 1] - d2[:, 0] * d1[:, 1]
    # Times the area's sign only: large triangles weigh more, folded ones do not turn the direction.
    face = (e1 * d2[:, 1:2] - e2 * d1[:, 1:2]) * np.sign(area)[:, None]
    total = np.zeros((len(position), 3), np.float64)
    for corner in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(
                triangles[:, corner], weights=face[:, axis], minlength=len(position)
            )
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.divide(total, length, out=np.zeros_like(total), where=length > 0).astype(np.float32)


def _angles_deg(a: F64, b: F64) -> F64:
    """The angles between unit directions; strokes have no sign."""
    cosine = np.abs(np.einsum("ij,ij->i", a, b))
    angles: F64 = np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
    return angles


def turned_with_mesh(own: F32, chart: F32) -> F32:
    """The stored directions `own` (V, 3), turned as the mesh was since: one rotation or reflection for all, found
    against the directions `chart` (V, 3) of growing u. `own` itself where the two agree, or where no rotation makes them."""
    lengths = np.linalg.norm(own, axis=1)
    used = (lengths > 1e-6) & (np.linalg.norm(chart, axis=1) > 0.5)
    if not used.any():
        return own
    a = own[used].astype(np.float64) / lengths[used, None]
    b = chart[used].astype(np.float64)
    if np.median(_angles_deg(a, b)) < _AGREE_DEG:
        return own
    turn = np.eye(3)
    fitting = np.ones(len(a), bool)
    # At seams and at the ends the chart's direction is another: those vertices are left out from the second round on.
    for _ in range(4):
        left, _, right = np.linalg.svd(b[fitting].T @ a[fitting])
        turn = left @ right
        off = _angles_deg(a @ turn.T, b)
        fitting = off <= max(float(np.median(off)), 0.01)
    if np.median(off) >= _AGREE_DEG:
        return own
    turned: F32 = (own @ turn.T).astype(np.float32)
    return turned
