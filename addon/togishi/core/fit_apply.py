"""A fit of a goniometer's scans put into a part of a blade material."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import native
from .fit_table import TARGETS, lobe_of, still_holds

WEIGHTS = {part: constant for parts, constant in TARGETS.values() for part in parts}
"""The measured constant of each part that reflects by the model."""


def normalised_weight(part: Mapping[str, Any]) -> float:
    """What a lobe without a measured constant reflects with, by the shared formulas."""
    formulas = native.core().formulas
    axes = np.radians([[part["mu_t_deg"], part["mu_b_deg"], part["rho_deg"]]])
    form = formulas("lobe_form", "f64", formulas("lobe_from_mu", "f64", axes))
    return float(formulas("lobe_normalised_weight", "f64", form)[0, 0])


def with_fit(
    material: Mapping[str, Any], record: Mapping[str, Any], part: str, file: str
) -> dict[str, Any]:
    """The material (as togishi_core.default_material has it) with the fitted lobe in one part. An absolute weight
    makes the material's weights measured; parts that then lack a constant get that of normalised weights. A relative
    weight stays in the record. ji and ha keep the record too.

    Raises ValueError where the part does not follow the model that was fitted."""
    parts, constant = TARGETS[record["model"]]
    if part not in parts:
        raise ValueError(
            f"a fit of {record['model']} cannot go into {part!r}: its constant is another one; allowed are {', '.join(parts)}"
        )
    result = copy.deepcopy(dict(material))
    lobe = lobe_of(record)
    absolute = record["calibration"] == "absolute"
    if absolute and result["weights"] != "measured":
        result["weights"] = "measured"
        for name, key in WEIGHTS.items():
            result["parts"][name][key] = normalised_weight(result["parts"][name])
    target = result["parts"][part]
    target.update({name: lobe[name] for name in ("mu_t_deg", "mu_b_deg", "rho_deg")})
    if result["weights"] == "measured":
        target[constant] = lobe["weight"] if absolute else normalised_weight(lobe)
    result["metal"] = record["metal"]
    said = f"{part} by goniometer fit of {file}"
    before = str(material.get("source", ""))
    result["source"] = said if not before else f"{said}; before: {before}"
    if part == parts[0]:
        kept = {name: value for name, value in record.items() if name != "part"}
        fits = {**result.get("fit", {}), part: kept}
        result["fit"] = {name: fits[name] for name in ("ji", "ha") if name in fits}
    return result


def records_that_hold(
    records: Mapping[str, Mapping[str, Any]], parts: Mapping[str, Mapping[str, Any]]
) -> dict[str, Mapping[str, Any]]:
    """The records whose part is still what was measured; an edit makes it something else."""
    return {name: record for name, record in records.items() if still_holds(record, parts[name])}
