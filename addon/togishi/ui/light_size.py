"""What the engine uses of a lamp's size, as a sentence."""

from __future__ import annotations

import math

import bpy

from ..engine.light_read import area_size


def size_sentence(light: bpy.types.Light) -> str:
    """Shape and size as the engine lights with them, before the object's scale."""
    if light.type == "AREA":
        x, y = area_size(light)
        shape = "an ellipse" if light.shape in {"DISK", "ELLIPSE"} else "a rectangle"
        return f"Lit as {shape} of {x:.3g} x {y:.3g} m"
    if light.type == "SUN":
        angle = math.degrees(light.angle)
        return f"Lit as a disk of {angle:.3g}°" if angle > 0.0 else "Lit as a point: its angle is 0"
    radius = light.shadow_soft_size
    return (
        f"Lit as a ball of {radius:.3g} m radius"
        if radius > 0.0
        else "Lit as a point: its radius is 0"
    )
