"""What a fit to a goniometer's scans found, as people read it. Without Blender."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

# Parts of a material that a fit of a model can go into, the fitted one first; the model's constant.
TARGETS = {
    "ji": (("ji", "shinogi_ji", "mune", "kissaki"), "chi"),
    "hamon": (("ha", "hadori"), "beta"),
}

LABELS = {
    "chi": "χ",
    "beta": "β",
    "mu_t_deg": "μ wide",
    "mu_b_deg": "μ narrow",
    "rho_deg": "ρ",
    "pedestal": "Stray light",
    "haze_share": "Haze, height",
    "haze_width": "Haze, width",
    "tilt_t_deg": "Tilt along",
    "tilt_b_deg": "Tilt across",
    "receive_offset_deg": "Receive zero",
    "out_of_plane_deg": "Out of plane",
}
UNITS = {"deg": "°", "1": "", "relative": " (relative)"}


@dataclass(frozen=True)
class TableRow:
    label: str
    value: str  # "7.998 ± 0.004 °"; "not determined" where the data do not say
    determined: bool
    reason: str  # a sentence, or ""


def measured_text(value: float, sigma: float) -> str:
    """A value with as many decimals as two digits of its standard deviation; sigma 0: it was not fitted."""
    if not sigma > 0 or not math.isfinite(sigma):
        return f"{value:.5g}"
    places = 1 - math.floor(math.log10(sigma))
    if places < 0 or places > 12 or abs(value) >= 1e9:
        return f"{value:.4g} ± {sigma:.2g}"
    return f"{value:.{places}f} ± {sigma:.{places}f}"


def table_row(parameter: Mapping[str, Any]) -> TableRow:
    """One entry of a record's "parameter"."""
    unit = str(parameter["unit"])
    shown = UNITS.get(unit, f" {unit}")
    determined = bool(parameter["determined"])
    value = measured_text(float(parameter["value"]), float(parameter["sigma"])) + shown
    name, _, channel = str(parameter["name"]).partition("pedestal_")
    label = f"{LABELS['pedestal']}, {channel}" if channel else LABELS.get(name, name)
    return TableRow(
        label,
        value if determined else "not determined",
        determined,
        str(parameter["text"]),
    )


@dataclass(frozen=True)
class FitTable:
    model: str  # "ji" or "hamon"
    metal: str
    calibration: str
    rows: tuple[TableRow, ...]
    summary: tuple[str, ...]  # sentences
    notes: tuple[str, ...]


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


@lru_cache(maxsize=32)
def fit_table(record_json: str) -> FitTable:
    """The record of a fit (docs/measurement.md) in the JSON text that the .blend keeps. Panels ask at every redraw."""
    record = json.loads(record_json)
    left_out = [
        _counted(record["outliers"], "outlier") if record["outliers"] else "",
        f"{record['clipped']} clipped" if record["clipped"] else "",
    ]
    readings = _counted(record["readings"], "reading")
    if any(left_out):
        readings += f"; left out: {', '.join(text for text in left_out if text)}"
    noise = "stated in the file"
    if record["noise_estimated"]:
        noise = (
            f"{100 * record['noise_relative']:.2g} % of the signal, "
            f"{100 * record['noise_floor']:.2g} % of the peak"
        )
    return FitTable(
        model=record["model"],
        metal=record["metal"],
        calibration=record["calibration"],
        rows=tuple(table_row(parameter) for parameter in record["parameter"]),
        summary=(
            f"{readings}; reduced χ² {record['chi2_reduced']:.2f}",
            f"Noise: {noise}",
            f"Metal: {record['metal']}; calibration: {record['calibration'].replace('_', ' ')}",
        ),
        notes=tuple(record["notes"]),
    )


def lobe_of(record: Mapping[str, Any]) -> dict[str, float]:
    """mu_t_deg, mu_b_deg, rho_deg and the constant ("weight", in 1/sr or relative) of a record."""
    values = {entry["name"]: float(entry["value"]) for entry in record["parameter"]}
    constant = TARGETS[record["model"]][1]
    return {
        "mu_t_deg": values["mu_t_deg"],
        "mu_b_deg": values.get("mu_b_deg", values["mu_t_deg"]),
        "rho_deg": values.get("rho_deg", 0.0),
        "weight": values[constant],
    }


def undetermined(record: Mapping[str, Any]) -> list[str]:
    """Sentences about those constants of the lobe that the data do not determine."""
    wanted = {"mu_t_deg", "mu_b_deg", "rho_deg", TARGETS[record["model"]][1]}
    return [
        f"{LABELS[entry['name']]}: {entry['text'] or entry['reason']}"
        for entry in record["parameter"]
        if entry["name"] in wanted and not entry["determined"] and entry["reason"] != "isotropic"
    ]


def still_holds(record: Mapping[str, Any], part: Mapping[str, Any]) -> bool:
    """Whether a part of a material (as togishi_core.default_material has it) is what was fitted. What was edited
    afterwards must not carry a measurement's name. Blender keeps single precision."""
    lobe = lobe_of(record)
    return all(
        math.isclose(lobe[name], float(part[name]), rel_tol=2e-6, abs_tol=1e-4)
        for name in ("mu_t_deg", "mu_b_deg", "rho_deg")
    )
