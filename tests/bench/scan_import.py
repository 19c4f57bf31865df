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
from scan_measure import SHAPES


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


def chart_figures(
    shape: str, triangles: float, parts: tuple[str, ...], folder: Path
) -> dict[str, float]:
    """What the record of a whole import says of the chart."""
    file = folder / f"{shape}.ply"
    simulate = str(bench_program("bench_scan_measure"))
    run([simulate, shape, f"{triangles:g}", "0.02", "1", "1", "0", "0", *parts, f"write={file}"])
    out = folder / f"{shape}_out"
    command = [str(togishi_command()), "scan", str(file), "--out", str(out), "--force"]
    run([*command, "--no-maps", "--levels", "1", "--replicates", "0", "--unit", "mm"])
    file.unlink()
    record: dict[str, Any] = json.loads((out / f"{shape}.jsonld").read_text())
    [derived] = [node for node in record["@graph"] if node["@id"] == "_:import"]
    [prepared] = [s for s in derived["crm:P9_consists_of"] if s["rdfs:label"] == "prepare"]
    return {
        figure["crm:P2_has_type"]["rdfs:label"]: figure["crm:P90_has_value"]
        for figure in prepared["togishi:figures"]
    }


def stretch_rows(triangles: float, folder: Path) -> list[Row]:
    rows = []
    bare, worst, worst_99 = [], [], []
    for prefix, parts in (("", ()), ("habaki_", ("habaki", "stand", "holes"))):
        for shape in SHAPES:
            found = chart_figures(shape, triangles, parts, folder)
            most = found["chart's stretch, largest"]
            worst.append(most)
            if not parts:
                bare.append(most)
                worst_99.append(found["chart's stretch, 99 % of the area"])
            how = (
                f"the worst triangle of the finest level, {triangles:g} triangles, 0.02 mm noise, whole import; "
                f"{', '.join(parts) or 'bare'}; {found['settled: area stretched before']:.0f} mm2 above 2 % before "
                f"settling, {found['settled: area left stretched']:.3f} after"
            )
            rows.append(Row(f"scan.uv_stretch.{prefix}{shape}_pct", most, "%", how=how))
    scans = f"the worst of {len(SHAPES)} shapes, scans of {triangles:g} triangles, 0.02 mm noise"
    how = f"{scans}, bare and with habaki, stand and holes in the edge"
    rows += [
        Row(
            "scan.uv_stretch_pct",
            max(worst),
            "%",
            3,
            "<=",
            spread=(min(worst), max(worst)),
            how=f"{how}: the worst triangle, after settling (docs/scan_import.md); "
            "see scan.uv_stretch_99_pct and scan.chart_stretch_pct",
        ),
        Row("scan.uv_stretch_bare_pct", max(bare), "%", how=f"{scans}, bare: the worst triangle"),
        Row("scan.uv_stretch_99_pct", max(worst_99), "%", how=f"{scans}, bare: 99 % of the area"),
    ]
    program = str(bench_program("bench_scan_prepare"))
    out, _, _ = run([program, "shinogi", "5e4", "0.02", "0.16", "1024"])
    rows.append(
        Row(
            "scan.chart_stretch_pct",
            json.loads(out)["chart_stretch_pct"],
            "%",
            how="the chart itself, on a katana's surface without noise: the worst triangle",
        )
    )
    return rows


def main() -> int:
    options = command_line(__doc__ or "").parse_args()
    measurement = Measurement()
    sizes = {"100k": 1e5} if options.quick else {"1m": 1e6, "10m": 1e7}
    with tempfile.TemporaryDirectory() as folder:
        for name, triangles in sizes.items():
            measurement.rows += command_rows(name, triangles, Path(folder))
        measurement.rows += stretch_rows(1e5 if options.quick else 1e6, Path(folder))
    write_measurement(options.out, measurement)
    return 0


if __name__ == "__main__":
    sys.exit(main())
