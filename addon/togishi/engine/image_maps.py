"""A blade's images as atlases with mip levels."""

from __future__ import annotations

import bpy
import numpy as np

from ..core import native, packing
from ..core.scene_data import MapData, NormalMapData


class MapError(ValueError):
    """A map cannot be used; the message names the image and its file."""


def image_key(image: bpy.types.Image) -> tuple[object, ...]:
    """Changes when the image has other content. Whoever writes pixels adds 1 to the image's custom property
    "togishi_revision"; Blender itself does not count changes."""
    image = image.original if image.is_evaluated else image
    return (
        image.session_uid,
        image.filepath,
        tuple(image.size),
        int(image.get("togishi_revision", 0)),
    )


def linear_pixels(image: bpy.types.Image) -> np.ndarray | None:
    """(H, W, 3) float32 linear RGB, row 0 at the bottom; None where there are no pixels or no colours."""
    image = image.original if image.is_evaluated else image
    width, height = image.size
    if width <= 0 or height <= 0 or image.channels < 3:
        return None
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    colours = pixels.reshape(height, width, image.channels)[..., :3]
    # Blender hands over the numbers of 8-bit files as the file has them.
    if image.is_float or image.colorspace_settings.name in {"Non-Color", "Linear Rec.709"}:
        return colours
    low = colours / 12.92
    high = ((colours + 0.055) / 1.055) ** 2.4
    return np.where(colours <= 0.04045, low, high).astype(np.float32)


def image_pixels(image: bpy.types.Image) -> np.ndarray:
    """(H, W, 4) float32, row 0 at the bottom. Raises MapError where there are no pixels."""
    image = image.original if image.is_evaluated else image
    width, height = image.size
    if width <= 0 or height <= 0 or image.channels == 0:
        path = bpy.path.abspath(image.filepath, library=image.library)
        where = path or "no file, and nothing packed"
        raise MapError(
            f"Map image {image.name!r} cannot be read ({where}): constants per part are used."
        )
    if image.channels != 4:
        raise MapError(
            f"Map image {image.name!r} has {image.channels} channels instead of 4 (RGBA): "
            "constants per part are used."
        )
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)


def read_maps(lobes: bpy.types.Image, shape: bpy.types.Image | None) -> MapData:
    """Atlases of a blade's images. Raises MapError with a sentence for the user."""
    lobe_pixels = image_pixels(lobes)
    shape_pixels = None if shape is None else image_pixels(shape)
    core = native.core()
    try:
        return packing.map_data(*core.pack_mip_atlas(lobe_pixels, shape_pixels))
    except core.InputError as error:
        raise MapError(
            f"Map image {lobes.name!r}: {error}: constants per part are used."
        ) from error


def read_normal_map(image: bpy.types.Image) -> NormalMapData:
    """Atlases of a normal map. Raises MapError with a sentence for the user."""
    image = image.original if image.is_evaluated else image
    width, height = image.size
    if width <= 0 or height <= 0 or image.channels == 0:
        path = bpy.path.abspath(image.filepath, library=image.library)
        where = path or "no file, and nothing packed"
        raise MapError(f"Normal map {image.name!r} cannot be read ({where}): none is used.")
    if image.channels < 3:
        raise MapError(
            f"Normal map {image.name!r} has {image.channels} channels instead of 3 or 4 (RGB, RGBA): none is used."
        )
    if not image.colorspace_settings.is_data:
        raise MapError(
            f"Normal map {image.name!r} is in the colour space {image.colorspace_settings.name!r}: none is used. "
            "Set it to Non-Color."
        )
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    core = native.core()
    try:
        return NormalMapData(*core.pack_normal_atlas(pixels.reshape(height, width, image.channels)))
    except core.InputError as error:
        raise MapError(f"Normal map {image.name!r}: {error}: none is used.") from error
