"""GPU programs from their descriptions (core/shader_source.py), and the small GPU objects around them."""

from __future__ import annotations

import gpu
import numpy as np
from gpu.types import Buffer, GPUShader, GPUShaderCreateInfo, GPUStageInterfaceInfo, GPUUniformBuf

from ..core.shader_source import ProgramSource


class ShaderError(RuntimeError):
    """A GPU program does not compile on this machine."""


def build(source: ProgramSource) -> GPUShader:
    """Compile. Raises ShaderError naming the program and its defines."""
    info = GPUShaderCreateInfo()
    for name, value in source.defines:
        info.define(name, value)
    if source.typedefs:
        info.typedef_source(source.typedefs)
    for slot, (kind, name) in enumerate(source.attributes):
        info.vertex_in(slot, kind, name)
    if source.varyings:
        stages = GPUStageInterfaceInfo(f"{source.name}_io")
        for interpolation, kind, name in source.varyings:
            getattr(stages, interpolation)(kind, name)
        info.vertex_out(stages)
    for slot, (kind, name) in enumerate(source.blocks):
        info.uniform_buf(slot, kind, name)
    for slot, (kind, name) in enumerate(source.samplers):
        info.sampler(slot, kind, name)
    for slot, (kind, name) in enumerate(source.outputs):
        if name:
            info.fragment_out(slot, kind, name)
    for kind, name in source.push_constants:
        info.push_constant(kind, name)
    info.vertex_source(source.vertex)
    info.fragment_source(source.fragment)
    try:
        return gpu.shader.create_from_info(info)
    except Exception as error:
        flags = " ".join(name for name, value in source.defines if not value)
        raise ShaderError(
            f"The GPU program {source.name} ({flags}) does not compile on "
            f"{gpu.platform.renderer_get()}, {gpu.platform.version_get()}: {error}"
        ) from error


class Block:
    """A uniform block that is uploaded only where its bytes changed."""

    def __init__(self) -> None:
        self._buffer: GPUUniformBuf | None = None
        self._content: np.ndarray | None = None
        self.tag: object = (
            None  # what the content was made from, for callers that can skip making it
        )

    def set(self, content: np.ndarray) -> int:
        """Bytes uploaded: 0 where nothing changed."""
        if self._content is not None and np.array_equal(self._content, content):
            return 0
        self._content = np.ascontiguousarray(content, np.float32)
        if self._buffer is None:
            self._buffer = GPUUniformBuf(self._content)
        else:
            self._buffer.update(self._content)
        return self._content.nbytes

    @property
    def made(self) -> bool:
        return self._buffer is not None

    @property
    def buffer(self) -> GPUUniformBuf:
        assert self._buffer is not None, "set() comes before use"
        return self._buffer


def float_buffer(values: np.ndarray) -> Buffer:
    """A gpu.types.Buffer of a float32 array."""
    flat = np.ascontiguousarray(values, np.float32).reshape(-1)
    return Buffer("FLOAT", flat.size, flat)
