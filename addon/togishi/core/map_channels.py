"""Property maps by channel name <-> the two RGBA images of a material (docs/architecture.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]

LOBES = ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h")
SHAPE = ("ji.e1", "ji.e2", "ha.e1", "ha.e2")
REQUIRED = ("ji.ln_mu_deg", "ha.ln_mu_deg", "w")


class MapError(ValueError):
    """Maps that do not fit together. The message names the channel, what it is and what is allowed."""


def map_size(maps: Mapping[str, F32]) -> tuple[int, int]:
    """(height, width) of the channels that vary; every channel is of that size or 1 x 1."""
    for name in REQUIRED:
        if name not in maps:
            raise MapError(f"maps: channel {name!r} is missing; needed are {', '.join(REQUIRED)}")
    size = (1, 1)
    for name, values in maps.items():
        if values.ndim != 2:
            raise MapError(
                f"maps: channel {name!r} has {values.ndim} axes; it must have 2 (rows, columns)"
            )
        if values.shape == (1, 1) or values.shape == size:
            continue
        if size != (1, 1):
            raise MapError(
                f"maps: channel {name!r} is {values.shape[1]} x {values.shape[0]}; "
                f"other channels are {size[1]} x {size[0]}"
            )
        size = (values.shape[0], values.shape[1])
    return size


def to_images(maps: Mapping[str, F32]) -> tuple[F32, F32 | None]:
    """(lobes, shape) as (H, W, 4); shape is None where every lobe is round."""
    size = map_size(maps)
    zero = np.zeros((1, 1), np.float32)

    def gather(names: tuple[str, ...]) -> F32:
        image = np.empty((*size, 4), np.float32)
        for index, name in enumerate(names):
            image[..., index] = maps.get(name, zero)
        return image

    anisotropic = any(bool(np.any(np.abs(maps[name]) > 1e-6)) for name in SHAPE if name in maps)
    return gather(LOBES), gather(SHAPE) if anisotropic else None


def from_images(lobes: F32, shape: F32 | None) -> dict[str, F32]:
    """The channels of the two images, copied out."""
    maps = {name: np.ascontiguousarray(lobes[..., i]) for i, name in enumerate(LOBES)}
    if shape is not None:
        maps |= {name: np.ascontiguousarray(shape[..., i]) for i, name in enumerate(SHAPE)}
    return maps
