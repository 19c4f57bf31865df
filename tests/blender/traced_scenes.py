"""Scenes in which one thing hides a lamp from another, or is mirrored by it."""

from __future__ import annotations

import numpy as np
from togishi.core import packing
from togishi.core.scene_data import Light, LightKind, MeshData

DOWN = {"x_axis": (1.0, 0.0, 0.0), "y_axis": (0.0, 1.0, 0.0), "z_axis": (0.0, 0.0, 1.0)}


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> MeshData:
    """A box along the axes, without parts."""
    corners = np.array(
        [[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)], np.float32
    )
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    normals = [(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)]
    corner = np.arange(24).reshape(6, 4)
    return packing.build_mesh(
        corners,
        np.asarray(faces, np.int32).reshape(-1),
        np.concatenate([corner[:, [0, 1, 2]], corner[:, [0, 2, 3]]]).astype(np.int32),
        np.tile(np.arange(6), 2).astype(np.int32),
        np.repeat(np.asarray(normals, np.float32), 4, axis=0),
        None, None, None, None,
    )  # fmt: skip


def square_lamp(
    x: float = 0.0, half_u: float = 0.5, half_v: float = 0.5, power: float = 100.0, z: float = 3.0
) -> Light:
    """A rectangle above, shining down, hidden by what stands before it."""
    return Light(
        LightKind.RECTANGLE, position=(x, 0.0, z), power=power, half_u=half_u, half_v=half_v,
        shadows=True, **DOWN,
    )  # fmt: skip
