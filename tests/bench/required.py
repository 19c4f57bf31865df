"""Which figures must be there, and what is wrong with those that are (required.toml)."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from bench_rows import OPERATORS, ResultsError, Row


@dataclass(frozen=True)
class RequiredRow:
    id: str
    op: str
    bound: float
    what: str


@dataclass(frozen=True)
class RequiredFamily:
    prefix: str
    at_least: int
    what: str


@dataclass(frozen=True)
class Required:
    rows: tuple[RequiredRow, ...]
    families: tuple[RequiredFamily, ...]

    def of_areas(self, areas: Iterable[str]) -> Required:
        """Only what these areas measure: an id begins with its area's name."""
        kept = tuple(f"{area}." for area in areas)
        return Required(
            tuple(row for row in self.rows if row.id.startswith(kept)),
            tuple(family for family in self.families if family.prefix.startswith(kept)),
        )


def read_required(path: Path) -> Required:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        rows = tuple(
            RequiredRow(row["id"], row["op"], float(row["bound"]), row["what"])
            for row in content["row"]
        )
        families = tuple(
            RequiredFamily(family["prefix"], int(family["at_least"]), family["what"])
            for family in content.get("family", [])
        )
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"{path}: {error!r}") from error
    for row in rows:
        if row.op not in OPERATORS:
            raise ResultsError(
                f"{path}, {row.id}: op {row.op!r}; allowed are {', '.join(OPERATORS)}"
            )
    return Required(rows, families)


def problems(rows: Iterable[Row], required: Required) -> list[str]:
    """Sentences; none where every figure is there, is a number, and keeps what is promised."""
    by_id = {row.id: row for row in rows}
    measured = {name.split(".")[0] for name in by_id}
    found = []
    unmeasured: dict[str, int] = {}
    for demand in required.rows:
        row = by_id.get(demand.id)
        area = demand.id.split(".")[0]
        if area not in measured:
            unmeasured[area] = unmeasured.get(area, 0) + 1
        elif row is None:
            found.append(f"{demand.id} is missing ({demand.what})")
        elif (row.op, row.bound) != (demand.op, demand.bound):
            held = "no bound" if row.bound is None else f"{row.op} {row.bound:g}"
            found.append(
                f"{demand.id} is held to {held}, but what is promised is {demand.op} {demand.bound:g}"
            )
    for family in required.families:
        members = sum(name.startswith(family.prefix) for name in by_id)
        area = family.prefix.split(".")[0]
        if members < family.at_least and area not in unmeasured:
            found.append(
                f"{family.prefix}* has {members} rows, at least {family.at_least} are wanted ({family.what})"
            )
    found += [
        f"nothing of the area {area} was measured, {count} rows are wanted: make results AREA={area}"
        for area, count in unmeasured.items()
    ]
    for row in by_id.values():
        if not math.isfinite(row.value):
            found.append(f"{row.id} is {row.value}: nothing was measured")
        elif not row.kept:
            found.append(
                f"{row.id} = {row.value:.4g}{row.unit and ' ' + row.unit} misses its bound {row.op} {row.bound:g}"
            )
    return found
