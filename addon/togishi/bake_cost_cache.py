"""The bake's cost per light, kept with the material so that panels only read it."""

from __future__ import annotations

import json

import bpy

from . import properties
from .core import bake_cost

KEY = "togishi_bake_cost"


def store(material: bpy.types.Material) -> None:
    """Compute the ΔE00 under every built-in light (some 5 ms) and keep it. Raises InputError."""
    metal, spectrum = properties.metal_spec(material), material.togishi.node_spectrum
    material[KEY] = json.dumps(
        {"for": [metal, spectrum], "costs": bake_cost.costs(metal, spectrum)}
    )


def read(material: bpy.types.Material) -> dict[str, float] | None:
    """The stored figures; None where there are none or they are for other settings."""
    text = material.get(KEY)
    if not text:
        return None
    stored = json.loads(text)
    if stored["for"] != [properties.metal_spec(material), material.togishi.node_spectrum]:
        return None
    costs: dict[str, float] = stored["costs"]
    return costs
