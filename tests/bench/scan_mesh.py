"""Reading, cleaning and simplifying a scan: time, memory and distance, as rows scan.read_*, scan.clean_*, scan.simplify_*."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from bench_rows import (
    Curve,
    Measurement,
    ResultsError,
    Row,
    bench_program,
    command_line,
    exponent,
    write_measurement,
)

BOUNDS_MM = (0.05, 0.1, 0.2, 0.5)
NOISE_MM = 0.02


def measure(millions: float, bounds_mm: tuple[float, ...], folder: Path) -> dict[str, Any]:
    program = bench_program("bench_scan_mesh")
    file = folder / f"{millions:g}.ply"
    command = [str(program), str(file), f"{millions:g}", str(NOISE_MM), *map(str, bounds_mm)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ResultsError(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr}")
    file.unlink()
    return dict(json.loads(done.stdout))


def step_rows(name: str, found: dict[str, Any]) -> list[Row]:
    how = f"{found['triangles']} triangles of a blade's surface, 0.02 mm noise, binary PLY in double; wall time"
    return [
        row
        for step in ("read", "clean", "pieces", "holes")
        for row in (
            Row(f"scan.{step}_{name}_s", found[step]["s"], "s", how=how),
            Row(f"scan.{step}_{name}_peak_gib", found[step]["peak_gib"], "GiB", how=how),
        )
    ]


def simplify_rows(name: str, found: dict[str, Any]) -> list[Row]:
    rows = []
    for light in found["simplified"]:
        bound_mm = light["bound_mm"]
        prefix = f"scan.simplify_{name}.{bound_mm:g}mm"
        how = (
            f"{found['triangles']} triangles to {light['triangles']} under {bound_mm:g} mm, "
            f"{light['attempts']} attempts; distance measured both ways"
        )
        rows += [
            Row(f"{prefix}.largest_mm", light["largest_mm"], "mm", bound_mm, "<=", how=how),
            Row(f"{prefix}.rms_mm", light["rms_mm"], "mm", how=how),
            Row(f"{prefix}.s", light["simplify"]["s"], "s", how=how),
            Row(f"{prefix}.peak_gib", light["simplify"]["peak_gib"], "GiB", how=how),
            Row(f"{prefix}.triangles", light["triangles"], "", how=how),
        ]
    return rows


def time_over_error(found: dict[str, Any]) -> Curve:
    x = tuple(light["bound_mm"] for light in found["simplified"])
    y = tuple(light["simplify"]["s"] for light in found["simplified"])
    slope, interval = exponent(x, y)
    return Curve("allowed distance, mm", "time to simplify, s", x, y, slope, interval)


def main() -> int:
    options = command_line(__doc__ or "").parse_args()
    sizes = {"100k": 0.1} if options.quick else {"1m": 1.0, "10m": 10.0}
    measurement = Measurement()
    with tempfile.TemporaryDirectory() as folder:
        for name, millions in sizes.items():
            # Ten million triangles are simplified as an import does it; the curve is the smaller scan's.
            bounds_mm = (0.1,) if name == "10m" else BOUNDS_MM
            found = measure(millions, bounds_mm, Path(folder))
            measurement.rows += step_rows(name, found) + simplify_rows(name, found)
            if len(bounds_mm) > 2:
                measurement.curves[f"simplify {name}"] = time_over_error(found)
    write_measurement(options.out, measurement)
    return 0


if __name__ == "__main__":
    sys.exit(main())
