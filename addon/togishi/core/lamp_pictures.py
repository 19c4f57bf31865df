"""Pictures that rectangles shine with, as one texture with levels (shaders/viewport/pictures.glsl)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .scene_data import F32, F64, LampPicture, Light
from .shader_source import PICTURE_CAPACITY, PICTURE_LEVELS

MAX_SIDE = 1 << (PICTURE_LEVELS - 1)


@dataclass(frozen=True, eq=False)
class Atlas:
    """All levels of all pictures, each with a border of one texel."""

    texels: F32  # (H, W, 4)
    levels: tuple[
        tuple[tuple[int, int, int, int], ...], ...
    ]  # of each picture: x, y, width, height


def _resample(side: int, wanted: int) -> F64:
    """(wanted, side) weights: each new texel is the mean of what it covers."""
    edges = np.linspace(0.0, side, wanted + 1)
    low, high = edges[:-1, None], edges[1:, None]
    old = np.arange(side)[None, :]
    cover = np.clip(np.minimum(high, old + 1) - np.maximum(low, old), 0.0, None)
    weights: F64 = cover / cover.sum(axis=1, keepdims=True)
    return weights


def power_of_two(pixels: F32) -> F32:
    """A picture (H, W, 3) with sides that are powers of two, 1024 at most: the longer one at or below its own, the other so
    that texels are as square as can be. Light that is none becomes 0."""
    finite = np.where(np.isfinite(pixels), pixels, 0.0).clip(0.0, 1.0e30)
    sides = pixels.shape[:2]
    longer = min(1 << (max(sides).bit_length() - 1), MAX_SIDE)
    height, width = (
        max(1, min(longer, 1 << max(round(math.log2(longer * side / max(sides))), 0)))
        for side in sides
    )
    rows = np.tensordot(_resample(pixels.shape[0], height), finite, axes=1)
    both = np.tensordot(_resample(pixels.shape[1], width), rows, axes=(1, 1)).swapaxes(0, 1)
    return np.ascontiguousarray(both, np.float32)


def _levels(pixels: F32) -> list[F32]:
    """Down to one texel, each half as high and as wide as the one before it."""
    levels = [pixels]
    while max(levels[-1].shape[:2]) > 1:
        last = levels[-1]
        for axis in (0, 1):
            if last.shape[axis] > 1:
                last = 0.5 * (
                    np.take(last, range(0, last.shape[axis], 2), axis)
                    + np.take(last, range(1, last.shape[axis], 2), axis)
                )
        levels.append(last.astype(np.float32))
    return levels


def atlas_of(pictures: Sequence[LampPicture]) -> Atlas:
    """At most PICTURE_CAPACITY of them."""
    blocks = []
    places = []
    top = 0
    known: dict[int, tuple[tuple[int, int, int, int], ...]] = {}
    for picture in pictures[:PICTURE_CAPACITY]:
        # The two sides of a rectangle have one picture.
        if id(picture.pixels) in known:
            places.append(known[id(picture.pixels)])
            continue
        levels = _levels(picture.pixels)
        right = levels[0].shape[1] + 2
        at = [(1, top + 1)]
        column = top
        for level in levels[1:]:
            at.append((right + 1, column + 1))
            column += level.shape[0] + 2
        places.append(
            tuple(
                (x, y, level.shape[1], level.shape[0])
                for (x, y), level in zip(at, levels, strict=True)
            )
        )
        known[id(picture.pixels)] = places[-1]
        blocks += list(zip(at, levels, strict=True))
        top = max(top + levels[0].shape[0] + 2, column)
    width = max((x + level.shape[1] + 1 for (x, _y), level in blocks), default=1)
    texels = np.zeros((max(top, 1), width, 4), np.float32)
    for (x, y), level in blocks:
        bordered = np.pad(level, ((1, 1), (1, 1), (0, 0)), mode="edge")
        texels[y - 1 : y + level.shape[0] + 1, x - 1 : x + level.shape[1] + 1, :3] = bordered
    # The texture holds half floats.
    return Atlas(np.minimum(texels, 65000.0), tuple(places))


def pictures_of(lights: Sequence[Light]) -> list[LampPicture]:
    """Each once, in the lamps' order."""
    found = {
        id(light.picture): light.picture
        for light in lights
        if light.picture is not None and not light.dark
    }
    return list(found.values())


def pictures_block(pictures: Sequence[LampPicture], atlas: Atlas) -> F32:
    """TgPictures."""
    rows = 3 + PICTURE_LEVELS
    block = np.zeros((1 + rows * PICTURE_CAPACITY, 4), np.float32)
    height, width = atlas.texels.shape[:2]
    block[0, :2] = (1.0 / width, 1.0 / height)
    for number, levels in enumerate(atlas.levels):
        picture = pictures[number]
        own = block[1 + rows * number : 1 + rows * (number + 1)]
        # The shader's second axis runs against the lamp's (packing.areas_block).
        (ux, uy, u0), (vx, vy, v0) = picture.to_u, picture.to_v
        own[0, :3] = (ux, -uy, u0)
        own[1, :3] = (vx, -vy, v0)
        texels = abs(ux * vy - uy * vx) * levels[0][2] * levels[0][3]
        own[2, :2] = (len(levels), max(texels, 1e-12) ** 0.5)
        own[3 : 3 + len(levels)] = levels
    return block
