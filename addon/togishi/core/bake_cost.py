"""What it costs to bake a material's colour for one light and use it under another."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from . import native

# Below this share of the light's own component a ratio of two says nothing; the luminance's ratio stands in.
_MIN_COMPONENT = 1e-3


@lru_cache(maxsize=64)
def worst_delta_e00(metal: str, baked_for: str, under: str, observer: str = "cie1931_2") -> float:
    """Largest CIEDE2000 over all angles between the exact colour under a light and what a renderer gets
    that multiplies the reflectance baked for `baked_for` with the light's RGB colour. Lab under the D65
    white, a perfect mirror scaled to the light's luminance 1. Raises InputError for unknown names."""
    core = native.core()
    size = 64
    exact = np.asarray(core.fresnel_table(metal, under, observer, "xyz", size), np.float64)
    baked = np.asarray(core.fresnel_table(metal, baked_for, observer, "xyz", size), np.float64)
    own = np.asarray(core.light_rgb(baked_for, observer, "xyz"), np.float64)
    other = np.asarray(core.light_rgb(under, observer, "xyz"), np.float64)
    usable = own > _MIN_COMPONENT
    ratio = np.where(usable, baked / np.where(usable, own, 1.0), baked[:, 1:2] / own[1])
    white = np.asarray(core.light_rgb("D65", observer, "xyz"), np.float64)
    return float(np.max(core.delta_e00(exact, np.ascontiguousarray(ratio * other), white)))


def costs(metal: str, baked_for: str) -> dict[str, float]:
    """worst_delta_e00 under every built-in light, by its name."""
    return {
        light["name"]: worst_delta_e00(metal, baked_for, light["name"])
        for light in native.core().lights()
    }
