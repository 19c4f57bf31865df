"""From a binary PLY to a blade on the screen of Blender, in a fresh process: rows scan.seconds_10m, scan.peak_gib_10m and the
time of each step, scan.blender_*."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
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

MARK = "RESULT "


def run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = f"{done.stdout[-1000:]}{done.stderr[-2000:]}"
        raise ResultsError(f"{' '.join(command)}: exit code {done.returncode}: {said}")
    return done.stdout


def imported(triangles: float, folder: Path) -> dict[str, Any]:
    file = folder / "scan.ply"
    simulate = str(bench_program("bench_scan_measure"))
    run(
        [simulate, "katana", f"{triangles:g}", "0.02", "1", "1", "0", "0", "stand", f"write={file}"]
    )
    out = run([sys.executable, str(Path(__file__).with_name("scan_blender_once.py")), str(file)])
    line = next((line for line in out.splitlines() if line.startswith(MARK)), None)
    if line is None:
        raise ResultsError(f"scan_blender_once.py said nothing: {out[-2000:]}")
    found: dict[str, Any] = json.loads(line.removeprefix(MARK))
    return found


def rows_of(found: dict[str, Any], triangles: float, promised: bool) -> list[Row]:
    name = "10m" if promised else f"{triangles:g}"
    how = (
        f"{triangles:g} triangles, 0.02 mm noise, offset 1e5 mm, binary PLY of doubles, {found['faces']} faces left; fresh process, "
        "the operator's defaults, material, maps, then one frame of Togishi 1920x1080"
    )
    rows = [
        Row(
            f"scan.seconds_{name}",
            found["seconds"],
            "s",
            60.0 if promised else None,
            "<=" if promised else None,
            how=how,
        ),
        Row(
            f"scan.peak_gib_{name}",
            found["peak_gib"],
            "GiB",
            3.0 if promised else None,
            "<=" if promised else None,
            how=f"VmHWM of the process, with Blender and the graphics driver's own; {how}",
        ),
        Row(
            f"scan.blender_{name}.import_s",
            found["imported_s"],
            "s",
            how="the operator, without frame",
        ),
        Row(
            f"scan.blender_{name}.cpu_s",
            found["cpu_s"],
            "s",
            how="processor time of all threads, import and frame: where it is far below twice the wall time, the machine had other work or steps run on one core",
        ),
        Row(f"scan.blender_{name}.import_gib", found["imported_gib"], "GiB", how="peak until then"),
    ]
    rows += [
        Row(f"scan.blender_{name}.{step}_s", seconds, "s", how="wall time")
        for step, seconds in found["steps"].items()
    ]
    return rows


def main() -> int:
    options = command_line(__doc__ or "").parse_args()
    triangles = 1e5 if options.quick else 1e7
    with tempfile.TemporaryDirectory() as folder:
        found = imported(triangles, Path(folder))
    rows = rows_of(found, triangles, not options.quick)
    write_measurement(options.out, Measurement(rows, machine=found["machine"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
