"""From a scan's file to a measured, charted, lighter blade by `togishi scan`: time and memory of each step, rows scan.command_*; stretch of the chart, rows scan.uv_*."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from bench_rows import (
    Measurement,
    ResultsError,
    Row,
    bench_program,
    command_line,
    togishi_command,
    write_measurement,
)


def run(command: list[str]) -> tuple[str, float, float]:
    """What it printed, seconds, and the peak of its memory in GiB."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stderr is not None
    out, err = process.stdout.read(), process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise ResultsError(f"{' '.join(command)}: exit code {process.returncode}: {err}")
    return out, time.monotonic() - start, usage.ru_maxrss / 2**20  # KiB


def command_rows(name: str, triangles: float, folder: Path) -> list[Row]:
    file = folder / f"{name}.ply"
    simulate = str(bench_program("bench_scan_measure"))
    run(
        [simulate, "katana", f"{triangles:g}", "0.02", "1", "1", "0", "0", "stand", f"write={file}"]
    )
    togishi = str(togishi_command())
    _, seconds, peak_gib = run([togishi, "scan", str(file), "--out", str(folder / name)])
    found: dict[str, Any] = json.loads((folder / name / f"{name}.json").read_text())
    how = f"{triangles:g} triangles, 0.02 mm noise, binary PLY in double, all maps and levels written; not in Blender"
    rows = [
        Row(f"scan.command_seconds_{name}", seconds, "s", how=how),
        Row(f"scan.command_peak_gib_{name}", peak_gib, "GiB", how=how),
    ]
    rows += [
        Row(f"scan.command_{name}.{step}_s", value, "s", how="wall time")
        for step, value in found["seconds"].items()
    ]
    for i, level in enumerate(found["levels"]):
        prefix = f"scan.command_{name}.level{i}"
        how = f"{level['faces']} triangles, asked for {level['asked_mm']:.3g} mm"
        rows.append(Row(f"{prefix}_largest_mm", level["largest_mm"], "mm", how=how))
        rows.append(Row(f"{prefix}_rms_mm", level["rms_mm"], "mm", how=how))
    file.unlink()
    return rows


def stretch_rows(triangles: float) -> list[Row]:
    program = str(bench_program("bench_scan_prepare"))
    out, _, _ = run([program, "shinogi", f"{triangles:g}", "0.02", "0.16", "1024"])
    found = json.loads(out)
    how = f"finest level of {triangles:g} triangles, 0.02 mm noise, within 0.16 mm"
    return [
        Row(
            "scan.uv_stretch_pct",
            found["stretch_most_pct"],
            "%",
            3,
            "<=",
            how=f"{how}: the worst triangle, after settling (docs/scan_import.md); "
            "see scan.uv_stretch_99_pct and scan.chart_stretch_pct",
        ),
        Row("scan.uv_stretch_99_pct", found["stretch_99_pct"], "%", how=f"{how}: 99 % of the area"),
        Row(
            "scan.chart_stretch_pct",
            found["chart_stretch_pct"],
            "%",
            how="the chart itself, on the surface without noise: the worst triangle",
        ),
    ]


def main() -> int:
    options = command_line(__doc__ or "").parse_args()
    measurement = Measurement()
    sizes = {"100k": 1e5} if options.quick else {"1m": 1e6, "10m": 1e7}
    with tempfile.TemporaryDirectory() as folder:
        for name, triangles in sizes.items():
            measurement.rows += command_rows(name, triangles, Path(folder))
    measurement.rows += stretch_rows(5e4 if options.quick else 1e6)
    write_measurement(options.out, measurement)
    return 0


if __name__ == "__main__":
    sys.exit(main())
