"""Maps in OpenEXR files, as `togishi bake` writes them and `togishi info` reads them (cpp_core/image/map_file.hpp): named
channels, tiles, all mip levels; by the OpenImageIO that official Blender builds carry. Builds without it (Debian's) get
two RGBA files through bpy.data.images."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np
from numpy.typing import NDArray

from .core import atomic, map_channels, native
from .core.map_channels import MapError

F32 = NDArray[np.float32]
MAX_TEXELS = 16384 * 16384
TILE = 64
FORMAT = 1


@cache
def open_image_io() -> ModuleType | None:
    """Asked by every draw of a panel, so found once. Blender's own OpenImageIO module, or None. In the bpy wheels its folder is not on sys.path."""
    try:
        return importlib.import_module("OpenImageIO")
    except ImportError:
        pass
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    root = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib" / version / "site-packages"
    if not (root / "OpenImageIO").is_dir():
        return None
    # At the end: nothing of the running Python may be shadowed by it.
    sys.path.append(str(root))
    try:
        return importlib.import_module("OpenImageIO")
    except ImportError:
        return None
    finally:
        sys.path.remove(str(root))


def _pair(path: Path) -> tuple[Path, Path]:
    return path.with_suffix(".lobes.exr"), path.with_suffix(".shape.exr")


def _spec(oiio: ModuleType, level: Mapping[str, F32], first: bool) -> object:
    """The header of one mip level; what concerns the whole file goes into the first."""
    height, width = map_channels.map_size(level)
    spec = oiio.ImageSpec(width, height, len(level), "float")
    spec.channelnames = tuple(level)
    spec.tile_width = spec.tile_height = TILE
    if first:
        # OpenEXR's own numbers: mip levels, sizes rounded down.
        spec.attribute("textureformat", "Plain Texture")
        spec.attribute("openexr:levelmode", 1)
        spec.attribute("openexr:roundingmode", 0)
        spec.attribute("compression", "zip")
        spec.attribute("oiio:ColorSpace", "Raw")
        spec.attribute("togishi:format", FORMAT)
        spec.attribute("togishi:source", "exported from Blender")
        spec.attribute("Software", f"togishi {native.addon_version()}")
        constant = [name for name, values in level.items() if values.shape != (height, width)]
        if constant:
            spec.attribute("togishi:constant", ",".join(constant))
    return spec


def save(maps: Mapping[str, F32], path: Path) -> list[Path]:
    """Write maps; returns the files. Rows in the file run downwards, as images do; v = 0 is the last row."""
    oiio = open_image_io()
    if oiio is None:
        return _save_pair(maps, path)
    levels = native.core().map_mip_levels(dict(maps))
    with atomic.replacing(path) as temporary:
        output = oiio.ImageOutput.create(str(temporary))
        if output is None:
            raise OSError(f"{path}: cannot write this kind of file: {oiio.geterror()}")
        good = True
        for number, level in enumerate(levels):
            height, width = map_channels.map_size(level)
            pixels = np.empty((height, width, len(level)), np.float32)
            for index, values in enumerate(level.values()):
                pixels[..., index] = values
            mode = "AppendMIPLevel" if number else "Create"
            good = good and output.open(str(temporary), _spec(oiio, level, not number), mode)
            good = good and output.write_image(np.ascontiguousarray(pixels[::-1]))
        error = output.geterror()
        if not (output.close() and good):
            raise OSError(f"{path}: {error or output.geterror()}")
    return [path]


def _save_pair(maps: Mapping[str, F32], path: Path) -> list[Path]:
    written = []
    for target, pixels in zip(_pair(path), map_channels.to_images(maps), strict=True):
        if pixels is None:
            continue
        height, width = pixels.shape[:2]
        # is_data, or Blender would write encoded values.
        image = bpy.data.images.new(
            "togishi export", width, height, alpha=True, float_buffer=True, is_data=True
        )
        try:
            image.alpha_mode = "CHANNEL_PACKED"
            image.pixels.foreach_set(pixels.reshape(-1))
            image.file_format = "OPEN_EXR"
            with atomic.replacing(target) as temporary:
                image.save(filepath=str(temporary))
        except RuntimeError as error:
            raise OSError(f"{target}: {error}") from error
        finally:
            bpy.data.images.remove(image)
        written.append(target)
    return written


def load(path: Path) -> dict[str, F32]:
    """Channel name -> (H, W), rows from v = 0. Raises MapError or OSError naming file, channel and value."""
    oiio = open_image_io()
    if oiio is None:
        return _load_pair(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file")
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    try:
        spec = source.spec()
        if spec.width * spec.height > MAX_TEXELS:
            raise MapError(
                f"{path}: {spec.width} x {spec.height} texels; at most {MAX_TEXELS} are allowed"
            )
        names = list(spec.channelnames)
        known = {*map_channels.LOBES, *map_channels.SHAPE}
        if missing := [name for name in map_channels.REQUIRED if name not in names]:
            raise MapError(
                f"{path}: channel {missing[0]!r} is missing; the file has {', '.join(names)}; "
                f"needed are {', '.join(map_channels.REQUIRED)}"
            )
        pixels = source.read_image("float")
        if pixels is None:
            raise OSError(f"{path}: {source.geterror()}")
    finally:
        source.close()
    rows = np.asarray(pixels, np.float32).reshape(spec.height, spec.width, len(names))[::-1]
    return {
        name: np.ascontiguousarray(rows[..., index])
        for index, name in enumerate(names)
        if name in known
    }


def _load_pair(path: Path) -> dict[str, F32]:
    lobes_path, shape_path = _pair(path)
    if not lobes_path.is_file():
        if path.is_file():
            raise MapError(
                f"{path}: this Blender has no OpenImageIO and cannot read named channels; "
                f"allowed is a pair {lobes_path.name}, {shape_path.name}"
            )
        raise FileNotFoundError(f"{lobes_path}: no such file")
    read = []
    for file in (lobes_path, shape_path):
        if not file.is_file():
            read.append(None)
            continue
        image = bpy.data.images.load(str(file), check_existing=False)
        try:
            image.colorspace_settings.name = "Non-Color"
            image.alpha_mode = "CHANNEL_PACKED"
            width, height = image.size
            if image.channels != 4 or not width * height:
                raise MapError(f"{file}: {image.channels} channels; 4 are needed (RGBA)")
            pixels = np.empty(width * height * 4, np.float32)
            image.pixels.foreach_get(pixels)
            read.append(pixels.reshape(height, width, 4))
        finally:
            bpy.data.images.remove(image)
    return map_channels.from_images(read[0], read[1])
