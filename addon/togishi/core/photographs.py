"""Photographs for the capture, read and written by an OpenImageIO module that the caller has."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import atomic

F32 = NDArray[np.float32]
LIGHTS_SUFFIX = ".lp"


def is_light_file(path: Path) -> bool:
    return path.suffix.lower() == LIGHTS_SUFFIX


def first_photograph(path: Path) -> Path | None:
    """The first photograph that a set-up's text names, whether its camera is known yet or not."""
    tables = tomllib.loads(path.read_text(encoding="utf-8-sig")).get("photograph", [])
    names = [str(table["file"]) for table in tables if table.get("file")]
    return path.parent / names[0] if names else None


def landmark_tables(landmarks: Sequence[Mapping[str, Any]]) -> str:
    """Landmarks as a set-up's text has them, to be put at its end."""
    return "".join(
        f"\n[[landmark]]\nname = {json.dumps(str(one['name']))}\n"
        f"point_mm = {[float(v) for v in one['point_mm']]}\n"
        f"pixel = {[float(v) for v in one['pixel']]}\n"
        for one in landmarks
    )


def _open(oiio: ModuleType, path: str) -> Any:
    if not Path(path).is_file():
        raise FileNotFoundError(f"{path}: no such file")
    source = oiio.ImageInput.open(path)
    if source is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    return source


def _step(spec: Any) -> float:
    """One step of an integer format, full scale 1; 0 for floats."""
    if str(spec.format) in ("half", "float", "double"):
        return 0.0
    bits = spec.getattribute("oiio:BitsPerSample") or 8 * spec.format.size()
    return float(1.0 / (2.0**bits - 1.0))


def _pixels(source: Any, path: str) -> F32:
    """(H, W, C) of an open file."""
    spec = source.spec()
    pixels = source.read_image("float")
    if pixels is None or source.has_error:
        raise OSError(f"{path}: {source.geterror()}")
    return np.asarray(pixels, np.float32).reshape(spec.height, spec.width, spec.nchannels)


def read_picture(oiio: ModuleType, path: str) -> tuple[F32, bool]:
    """((H, W, C), whole numbers), as togishi_core.capture_diffuse asks for it."""
    source = _open(oiio, path)
    try:
        return _pixels(source, path), _step(source.spec()) > 0.0
    finally:
        source.close()


class Photographs:
    """Pictures of one size, rows at a time, as togishi_core.capture_lights asks for them."""

    def __init__(self, oiio: ModuleType, paths: Sequence[str]) -> None:
        self._paths = list(paths)
        self._sources = [_open(oiio, path) for path in self._paths]
        self._locks = [Lock() for _ in self._paths]
        specs = [source.spec() for source in self._sources]
        self.width, self.height = int(specs[0].width), int(specs[0].height)
        for path, spec in zip(self._paths, specs, strict=True):
            if (spec.width, spec.height) != (self.width, self.height):
                raise OSError(
                    f"{path}: {spec.width} x {spec.height} pixels; the first photograph has "
                    f"{self.width} x {self.height}"
                )
        self.step = max(_step(spec) for spec in specs)
        stats = [Path(path).stat() for path in self._paths]
        self.fingerprint = "\n".join(
            f"{path} {stat.st_size} {stat.st_mtime_ns}"
            for path, stat in zip(self._paths, stats, strict=True)
        )

    def read(self, picture: int, begin: int, end: int) -> F32:
        source, path = self._sources[picture], self._paths[picture]
        with self._locks[picture]:
            spec = source.spec()
            first, last = begin, end
            if spec.tile_height:
                first = begin // spec.tile_height * spec.tile_height
                last = min(self.height, -(-end // spec.tile_height) * spec.tile_height)
                pixels = source.read_tiles(
                    spec.x,
                    spec.x + spec.width,
                    spec.y + first,
                    spec.y + last,
                    0,
                    1,
                    0,
                    spec.nchannels,
                    "float",
                )
            else:
                pixels = source.read_scanlines(
                    spec.y + first, spec.y + last, 0, 0, spec.nchannels, "float"
                )
            if pixels is None or source.has_error:
                raise OSError(f"{path}: rows {begin} to {end - 1}: {source.geterror()}")
        shape = (last - first, self.width, spec.nchannels)
        return np.asarray(pixels, np.float32).reshape(shape)[begin - first : end - first]

    def close(self) -> None:
        for source in self._sources:
            source.close()


def write_bands(
    oiio: ModuleType, path: Path, names: Sequence[str], size: tuple[int, int], bands: Iterable[F32]
) -> None:
    """Bands of rows (N, W, C), the top one first, as one OpenEXR file of (H, W) = size with named channels: whole or
    not at all, and no more than two bands in memory."""
    height, width = size
    spec = oiio.ImageSpec(width, height, len(names), "float")
    spec.channelnames = tuple(names)
    spec.attribute("compression", "zip")
    spec.attribute("oiio:ColorSpace", "Raw")
    with atomic.replacing(path) as temporary:
        output = oiio.ImageOutput.create(str(temporary))
        good = output is not None and output.open(str(temporary), spec)
        begin = 0
        for band in bands:
            end = begin + len(band)
            rows = np.ascontiguousarray(band, np.float32)
            good = good and output.write_scanlines(begin, end, 0, rows)
            begin = end
        if not (good and output.close()):
            raise OSError(f"{path}: {oiio.geterror() if output is None else output.geterror()}")


def write_planes(oiio: ModuleType, path: Path, names: Sequence[str], pixels: F32) -> None:
    """(H, W, C), the top row first, as OpenEXR with named channels: whole or not at all."""
    height, width = pixels.shape[:2]
    write_bands(oiio, path, names, (height, width), [pixels])


def read_plane(oiio: ModuleType, path: Path, name: str) -> F32:
    """(H, W) of one channel."""
    planes = read_planes(oiio, path)
    if name not in planes:
        raise OSError(f"{path}: channel {name!r} is missing; the file has {', '.join(planes)}")
    return planes[name]


def read_planes(oiio: ModuleType, path: Path) -> dict[str, F32]:
    """(H, W) of every channel by its name, the top row first."""
    source = _open(oiio, str(path))
    try:
        pixels = _pixels(source, str(path))
        names = source.spec().channelnames
        return {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate(names)}
    finally:
        source.close()
