"""Blades to start from, as differences from the core's defaults of a zukuri. Lengths in mm.

The defaults themselves (a katana of 736 mm) are the core's. The other rows are ordinary proportions of
their kind (Nagayama, The Connoisseur's Book of Japanese Swords, 1997, on lengths by class).
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class KatanaPreset:
    identifier: str
    label: str
    description: str
    zukuri: str
    changes: dict[str, float] = field(default_factory=dict)


PRESETS = (
    KatanaPreset("KATANA", "Katana", "Shinogi-zukuri, nagasa 736 mm", "shinogi"),
    KatanaPreset("KATANA_SHOBU", "Katana, shobu", "Shobu-zukuri: no yokote", "shobu"),
    KatanaPreset(
        "O_KISSAKI",
        "Katana, o-kissaki",
        "Nanbokucho style: wide, with a long point",
        "shinogi",
        {"kissaki_mm": 66.0, "sakihaba_mm": 25.0, "sori_mm": 20.0},
    ),
    KatanaPreset(
        "WAKIZASHI",
        "Wakizashi",
        "Shinogi-zukuri, nagasa 385 mm",
        "shinogi",
        {
            "nagasa_mm": 385.0,
            "sori_mm": 9.0,
            "motohaba_mm": 28.0,
            "sakihaba_mm": 19.5,
            "motokasane_mm": 6.2,
            "sakikasane_mm": 4.2,
            "kissaki_mm": 29.0,
            "nakago_mm": 130.0,
            "mekugi_ana_from_machi_mm": 50.0,
        },
    ),
    KatanaPreset(
        "TANTO",
        "Tanto",
        "Hira-zukuri, nagasa 255 mm",
        "hira",
        {
            "nagasa_mm": 255.0,
            "sori_mm": 1.5,
            "motohaba_mm": 24.0,
            "sakihaba_mm": 17.0,
            "motokasane_mm": 6.0,
            "sakikasane_mm": 4.2,
            "nakago_mm": 95.0,
            "nakago_sakihaba_mm": 12.0,
            "mekugi_ana_from_machi_mm": 35.0,
        },
    ),
)


def preset(identifier: str) -> KatanaPreset:
    return next(row for row in PRESETS if row.identifier == identifier)
