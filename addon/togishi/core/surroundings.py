"""An HDRI as the renderer takes it: repaired, its brightest spots taken out and made lamps, with the light on matt things.

Pictures are equirectangular, row 0 at the bottom (looking down), as Blender lays them out: u = 1/2 - longitude/2π, the
longitude from x towards y; v = 1/2 + latitude/π.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scene_data import F32, F64, BrightSpot, Environment

MOST_COLUMNS = 2048
# Half floats end at 65504; what is brighter is taken out as a lamp, or cut.
BRIGHTEST = 6.0e4
MOST_SPOTS = 8
# A spot is this much brighter than its picture (without its brightest hundredth), and no larger.
SPOT_CONTRAST = 30.0
SPOT_RADIUS_RAD = math.radians(3.0)
# Of all light, below which a spot stays in the picture.
SPOT_SHARE = 0.003
IRRADIANCE_SIZE = (32, 16)
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def directions(width: int, height: int) -> F64:
    """(height, width, 3) unit, of the texels' centres."""
    longitude = (0.5 - (np.arange(width) + 0.5) / width) * 2.0 * math.pi
    latitude = ((np.arange(height) + 0.5) / height - 0.5) * math.pi
    cosine = np.cos(latitude)[:, None]
    result: F64 = np.stack(
        [
            cosine * np.cos(longitude),
            cosine * np.sin(longitude),
            np.broadcast_to(np.sin(latitude)[:, None], (height, width)),
        ],
        axis=-1,
    )
    return result


def solid_angles(width: int, height: int) -> F64:
    """(height, 1) sr of each texel of a row."""
    edges = np.sin((np.arange(height + 1) / height - 0.5) * math.pi)
    result: F64 = (np.diff(edges) * 2.0 * math.pi / width)[:, None]
    return result


def reduced(pixels: F32, width: int, height: int) -> F32:
    """Mean over blocks, of a picture that is no smaller."""
    rows = (np.arange(height) * pixels.shape[0]) // height
    columns = (np.arange(width) * pixels.shape[1]) // width
    total = np.add.reduceat(np.add.reduceat(pixels, rows, axis=0), columns, axis=1)
    counts = (
        np.diff(np.append(rows, pixels.shape[0]))[:, None, None]
        * np.diff(np.append(columns, pixels.shape[1]))[None, :, None]
    )
    result: F32 = (total / counts).astype(np.float32)
    return result


def with_border(pixels: F32) -> F32:
    """One texel more on each side: round the sphere, and across its poles."""
    half = pixels.shape[1] // 2
    rows = np.concatenate(
        [np.roll(pixels[:1], half, axis=1), pixels, np.roll(pixels[-1:], half, axis=1)]
    )
    return np.ascontiguousarray(np.concatenate([rows[:, -1:], rows, rows[:, :1]], axis=1))


def repaired(pixels: F32) -> F32:
    """NaN and negative light become 0, infinite light the brightest finite value."""
    finite = np.isfinite(pixels)
    brightest = float(pixels[finite].max(initial=0.0))
    result: F32 = np.where(np.isnan(pixels), np.float32(0.0), pixels)
    return np.clip(result, 0.0, min(brightest, 1.0e30)).astype(np.float32)


@dataclass(frozen=True)
class _Window:
    """Part of a picture about one texel, which lies in its middle column."""

    rows: slice
    columns: NDArray[np.int64]


