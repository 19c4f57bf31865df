"""The rows of a measurement: what a measuring command writes and `make results` reads.

A measuring command takes `--out PATH` and writes there

    {"rows": [{"id": "viewport.ratio_eevee", "value": 0.41, "unit": "", "bound": 0.5, "op": "<=",
               "spread": [0.40, 0.43], "how": "median of 24 interleaved frames, 1920x1080"}],
     "curves": {"lights": {"x_label": "lights", "y_label": "frame, ms", "x": [1, 2], "y": [9, 12],
                           "exponent": 0.4, "exponent_interval": [0.3, 0.5]}},
     "machine": {"gpu": "llvmpipe"}, "pictures": {"A blade": "<PNG in base64>"}}

`value` is what was measured, in `unit`; `bound` and `op` say what is promised (both null where nothing is);
`spread` is null, one number (half width) or [low, high], in `unit`; `how` says how it was measured. `curves`,
`machine` and `pictures` (by caption) are optional. Ids of a simplification come in pairs, accuracy.pareto.<what>.<error> and
accuracy.pareto.<what>.<time>, told apart by their unit (a unit of time makes the time).
"""

from __future__ import annotations

import argparse
import base64
import json
import math
import operator
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

OPERATORS = {"<=": operator.le, ">=": operator.ge}
TIME_UNITS_S = {"ns": 1e-9, "us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0}


class ResultsError(ValueError):
    """A file of rows that cannot be believed, with what is wrong in it."""


def bench_program(name: str) -> Path:
    """A measuring program of the release build, bench_<what>, or what TOGISHI_BENCH_<WHAT> names instead."""
    return _built(f"tests/bench/{name}", f"TOGISHI_{name.upper()}")


def togishi_command() -> Path:
    """The command line of the release build, or what TOGISHI_CLI names instead."""
    return _built("cpp_core/cli/togishi", "TOGISHI_CLI")


def _built(place: str, variable: str) -> Path:
    built = Path(__file__).resolve().parents[2] / "build" / "release" / place
    path = Path(os.environ.get(variable, built))
    if not path.is_file():
        raise ResultsError(
            f"{path} is missing: build it with cmake --preset release && cmake --build --preset release, "
            f"or name it in {variable}"
        )
    return path


@dataclass(frozen=True)
class Row:
    id: str
    value: float
    unit: str = ""
    bound: float | None = None
    op: str | None = None
    spread: float | tuple[float, float] | None = None
    how: str = ""

    @property
    def kept(self) -> bool:
        """True where nothing is promised. NaN keeps no bound."""
        return (
            self.bound is None
            or self.op is None
            or bool(OPERATORS[self.op](self.value, self.bound))
        )


@dataclass(frozen=True)
class Curve:
    x_label: str
    y_label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    exponent: float
    exponent_interval: tuple[float, float]


@dataclass
class Measurement:
    rows: list[Row] = field(default_factory=list)
    curves: dict[str, Curve] = field(default_factory=dict)
    machine: dict[str, str] = field(default_factory=dict)
    pictures: dict[str, str] = field(default_factory=dict)


# --- reading and writing --------------------------------------------------------------------------


def write_text(path: Path, text: str) -> None:
    """Whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_measurement(path: Path, measurement: Measurement) -> None:
    write_text(path, json.dumps(asdict(measurement), indent=1, ensure_ascii=False) + "\n")


def _number(where: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ResultsError(f"{where}: {value!r} is not a number")
    return float(value)


def _text(where: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ResultsError(f"{where}: {value!r} is not a text")
    return value


def _spread(where: str, value: Any) -> float | tuple[float, float] | None:
    if value is None:
        return None
    if isinstance(value, list):
        if len(value) != 2:
            raise ResultsError(f"{where}: {value!r} is not [low, high]")
        return (_number(where, value[0]), _number(where, value[1]))
    return _number(where, value)


def read_row(where: str, fields: Any) -> Row:
    if not isinstance(fields, dict):
        raise ResultsError(f"{where}: a row is an object, found {fields!r}")
    unknown = fields.keys() - Row.__dataclass_fields__.keys()
    if unknown:
        raise ResultsError(
            f"{where}: unknown field {sorted(unknown)[0]!r}; known are {', '.join(Row.__dataclass_fields__)}"
        )
    for name in ("id", "value"):
        if name not in fields:
            raise ResultsError(f"{where}: the field {name!r} is missing")
    where = f"{where}, row {fields['id']!r}"
    bound, op = fields.get("bound"), fields.get("op")
    if (bound is None) != (op is None):
        raise ResultsError(f"{where}: bound and op come together, found {bound!r} and {op!r}")
    if op is not None and op not in OPERATORS:
        raise ResultsError(f"{where}, field op: {op!r}; allowed are {', '.join(OPERATORS)}")
    return Row(
        id=_text(f"{where}, field id", fields["id"]),
        value=_number(f"{where}, field value", fields["value"]),
        unit=_text(f"{where}, field unit", fields.get("unit", "")),
        bound=None if bound is None else _number(f"{where}, field bound", bound),
        op=op,
        spread=_spread(f"{where}, field spread", fields.get("spread")),
        how=_text(f"{where}, field how", fields.get("how", "")),
    )


def _curve(where: str, fields: Any) -> Curve:
    try:
        x = tuple(_number(where, value) for value in fields["x"])
        y = tuple(_number(where, value) for value in fields["y"])
        low, high = (_number(where, value) for value in fields["exponent_interval"])
        curve = Curve(
            _text(where, fields["x_label"]),
            _text(where, fields["y_label"]),
            x,
            y,
            _number(where, fields["exponent"]),
            (low, high),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"{where}: {error}") from error
    if len(x) != len(y) or not all(math.isfinite(v) and v > 0 for v in (*x, *y)):
        raise ResultsError(f"{where}: x and y are positive numbers, as many of one as of the other")
    return curve


def _png(where: str, value: Any) -> str:
    """Goes into the page as it is: nothing but a PNG may."""
    try:
        good = base64.b64decode(_text(where, value), validate=True).startswith(b"\x89PNG\r\n\x1a\n")
    except ValueError:
        good = False
    if not good:
        raise ResultsError(f"{where}: not a PNG in base64")
    return str(value)


def read_measurement(path: Path) -> Measurement:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ResultsError(f"{path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise ResultsError(f"{path} is not JSON: {error}") from error
    if not isinstance(content, dict) or not isinstance(content.get("rows"), list):
        raise ResultsError(f'{path}: expected an object with a list "rows"')
    rows = [read_row(str(path), row) for row in content["rows"]]
    ids = [row.id for row in rows]
    for repeated in sorted({name for name in ids if ids.count(name) > 1}):
        raise ResultsError(f"{path}: the row {repeated!r} stands there twice")
    curves = content.get("curves") or {}
    machine = content.get("machine") or {}
    pictures = content.get("pictures") or {}
    if not all(isinstance(part, dict) for part in (curves, machine, pictures)):
        raise ResultsError(f"{path}: curves, machine and pictures are objects")
    return Measurement(
        rows,
        {name: _curve(f"{path}, curve {name!r}", curve) for name, curve in curves.items()},
        {name: str(value) for name, value in machine.items()},
        {name: _png(f"{path}, picture {name!r}", value) for name, value in pictures.items()},
    )


def command_line(description: str) -> argparse.ArgumentParser:
    """What every measuring command understands."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", type=Path, required=True, help="file of rows to write")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="few and small samples: tries the command, proves nothing",
    )
    return parser


# --- statistics -----------------------------------------------------------------------------------


def median_and_spread(values: Any) -> tuple[float, tuple[float, float]]:
    """Median and quartiles."""
    low, middle, high = np.percentile(np.asarray(values, float), [25, 50, 75])
    return float(middle), (float(low), float(high))


def ratio_and_spread(ours: Any, theirs: Any) -> tuple[float, tuple[float, float]]:
    """Ratio of two series measured in turns: the median and the quartiles of the pairs' own ratios, so that a
    machine that slows down for a while slows both sides of a pair."""
    return median_and_spread(np.asarray(ours, float) / np.asarray(theirs, float))


def exponent(x: Any, y: Any) -> tuple[float, tuple[float, float]]:
    """Slope of ln y over ln x by least squares, and its 95 % interval (Student's t)."""
    from scipy import stats

    fit = stats.linregress(np.log(np.asarray(x, float)), np.log(np.asarray(y, float)))
    reach = float(stats.t.ppf(0.975, len(np.asarray(x)) - 2) * fit.stderr)
    return float(fit.slope), (float(fit.slope) - reach, float(fit.slope) + reach)
