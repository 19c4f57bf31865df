"""Timing of GPU work: what the measuring commands for viewport and scale share."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender"))

import bpy  # the wheel: only then can gpu and the add-on's engine be imported
import gpu
from gpu_context import ensure_gpu_context

BYTES_PER_CHANNEL = {"8": 1, "16": 2, "16F": 2, "32": 4, "32F": 4}


def start() -> dict[str, str]:
    """A GPU context; what it runs on."""
    ensure_gpu_context()
    return {
        "GPU": f"{gpu.platform.renderer_get()}, {gpu.platform.version_get()}",
        "Blender": bpy.app.version_string,
    }


def leave() -> NoReturn:
    """Ends the process without tidying up: Blender frees its GPU context before Python frees the GPU objects that are
    left, and that order can crash an otherwise good run."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def finish(framebuffer: Any) -> None:
    """Waits until everything that was drawn into the framebuffer is there: reads one pixel of it."""
    with framebuffer.bind():
        framebuffer.read_color(0, 0, 1, 1, 4, 0, "FLOAT")


def in_turns(
    draws: Mapping[str, Callable[[int], None]],
    frames: int,
    warm_up: int = 2,
    progress: Callable[[str], None] | None = None,
) -> dict[str, list[float]]:
    """Seconds per frame of each, measured in turns (A B C, A B C, …) so that a disturbance hits all of them. Each
    draw(frame) returns when its picture is finished."""
    times: dict[str, list[float]] = {name: [] for name in draws}
    for frame in range(-warm_up, frames):
        for name, draw in draws.items():
            started = time.perf_counter()
            draw(frame)
            took = time.perf_counter() - started
            if frame >= 0:
                times[name].append(took)
            if progress is not None and frame < 0:
                progress(f"{name}: warm-up {took:.2f} s")
    return times


# --- memory ---------------------------------------------------------------------------------------


def texture_bytes(size: Any, texture_format: str, layers: int = 0) -> int:
    """Bytes that a texture's texels take: DEPTH_COMPONENT32F, R8, RG16F, RGBA32F …"""
    sides = (size,) if isinstance(size, int) else tuple(size)
    count = max(layers, 1)
    for side in sides:
        count *= side
    if texture_format.startswith("DEPTH"):
        return count * 4
    channels = len(texture_format) - len(texture_format.lstrip("RGBA"))
    kind = texture_format[channels:].removesuffix("UI").removesuffix("I")
    return count * channels * BYTES_PER_CHANNEL[kind]


def mesh_bytes(mesh: Any) -> int:
    """Vertices and indices of a mesh, which the renderer uploads as they are."""
    arrays = [mesh.position, mesh.normal_part, mesh.uv, mesh.tangent]
    arrays += [group.triangles for group in mesh.groups]
    return sum(array.nbytes for array in arrays if array is not None)


@contextmanager
def counted_allocations() -> Iterator[dict[str, int]]:
    """Bytes of textures and uniform blocks that the renderer asks for while this is entered. What it gives back is not
    taken off: enter it for one scene, drawn once."""
    from togishi.engine import programs, renderer

    asked = {"textures": 0, "uniforms": 0}
    originals: list[tuple[Any, str, Any]] = []

    def replace(name: str, kind: str, counted: Callable[..., int]) -> None:
        for module in (renderer, programs):
            original = getattr(module, name, None)
            if original is None:
                continue

            def make(*args: Any, _original: Any = original, **keywords: Any) -> Any:
                asked[kind] += counted(*args, **keywords)
                return _original(*args, **keywords)

            originals.append((module, name, original))
            setattr(module, name, make)

    def of_texture(size: Any, layers: int = 0, format: str = "RGBA8", **_: Any) -> int:
        return texture_bytes(size, format, layers)

    try:
        replace("GPUTexture", "textures", of_texture)
        replace("GPUUniformBuf", "uniforms", lambda data: data.nbytes)
        yield asked
    finally:
        for module, name, original in reversed(originals):
            setattr(module, name, original)
