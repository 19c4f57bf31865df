"""Which lobe a part of the blade has where there is no map, and how long lobes get."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

# By part id (togishi_core.PART_NAMES): other, ji, shinogi_ji, ha, mune, kissaki, boshi, nakago.
# Ha and boshi carry the ha's lobe by w = 1; their smooth share is that of the ground they lie in.
LOBE_OF_PART = ("ji", "ji", "shinogi_ji", "ji", "mune", "kissaki", "kissaki", "nakago")
SMOOTH_PARTS = ("ji", "shinogi_ji", "mune", "kissaki")


def part_aspects(
    material: Mapping[str, Any], map_stretch: tuple[float, float] | None = None
) -> dict[str, float]:
    """Largest mu_t/mu_b of the smooth lobe ("ji", all smooth parts), "ha" and "hadori".

    map_stretch: largest ln sqrt(mu_t/mu_b) of ji and ha in the shape map, which then counts for them."""

    def aspect(name: str) -> float:
        part = material["parts"][name]
        return float(part["mu_t_deg"]) / float(part["mu_b_deg"])

    if map_stretch is None:
        ji, ha = max(aspect(name) for name in SMOOTH_PARTS), aspect("ha")
    else:
        ji, ha = (math.exp(min(2.0 * r, 50.0)) for r in map_stretch)
    return {"ji": ji, "ha": ha, "hadori": aspect("hadori")}
