"""What the engine asks of the graphics card's driver."""

from __future__ import annotations

import re

# The shared formulas and the uniform blocks are written for it; Blender itself asks for it from 4.2 on.
OPENGL_NEEDED = (4, 3)


def problem(backend: str, version: str) -> str:
    """A sentence that says why the engine cannot draw and what to do, or "".

    backend, version: as `gpu.platform.backend_type_get()` and `version_get()` give them, such as "OPENGL" and
    "4.1 (Core Profile) Mesa 22.3.6". A version that cannot be read is taken for good."""
    found = re.match(r"\s*(\d+)\.(\d+)", version)
    if backend != "OPENGL" or found is None:
        return ""
    if (int(found[1]), int(found[2])) >= OPENGL_NEEDED:
        return ""
    needed = ".".join(map(str, OPENGL_NEEDED))
    return (
        f"Togishi's engine needs OpenGL {needed}, and this driver offers {found[1]}.{found[2]}. "
        "Update the graphics driver, then restart Blender; Cycles and EEVEE can render the blades meanwhile."
    )
