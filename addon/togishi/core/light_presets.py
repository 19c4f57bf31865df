"""Sets of lights around a blade, in the blade's own measures.

A polished ji mirrors: it is bright only where a lamp stands in the mirror direction of the view, while the ha
still glows some ten degrees off it. So a lamp is placed by its angle off that direction: 0 makes the ji
flash, 8 to 14 degrees leave the ji black and draw the hamon, as in a museum photograph.

Lengths are in half blade lengths; `along` counts from the blade's middle to its tip. Powers hold for a blade of
1 m and grow with the square of its length, so that every blade gets the same irradiance.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Lamp:
    name: str
    kind: str  # POINT, SPOT, SUN or AREA
    along: (
        float  # in half lengths, from the middle towards the tip; of a sun: slope of its direction
    )
    off_mirror_deg: float  # off the mirror direction of the view in the ji, away from the viewer
    distance: float  # in half lengths
    power_w: float  # W for a blade of 1 m; of a sun W/m2
    spectrum_kind: str  # as in spectrum_spec, or a built-in name
    temperature_k: float = 0.0
    cone_deg: float = 60.0
    blend: float = 0.6
    radius: float = 0.0  # in half lengths; above 0 the lamp is lit by its size, which costs more
    size: tuple[float, float] = (0.0, 0.0)  # AREA: along the blade and across it, in half lengths
    to_along: float | None = None  # the lamp moves to there over the scene's frames


@dataclass(frozen=True)
class LightPreset:
    identifier: str
    label: str
    description: str
    lamps: tuple[Lamp, ...]
    world_grey: float  # radiance of the surroundings


def _row(
    count: int,
    off_mirror_deg: float,
    distance: float,
    power_w: float,
    spectrum_kind: str,
    cone_deg: float = 70.0,
) -> tuple[Lamp, ...]:
    """A row of spots along the blade: the soft box of a museum case as far as points can be one."""
    return tuple(
        Lamp(
            f"Spot {index + 1}",
            "SPOT",
            -0.9 + 1.8 * index / (count - 1),
            off_mirror_deg,
            distance,
            power_w / count,
            spectrum_kind,
            cone_deg=cone_deg,
        )
        for index in range(count)
    )


PRESETS = (
    LightPreset(
        "MUSEUM_SPOT",
        "Museum spots",
        "A row of daylight spots: black ji, bright hamon, one flash in the ji",
        (
            *_row(7, 11.0, 1.5, 9.0, "D50"),
            Lamp("Flash", "SPOT", -0.45, 1.0, 1.7, 0.25, "D50", cone_deg=30.0, blend=1.0),
        ),
        0.004,
    ),
    LightPreset(
        "SOFT_BOX",
        "Overhead soft box",
        "One long daylight soft box above the blade, black surroundings: its soft edge runs along the hamon",
        (Lamp("Soft box", "AREA", 0.0, 13.0, 1.5, 1.6, "D50", size=(2.4, 0.4)),),
        0.002,
    ),
    LightPreset(
        "RAKING_STRIP",
        "Raking strip",
        "A narrow strip light far off the mirror direction: the hamon alone, against a black ji",
        (Lamp("Strip", "AREA", 0.0, 16.0, 1.3, 4.5, "D50", size=(2.6, 0.06)),),
        0.002,
    ),
    LightPreset(
        "WINDOW",
        "Window light",
        "A north window towards the tip and a dim room: cool, falling off to the nakago",
        (Lamp("Window", "AREA", 0.5, 15.0, 3.0, 6.0, "daylight", 7500.0, size=(1.2, 0.9)),),
        0.006,
    ),
    LightPreset(
        "SUN",
        "Sun",
        "Afternoon sun and a bluish sky",
        (
            Lamp("Sun", "SUN", 0.05, 6.0, 1.0, 0.25, "daylight", 5500.0),
            Lamp("Sky", "SUN", -0.3, 14.0, 1.0, 0.12, "daylight", 9500.0),
        ),
        0.06,
    ),
    LightPreset(
        "TUNGSTEN_CASE",
        "Tungsten case lamps",
        "Small filament lamps along the top of a showcase",
        tuple(
            Lamp(f"Filament {i + 1}", "POINT", x, 8.0, 1.3, 1.6, "blackbody", 2856.0)
            for i, x in enumerate((-0.85, -0.3, 0.3, 0.85))
        ),
        0.003,
    ),
    LightPreset(
        "INSPECTION",
        "Inspection lamp, moved",
        "A bare bulb moved along the blade over the scene's frames, as for drawing an oshigata",
        (
            Lamp(
                "Bulb",
                "POINT",
                -0.75,
                7.5,
                1.1,
                6.0,
                "blackbody",
                2856.0,
                radius=0.04,
                to_along=0.75,
            ),
        ),
        0.001,
    ),
    LightPreset(
        "SODIUM_STREET",
        "Sodium street lamp",
        "Two low-pressure sodium lamps: one yellow line of the spectrum",
        (
            Lamp("Sodium lamp", "POINT", -0.35, 7.0, 2.6, 5.0, "LPS"),
            Lamp("Second lamp", "POINT", 0.8, 10.0, 3.0, 5.0, "LPS"),
        ),
        0.002,
    ),
)


def preset(identifier: str) -> LightPreset:
    return next(row for row in PRESETS if row.identifier == identifier)
