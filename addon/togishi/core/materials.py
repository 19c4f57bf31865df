"""A blade material in the schema of togishi_core.default_material() as the renderer's data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import native
from .scene_data import BladeMaterial, MapData, NormalMapData, PlainMaterial, SteelMaterial

# What a part of a mesh looks like where no map says it: part id -> part of the material. The boshi is
# the hamon on the kissaki.
_LOBE_OF_PART = ("ji", "ji", "shinogi_ji", "ha", "mune", "kissaki", "ha", "ji")
_ROUGH = frozenset({"ha", "hadori"})


def encode_lobe(part: Mapping[str, Any]) -> tuple[float, float, float]:
    """(ln_mu_deg, e1, e2) of a part's half widths and azimuth in degrees."""
    encoded = native.core().encode_lobe(
        np.asarray(part["mu_t_deg"], np.float64),
        np.asarray(part["mu_b_deg"], np.float64),
        np.asarray(part.get("rho_deg", 0.0), np.float64),
    )
    ln_mu, e1, e2 = np.asarray(encoded, np.float64).reshape(3).tolist()
    return ln_mu, e1, e2


def _weight(material: Mapping[str, Any], name: str) -> float:
    if material["weights"] != "measured":
        return -1.0
    return float(material["parts"][name]["beta" if name in _ROUGH else "chi"])


def blade_material(
    material: Mapping[str, Any],
    maps: MapData | None = None,
    normal_map: NormalMapData | None = None,
) -> BladeMaterial:
    """material: the dict; maps, normal_map: its atlases, or None where it has no images."""
    parts = material["parts"]
    lobes = {name: encode_lobe(part) for name, part in parts.items()}
    steel = SteelMaterial(
        metal=material["metal"],
        part_lobes=tuple(lobes[name] for name in _LOBE_OF_PART),
        part_weights=tuple(_weight(material, name) for name in _LOBE_OF_PART),
        part_rough=tuple(name in _ROUGH for name in _LOBE_OF_PART),
        ha=(*lobes["ha"], _weight(material, "ha")),
        hadori=(*lobes["hadori"], _weight(material, "hadori")),
        maps=maps,
        normal_map=normal_map,
    )
    nakago = parts["nakago"]
    red, green, blue = (float(value) for value in nakago["albedo_rgb"])
    return BladeMaterial(
        steel=steel,
        nakago=PlainMaterial(
            albedo=(red, green, blue), ior=float(nakago["ior"]), gloss_ln_mu_deg=lobes["nakago"][0]
        ),
    )


def gloss_ln_mu_deg(roughness: float) -> float:
    """The lobe of Blender's roughness: alpha = roughness^2 of Beckmann's distribution, whose half width
    is atan(alpha sqrt(ln 2)). Not under 0.5 degrees: a mirror that shows only lamps shows nothing."""
    alpha = max(roughness, 0.0) ** 2
    return math.log(max(math.degrees(math.atan(alpha * math.sqrt(math.log(2.0)))), 0.5))
