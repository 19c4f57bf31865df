"""Scene-linear arrays to PNG: the demo's display step, difference maps, contact sheets. No bpy.

Arrays are (height, width, 3) linear Rec.709, row 0 at the bottom as Blender holds them.
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from PIL import Image

Linear = NDArray[np.floating]


def exposure_of(linear: Linear, mask: NDArray[np.bool_], percentile: float = 99.0) -> float:
    """The factor that brings this percentile of the masked luminance to 1; 1 for a black picture."""
    luminance = linear[mask] @ np.array([0.2126, 0.7152, 0.0722])
    level = float(np.percentile(luminance, percentile)) if luminance.size else 0.0
    return 1.0 / level if level > 0.0 else 1.0


def to_display(linear: Linear, exposure: float) -> NDArray[np.uint8]:
    """sRGB bytes, top row first. Straight up to 0.7, then a shoulder that reaches 1 at infinity, so that a
    flash does not turn into a flat white patch; chromaticity is kept by scaling the three together."""
    scaled = np.clip(np.nan_to_num(linear) * exposure, 0.0, None)
    peak = scaled.max(axis=-1, keepdims=True)
    knee = 0.7
    rolled = np.where(peak > knee, 1.0 - (1.0 - knee) ** 2 / (peak + 1.0 - 2.0 * knee), peak)
    shown = scaled * np.where(peak > knee, rolled / np.maximum(peak, 1e-30), 1.0)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    return np.ascontiguousarray((np.clip(encoded, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)[::-1])


def difference_map(delta_e: NDArray[np.floating], full_scale: float) -> NDArray[np.uint8]:
    """ΔE00 per pixel as colour from black (0) to light yellow (full_scale); NaN (no blade) is dark grey."""
    colours = mpl.colormaps["inferno"](np.clip(delta_e / full_scale, 0.0, 1.0))[..., :3]
    colours[np.isnan(delta_e)] = 0.12
    return np.ascontiguousarray((colours * 255.0 + 0.5).astype(np.uint8)[::-1])


def save(path: Path, picture: NDArray[np.uint8]) -> None:
    """Writes a PNG whole or not at all."""
    temporary = path.with_suffix(".part.png")
    Image.fromarray(picture).save(temporary)
    temporary.replace(path)


def contact_sheet(frames: list[NDArray[np.uint8]], columns: int, gap: int = 6) -> NDArray[np.uint8]:
    """Frames of one size in reading order on black."""
    height, width = frames[0].shape[:2]
    rows = -(-len(frames) // columns)
    sheet = np.zeros((rows * (height + gap) + gap, columns * (width + gap) + gap, 3), np.uint8)
    for i, frame in enumerate(frames):
        y = gap + (i // columns) * (height + gap)
        x = gap + (i % columns) * (width + gap)
        sheet[y : y + height, x : x + width] = frame
    return sheet


def load(path: Path) -> NDArray[np.uint8]:
    """A PNG's sRGB bytes (height, width, 3), top row first."""
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))
