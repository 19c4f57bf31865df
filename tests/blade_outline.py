"""A blade photographed against the light, drawn from its mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def against_the_light(camera: dict[str, Any], mesh: Any) -> NDArray[np.float32]:
    """The blade, dark before a bright ground. camera: as togishi_core's, orthographic; mesh: togishi_core.katana."""
    right, down = np.array(camera["right"]), np.array(camera["down"])
    to = mesh.positions_mm - np.array(camera["position_mm"])
    pixel = np.stack([to @ right, to @ down], -1) * camera["scale"] + camera["centre_px"]
    picture = np.full((camera["height_px"], camera["width_px"]), 0.9, np.float32)
    for first, last in zip(mesh.face_start[:-1], mesh.face_start[1:], strict=True):
        corners = pixel[mesh.corner_vertex[first:last]]
        low = np.clip(np.floor(corners.min(0)), 0, picture.shape[::-1]).astype(int)
        high = np.clip(np.ceil(corners.max(0)), 0, picture.shape[::-1]).astype(int)
        y, x = np.mgrid[low[1] : high[1], low[0] : high[0]] + 0.5
        sides = [
            (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
        ]
        inside = np.all(np.array(sides) >= 0, 0) | np.all(np.array(sides) <= 0, 0)
        picture[low[1] : high[1], low[0] : high[0]][inside] = 0.1
    return picture
