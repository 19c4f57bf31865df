"""What differs between Blender versions, in one place. The rest of the add-on asks here."""

from __future__ import annotations

import bpy

VERSION: tuple[int, int, int] = bpy.app.version


def light_temperature_k(light: bpy.types.Light) -> float | None:
    """The light's own colour temperature in K where the version has it (4.5) and it is in use."""
    if getattr(light, "use_temperature", False):
        return float(light.temperature)
    return None


def light_exposure_stops(light: bpy.types.Light) -> float:
    """The light's own exposure in stops; 0 where the version does not have it (before 4.5)."""
    return float(getattr(light, "exposure", 0.0))


def eevee_engine() -> str:
    """EEVEE's identifier: BLENDER_EEVEE_NEXT in 4.2 to 4.5, BLENDER_EEVEE from 5.0."""
    return "BLENDER_EEVEE" if VERSION >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"
