"""Property maps as the two float images of a material (docs/architecture.md, "Inside Blender")."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from . import properties
from .core import map_channels

# Counts the contents of an image, for those who keep what they made of it.
REVISION = "togishi_revision"


def _others_use(image: bpy.types.Image, material: bpy.types.Material) -> bool:
    """Whether another material has the map too, as after copying a material or a scene."""
    return any(
        image in properties.blade_images(other)
        for other in bpy.data.materials
        if other != material and properties.is_blade(other)
    )


def _write(
    name: str,
    existing: bpy.types.Image | None,
    pixels: NDArray[np.float32],
    material: bpy.types.Material,
) -> bpy.types.Image:
    height, width = pixels.shape[:2]
    image = existing
    if image is not None and _others_use(image, material):
        image = existing = None
    if image is None or tuple(image.size) != (width, height) or not image.is_float or image.library:
        image = bpy.data.images.new(
            name, width, height, alpha=True, float_buffer=True, is_data=True
        )
    # Channels are data: alpha is the hadori, never an opacity to multiply by.
    image.alpha_mode = "CHANNEL_PACKED"
    image.colorspace_settings.name = "Non-Color"
    image.use_half_precision = False
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).reshape(-1))
    image[REVISION] = int(image.get(REVISION, 0)) + 1
    image.update()
    image.pack()
    return image


STRETCH = "togishi_stretch"


def _keep_stretch(image: bpy.types.Image, pixels: NDArray[np.float32]) -> None:
    r = np.sqrt((np.nan_to_num(pixels).reshape(-1, 2, 2) ** 2).sum(axis=2))
    image[STRETCH] = [float(value) for value in r.max(axis=0, initial=0.0)]


def largest_stretch(shape: bpy.types.Image) -> tuple[float, float]:
    """Largest ln sqrt(mu_t/mu_b) of the ji and the ha in a shape map. Kept with the image: a map of 4096 x 512
    takes .2 s to look through."""
    if STRETCH not in shape:
        _keep_stretch(shape, _pixels(shape))
    ji, ha = shape[STRETCH]
    return float(ji), float(ha)


def assign(material: bpy.types.Material, maps: Mapping[str, NDArray[np.float32]]) -> None:
    """Write maps (channel name -> (H, W) or (1, 1), rows from v = 0) into the material's images."""
    lobes, shape = map_channels.to_images(maps)
    settings = material.togishi
    before = properties.blade_images(material)
    with properties.held_updates():
        settings.lobes_image = _write(
            f"{material.name} lobes", settings.lobes_image, lobes, material
        )
        if shape is None:
            settings.shape_image = None
        else:
            settings.shape_image = _write(
                f"{material.name} shape", settings.shape_image, shape, material
            )
            _keep_stretch(settings.shape_image, shape)
    properties.notify(material)
    _remove_unused(before)


def _remove_unused(images: Iterable[bpy.types.Image | None]) -> None:
    """Former maps that nothing shows any more, the node groups neither: one of 8192 x 1024 takes 134 MB."""
    for image in images:
        if image is not None and image.library is None and image.users == 0:
            bpy.data.images.remove(image)


def _pixels(image: bpy.types.Image) -> NDArray[np.float32]:
    width, height = image.size
    if width == 0 or height == 0 or not image.has_data:
        image.reload()
        width, height = image.size
    if width == 0 or height == 0:
        raise FileNotFoundError(
            f"image {image.name!r}: no pixels; its file {bpy.path.abspath(image.filepath)!r} is missing or unreadable"
        )
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)


def read(material: bpy.types.Material) -> dict[str, NDArray[np.float32]]:
    """The material's maps by channel name. Raises FileNotFoundError where a map's file is missing."""
    lobes, shape = properties.blade_images(material)
    if lobes is None:
        return {}
    return map_channels.from_images(_pixels(lobes), None if shape is None else _pixels(shape))


def missing(material: bpy.types.Material) -> list[str]:
    """Sentences about map images whose file cannot be found."""
    found = []
    for image in (*properties.blade_images(material), material.togishi.normal_image):
        if image is not None and image.packed_file is None and image.source == "FILE":
            path = bpy.path.abspath(image.filepath, library=image.library)
            from pathlib import Path

            if not Path(path).is_file():
                found.append(
                    f"material {material.name!r}: map image {image.name!r}: no such file: {path}"
                )
    return found


def clear(material: bpy.types.Material) -> None:
    """Take the maps off the material; its lobes per part apply again."""
    with properties.held_updates():
        material.togishi.lobes_image = None
        material.togishi.shape_image = None
    properties.notify(material)


def summary(image: Any) -> str:
    """Size of a map for a panel; reads no pixels."""
    return f"{image.size[0]} × {image.size[1]}"
