"""Whether this machine's graphics card can run the engine."""

from __future__ import annotations

from functools import cache

from .core import graphics


@cache
def problem() -> str:
    """A sentence that says why the engine cannot draw and what to do, or "". To be called only while there is a GPU
    context (in drawing, in `render`): without one Blender may crash when it is asked."""
    import gpu

    return graphics.problem(gpu.platform.backend_type_get(), gpu.platform.version_get())
