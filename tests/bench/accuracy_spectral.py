"""Error of the 61 samples, error and time of every simplification of F(theta) E, and the time of a table's bake.

Runs the program bench_spectral (built with the tests), which computes all of it in one process, and writes its rows.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench_rows import (
    Measurement,
    ResultsError,
    Row,
    bench_program,
    command_line,
    write_measurement,
)

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "addon"))

from togishi.core.shader_source import TABLE_SIZE  # noqa: E402

WHAT = {
    "reference_1nm": "sum over 471 wavelengths in float",
    "samples_61": "sum over 61 wavelengths in float",
    "samples_31": "sum over 31 wavelengths, 10 nm, in float",
    "samples_16": "sum over 16 wavelengths, 20 nm, in float",
    "samples_61_white_ratio": "61 values sampled at 5 nm, each of X, Y, Z times W_full/W_61",
    "rgb_nk": "n and k as RGB (weighed under D65), three Fresnel terms times the light's RGB",
    "schlick": "Schlick's curve from F0 as RGB (under D65), times the light's RGB",
    "d65_table_rgb_light": "a table baked under D65, times the light's RGB over D65's",
    "table_512_float": "the viewport's table: 512 entries by sqrt(cos theta), F from a polynomial through 28 Chebyshev "
    "points of cos theta, in float (its bake: bake.table_us)",
    "table_512_every_row": "512 entries by sqrt(cos theta), each by its own sum, in float (its bake: "
    "bake.table_every_row_us)",
}


def what(method: str) -> str:
    if method in WHAT:
        return WHAT[method]
    kind, size, precision = method.split("_")
    assert kind == "table"
    return f"the exact table with {size} entries by sqrt(cos theta), in {precision}"


def place(worst: dict[str, Any]) -> str:
    return f"worst: {worst['metal']}, {worst['light']}, {worst['angle_deg']:g}°"


def time_row(
    row_id: str, timing: dict[str, float], unit: str, how: str, bound: float | None
) -> Row:
    return Row(
        id=row_id,
        value=timing["median"],
        unit=unit,
        bound=bound,
        op=None if bound is None else "<=",
        spread=(timing["low"], timing["high"]),
        how=how,
    )


def rows_of(measured: dict[str, Any], rounds: int) -> list[Row]:
    rows = [
        Row(
            id="accuracy.grid_de00",
            value=measured["grid"]["de00"],
            bound=0.1,
            op="<=",
            how="CIEDE2000 of 61 samples against 360-830 nm at 1 nm, double; all metals x 17 lights and spectral lines at "
            f"every nm from 400.5 to 699.5, 0-88° by 0.5°; {place(measured['grid'])}",
        ),
        time_row(
            "bake.table_us",
            measured["table_us"],
            "us",
            f"the viewport's {TABLE_SIZE} entries x 61 wavelengths from a light's new temperature on, n and k kept; "
            f"one core, median and quartiles of {10 * rounds}",
            100.0,
        ),
        time_row(
            "bake.table_every_row_us",
            measured["table_every_row_us"],
            "us",
            "the same with every entry by its own sum over the wavelengths, as it would be without the polynomial",
            None,
        ),
        time_row(
            "bake.light_change_us",
            measured["light_change_us"],
            "us",
            "the same through the product's entry point, which keeps the metal's reflectance too",
            None,
        ),
    ]
    for method, result in measured["methods"].items():
        rows.append(
            Row(
                id=f"accuracy.pareto.{method}.de00",
                value=result["lights"]["de00"],
                how=f"{what(method)}; all metals x 17 lights, 0-88°; {place(result['lights'])}; "
                f"under six spectral lines {result['lines']['de00']:.2g}; largest error of X, Y or Z over Y against "
                f"the 61-sample sum {result['lights_xyz_rel']:.2g}, under lines {result['lines_xyz_rel']:.2g}",
            )
        )
        rows.append(
            time_row(
                f"accuracy.pareto.{method}.ns",
                result["ns"],
                "ns",
                f"{what(method)}; one evaluation on one core, iron under D65, 1024 random cosines, "
                f"median and quartiles of {rounds} interleaved rounds",
                None,
            )
        )
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    options = command_line(__doc__ or "").parse_args(arguments)
    rounds = 5 if options.quick else 101
    try:
        command = [
            str(bench_program("bench_spectral")),
            str(rounds),
            str(TABLE_SIZE),
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ResultsError(
                f"{command[0]} ended with exit code {done.returncode}: {done.stderr[-2000:]}"
            )
        rows = rows_of(json.loads(done.stdout), rounds)
    except (ResultsError, OSError, ValueError) as error:
        print(f"accuracy_spectral: {error}", file=sys.stderr)
        return 1
    write_measurement(options.out, Measurement(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
