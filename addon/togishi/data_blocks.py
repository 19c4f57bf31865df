"""Blender's data as long work needs it: found again after it, and pictures of its results kept in the file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray


def by_uid(collection: Iterable[Any], uid: int) -> Any | None:
    """The data block of this session_uid, or None where it is gone. References do not outlive undo; the number does."""
    return next((block for block in collection if block.session_uid == uid), None)


def write_picture(
    name: str, existing: bpy.types.Image | None, pixels: NDArray[np.uint8]
) -> bpy.types.Image:
    """(H, W, 3), the top row first, as a packed image: `existing` where it has that size, else a new one; then
    `existing` is removed where nothing else uses it."""
    height, width = pixels.shape[:2]
    image = existing
    if image is None or tuple(image.size) != (width, height):
        if image is not None and image.users == 0:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(name, width, height, alpha=False)
    rgba = np.ones((height, width, 4), np.float32)
    # Blender's rows run upwards.
    rgba[..., :3] = pixels[::-1].astype(np.float32) / 255.0
    image.pixels.foreach_set(rgba.reshape(-1))
    image.update()
    image.pack()
    return image


def show_in_new_window(context: bpy.types.Context, image: bpy.types.Image) -> None:
    bpy.ops.wm.window_new()
    area = context.window_manager.windows[-1].screen.areas[0]
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = image
