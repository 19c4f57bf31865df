"""Planes of an OpenEXR file of scan lines, uncompressed or ZIP, as `togishi capture simulate` writes them.

Layout: openexr.com, "OpenEXR File Layout".
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from bench_rows import ResultsError

TYPES = {1: np.dtype("<f2"), 2: np.dtype("<f4")}
LINES = {0: 1, 2: 1, 3: 16}
"""Scan lines in a chunk, by the number of the compression: none, ZIPS, ZIP."""


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _channels(value: bytes) -> list[tuple[str, np.dtype]]:
    channels, at = [], 0
    while value[at]:
        name, at = _text(value, at)
        channels.append((name, TYPES[struct.unpack_from("<i", value, at)[0]]))
        at += 16
    return channels


def _unpacked(chunk: bytes) -> bytes:
    """ZIP: differences of neighbours, first and second half of the bytes in turn."""
    difference = np.frombuffer(zlib.decompress(chunk), np.uint8).astype(np.int64)
    values = (np.cumsum(difference) - 128 * np.arange(len(difference))) & 255
    out = np.empty(len(values), np.uint8)
    half = (len(values) + 1) // 2
    out[0::2], out[1::2] = values[:half], values[half:]
    return out.tobytes()


def read_planes(path: Path) -> dict[str, np.ndarray]:
    """(height, width) float32 of each channel, the top row first."""
    data = path.read_bytes()
    if data[:4] != b"v/1\x01" or data[5] & 0x1A:
        raise ResultsError(f"{path}: no OpenEXR file of scan lines")
    at, header = 8, {}
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        header[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    channels = _channels(header["channels"])
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = LINES[header["compression"][0]]
    planes = {name: np.empty((height, width), np.float32) for name, _ in channels}
    chunks = -(-height // lines)
    for offset in struct.unpack_from(f"<{chunks}q", data, at + 1):
        first, size = struct.unpack_from("<2i", data, offset)
        count = min(lines, y1 + 1 - first)
        raw = data[offset + 8 : offset + 8 + size]
        if size < count * width * sum(kind.itemsize for _, kind in channels):
            raw = _unpacked(raw)
        position = 0
        for row in range(first - y0, first - y0 + count):
            for name, kind in channels:
                planes[name][row] = np.frombuffer(raw, kind, width, position)
                position += width * kind.itemsize
    return planes
