"""The one string that names a light spectrum everywhere (docs/architecture.md, "Conventions")."""

from __future__ import annotations

from dataclasses import dataclass

AUTOMATIC = "automatic"
DEFAULT = "D65"

# Kinds that need a number or a file. Every other kind is the name of a built-in spectrum.
BLACKBODY = "blackbody"
DAYLIGHT = "daylight"
LINE = "line"
CSV = "csv"


@dataclass(frozen=True)
class SpectrumSettings:
    """What a light's settings say about its spectrum. Temperatures in K, wavelength in nm."""

    kind: str = AUTOMATIC
    blackbody_k: float = 2856.0
    daylight_k: float = 6504.0
    line_nm: float = 589.3
    csv_path: str = ""


def number(value: float) -> str:
    """Shortest text that gives the same number to six digits: single-precision settings of 589.3
    come back as 589.3, so that one light has one spelling (it is a cache key)."""
    return f"{value:.6g}"


def spec(settings: SpectrumSettings, own_temperature_k: float | None = None) -> str:
    """Spec string such as "D65", "blackbody:3200", "line:589.3" or "csv:/path.csv".

    own_temperature_k: Blender's own light temperature where the version has it and it is in use;
    it is what "automatic" takes, and D65 without it. A file that was not chosen yet gives D65.
    """
    kind = settings.kind
    if kind == AUTOMATIC:
        return DEFAULT if own_temperature_k is None else f"{BLACKBODY}:{number(own_temperature_k)}"
    if kind == BLACKBODY:
        return f"{BLACKBODY}:{number(settings.blackbody_k)}"
    if kind == DAYLIGHT:
        return f"{DAYLIGHT}:{number(settings.daylight_k)}"
    if kind == LINE:
        return f"{LINE}:{number(settings.line_nm)}"
    if kind == CSV:
        return f"{CSV}:{settings.csv_path}" if settings.csv_path else DEFAULT
    return kind