def _window(shape: tuple[int, int], row: int, column: int) -> _Window:
    height, width = shape
    reach = math.ceil(1.5 * SPOT_RADIUS_RAD * height / math.pi) + 2
    latitude = ((row + 0.5) / height - 0.5) * math.pi
    across = math.ceil(reach * (width / (2.0 * height)) / max(math.cos(latitude), 1e-3))
    across = min(across, (width - 1) // 2)
    return _Window(
        slice(max(row - reach, 0), min(row + reach + 1, height)),
        np.arange(column - across, column + across + 1) % width,
    )


def _grown(bright: NDArray[np.bool_], row: int, column: int) -> NDArray[np.bool_]:
    """What hangs together with one texel of a mask."""
    spot = np.zeros_like(bright)
    spot[row, column] = True
    while True:
        wider = spot.copy()
        wider[1:] |= spot[:-1]
        wider[:-1] |= spot[1:]
        wider[:, 1:] |= wider[:, :-1].copy()
        wider[:, :-1] |= wider[:, 1:].copy()
        wider &= bright
        if (wider == spot).all():
            return spot
        spot = wider


def without_spots(pixels: F32) -> tuple[F32, tuple[BrightSpot, ...]]:
    """The picture without its small bright spots (the sun, bare bulbs), and these, brightest first."""
    height, width = pixels.shape[:2]
    angles = solid_angles(width, height)
    towards = directions(width, height)
    picture = pixels.astype(np.float64)
    luminance = picture @ _LUMINANCE
    total = float((luminance * angles).sum())
    if not total > 0.0:
        return pixels, ()
    usual = float(np.minimum(luminance, np.quantile(luminance, 0.99)).mean())
    threshold = max(SPOT_CONTRAST * usual, 1.0e-6)
    left = luminance.copy()
    spots: list[tuple[float, BrightSpot]] = []
    for _ in range(4 * MOST_SPOTS):
        row, column = np.unravel_index(int(left.argmax()), left.shape)
        if left[row, column] <= threshold or len(spots) == MOST_SPOTS:
            break
        window = _window((height, width), int(row), int(column))
        at = np.ix_(np.arange(height)[window.rows], window.columns)
        bright = left[at] > max(threshold, 0.02 * left[row, column])
        middle = (int(row) - window.rows.start, len(window.columns) // 2)
        spot = _grown(bright, *middle)
        left[at] = np.where(spot, 0.0, left[at])
        peak = towards[row, column]
        distance = np.arccos(np.clip(towards[at][spot] @ peak, -1.0, 1.0)).max(initial=0.0)
        if distance > SPOT_RADIUS_RAD or spot.all():
            continue
        around = np.median(picture[at][~spot], axis=0)
        weights = np.broadcast_to(angles[window.rows], spot.shape)[spot]
        excess = np.maximum(picture[at][spot] - around, 0.0)
        irradiance = (excess * weights[:, None]).sum(axis=0)
        amount = float(irradiance @ _LUMINANCE)
        if amount < SPOT_SHARE * total:
            continue
        shine = excess @ _LUMINANCE
        centre = ((shine * weights)[:, None] * towards[at][spot]).sum(axis=0)
        centre /= np.linalg.norm(centre)
        covered = amount / max(float(shine.max()), 1e-30)
        spots.append(
            (
                amount,
                BrightSpot(
                    tuple(centre.tolist()),
                    tuple(irradiance.tolist()),
                    math.acos(max(1.0 - covered / (2.0 * math.pi), -1.0)),
                ),
            )
        )
        picture[at] = np.where(spot[..., None], around, picture[at])
    spots.sort(key=lambda item: -item[0])
    return picture.astype(np.float32), tuple(spot for _amount, spot in spots)


def matt_light(pixels: F32) -> F32:
    """(16, 32, 3): what a white matt surface of each normal shines with: the irradiance over π."""
    for axis, least in ((0, 16), (1, 32)):
        if pixels.shape[axis] < least:
            pixels = np.repeat(pixels, math.ceil(least / pixels.shape[axis]), axis=axis)
    width, height = min(pixels.shape[1], 128), min(pixels.shape[0], 64)
    small = reduced(pixels, width, height).astype(np.float64)
    weighted = (small * solid_angles(width, height)[..., None]).reshape(-1, 3)
    normals = directions(*IRRADIANCE_SIZE).reshape(-1, 3)
    cosines = np.maximum(normals @ directions(width, height).reshape(-1, 3).T, 0.0)
    # As a white room gives exactly 1, whatever the sum's own error is.
    share = cosines / (cosines * solid_angles(width, height).repeat(width)).sum(axis=1)[:, None]
    result: F32 = (share @ weighted).astype(np.float32)
    return result.reshape(IRRADIANCE_SIZE[1], IRRADIANCE_SIZE[0], 3)


def prepare(pixels: F32) -> Environment:
    """pixels: (height, width, 3 or more) linear RGB. At most MOST_COLUMNS wide afterwards."""
    picture = repaired(np.ascontiguousarray(pixels[..., :3], np.float32))
    height, width = picture.shape[:2]
    if width > MOST_COLUMNS:
        height = max(round(height * MOST_COLUMNS / width), 1)
        picture = reduced(picture, MOST_COLUMNS, height)
    picture, spots = without_spots(picture)
    picture = np.minimum(picture, np.float32(BRIGHTEST))
    return Environment(picture, matt_light(picture), spots)


# --- the atlas of blurred levels ------------------------------------------------------------------


@dataclass(frozen=True)
class Level:
    """Where a level lies in the atlas, without its border, and how much wider than the one before it is."""

    x: int
    y: int
    width: int
    height: int
    blur_rad: float  # from the level before it


@dataclass(frozen=True)
class Atlas:
    width: int
    height: int
    levels: tuple[Level, ...]
    irradiance: tuple[int, int]  # corner of the matt light, without its border
    texel_rad: float


def atlas_of(width: int, height: int) -> Atlas:
    """Level 0: the picture; 1 and 2: blurred by one and by two texels; from there on half octaves, each on a grid of half its
    own blur (shaders/viewport/environment.glsl reads the same series)."""
    texel = max(2.0 * math.pi / width, math.pi / height)
    sizes = [(width, height)] * 3
    variances = [0.0, 1.0, 4.0]
    # What reading between texels adds, of the level's own texel squared.
    reading = [1.0 / 6.0] * 3
    while True:
        share = 2.0 ** (-0.5 * (len(sizes) - 2))
        size = (round(width * share), round(height * share))
        if min(size[0] // 2, size[1]) < 8:
            break
        sizes.append(size)
        variances.append(4.0 / share**2)
        reading.append(1.0 / 6.0 / share**2)
    levels = []
    x, y, shelf, widest = 0, 0, 0, width + 2
    for number, (columns, rows) in enumerate(sizes):
        if x + columns + 2 > widest:
            x, y, shelf = 0, y + shelf, 0
        blur = variances[number] - (variances[number - 1] + reading[number - 1] if number else 0.0)
        levels.append(Level(x + 1, y + 1, columns, rows, texel * math.sqrt(max(blur, 0.0))))
        x, shelf = x + columns + 2, max(shelf, rows + 2)
    columns, rows = IRRADIANCE_SIZE
    widest = max(widest, columns + 2)
    if x + columns + 2 > widest:
        x, y, shelf = 0, y + shelf, 0
    corner = (x + 1, y + 1)
    return Atlas(widest, y + max(shelf, rows + 2), tuple(levels), corner, texel)
