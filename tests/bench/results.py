"""Measures, checks and shows every figure that is promised: `make results`.

Runs the measuring commands area by area, puts their rows into OUT/<area>.json, holds them to required.toml, prints all
rows and those that miss their bound, and writes OUT/index.html. Exit code 0: all there and within bounds; 1: not;
2: wrong usage.
"""

from __future__ import annotations

import argparse
import datetime
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bench_rows import Measurement, ResultsError, Row, read_measurement, write_measurement
from required import problems, read_required
from results_page import write_page

BENCH = Path(__file__).resolve().parent
REPOSITORY = BENCH.parents[1]

AREAS: Mapping[str, Sequence[Path]] = {
    "bake": [BENCH / "accuracy_spectral.py"],
    "accuracy": [BENCH / "accuracy_spectral.py", BENCH / "accuracy_gpu.py"],
    "viewport": [BENCH / "viewport.py"],
    "scale": [BENCH / "scale.py"],
    "package": [BENCH / "package.py"],
    "fit": [BENCH / "fit.py"],
    "light": [
        BENCH / "light.py",
        BENCH / "light_frames.py",
        BENCH / "light_exhibition.py",
        BENCH / "light_f12.py",
        BENCH / "light_parts.py",
    ],
    "capture": [
        BENCH / "capture_diffuse.py",
        BENCH / "capture_round_trip.py",
        BENCH / "capture_lights.py",
    ],
    "scan": [
        BENCH / "scan_mesh.py",
        BENCH / "scan_measure.py",
        BENCH / "scan_import.py",
        BENCH / "scan_blender.py",
    ],
}
"""Area -> its measuring commands (bench_rows.py says what they write). Ids of rows begin with the area."""


@dataclass
class Outcome:
    """What became of the areas: the rows on file, and what went wrong on the way to them."""

    areas: dict[str, Measurement]
    measured_at: dict[str, str]
    failures: list[str]


def environment() -> dict[str, str]:
    """The add-on and its shaders come from this checkout, the native module from the environment."""
    paths = [str(REPOSITORY / "addon"), str(BENCH), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)}


def last_lines(log: Path, count: int = 12) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    return "\n".join(f"    {line}" for line in lines[-count:])


def run_command(script: Path, rows_file: Path, log: Path, extra: Sequence[str]) -> str | None:
    """Runs one measuring command; its printed lines pass through, its errors go to the log. None if it went well."""
    rows_file.unlink(missing_ok=True)
    log.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, str(script), "--out", str(rows_file), *extra]
    with log.open("w", encoding="utf-8") as errors:
        done = subprocess.run(
            command, cwd=REPOSITORY, env=environment(), stderr=errors, check=False
        )
    if done.returncode != 0:
        return f"{script.name} ended with exit code {done.returncode}; {log}:\n{last_lines(log)}"
    if not rows_file.is_file():
        return f"{script.name} wrote no rows"
    return None


def merge(parts: Sequence[Path], area: str, areas: Mapping[str, Sequence[Path]]) -> Measurement:
    """The rows of one area from the files of its commands. A command may serve several areas; a row that belongs
    to none of them is a mistake, not a figure to lose."""
    merged = Measurement()
    for part in parts:
        measurement = read_measurement(part)
        serves = [
            name
            for name, scripts in areas.items()
            if part.stem in [script.stem for script in scripts]
        ]
        for row in measurement.rows:
            if row.id.split(".")[0] not in serves:
                raise ResultsError(
                    f"{part}: the row {row.id!r} belongs to none of the areas {', '.join(serves)}"
                )
            if any(row.id == other.id for other in merged.rows):
                raise ResultsError(f"{part}: the row {row.id!r} was measured by two commands")
        merged.rows += [row for row in measurement.rows if row.id.startswith(f"{area}.")]
        merged.curves |= measurement.curves
        merged.machine |= measurement.machine
        merged.pictures |= measurement.pictures
    return merged


def measure(
    areas: Mapping[str, Sequence[Path]],
    chosen: Sequence[str],
    out: Path,
    extra: Sequence[str],
    say: Callable[[str], None],
) -> list[str]:
    """Measures the chosen areas anew. An area whose command fails loses its old figures: they are not today's."""
    failures = []
    scripts = list(dict.fromkeys(script for area in chosen for script in areas[area]))
    parts = {script: out / "parts" / f"{script.stem}.json" for script in scripts}
    for area in chosen:
        (out / f"{area}.json").unlink(missing_ok=True)
    for step, script in enumerate(scripts, 1):
        serves = ", ".join(area for area in chosen if script in areas[area])
        say(f"[{step}/{len(scripts)}] {serves}: {script.stem}")
        started = time.monotonic()
        failure = run_command(script, parts[script], out / "logs" / f"{script.stem}.log", extra)
        if failure is None:
            say(f"      done in {time.monotonic() - started:.0f} s")
        else:
            parts[script].unlink(missing_ok=True)
            failures.append(failure)
            say(f"      FAILED: {failure}")
    for area in chosen:
        measured = [parts[script] for script in areas[area] if parts[script].is_file()]
        try:
            if measured:
                write_measurement(out / f"{area}.json", merge(measured, area, areas))
        except ResultsError as error:
            failures.append(str(error))
            say(f"      FAILED: {error}")
    return failures


def collect(areas: Sequence[str], out: Path) -> Outcome:
    outcome = Outcome({}, {}, [])
    for area in areas:
        path = out / f"{area}.json"
        if not path.is_file():
            continue
        try:
            outcome.areas[area] = read_measurement(path)
            stamp = datetime.datetime.fromtimestamp(path.stat().st_mtime).astimezone()
            outcome.measured_at[area] = f"{stamp:%Y-%m-%d %H:%M}"
        except ResultsError as error:
            outcome.failures.append(str(error))
    return outcome


def machine(areas: Mapping[str, Measurement]) -> dict[str, str]:
    """What the figures were measured on."""
    processor = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                processor = line.partition(":")[2].strip()
                break
    described = {
        "processor": f"{processor}, {os.cpu_count()} cores",
        "system": platform.platform(),
        "Python": platform.python_version(),
    }
    for measurement in areas.values():
        described |= measurement.machine
    return described


def spread_text(row: Row) -> str:
    if row.spread is None:
        return ""
    if isinstance(row.spread, tuple):
        return f"{row.spread[0]:.3g} … {row.spread[1]:.3g}"
    return f"± {row.spread:.3g}"


def table(rows: Sequence[Row]) -> str:
    cells = [["", "row", "value", "bound", "spread"]]
    for row in rows:
        bound = "" if row.bound is None else f"{row.op} {row.bound:g}"
        mark = "" if row.bound is None else ("ok" if row.kept else "MISSED")
        cells.append([mark, row.id, f"{row.value:.4g} {row.unit}".strip(), bound, spread_text(row)])
    widths = [max(len(line[i]) for line in cells) for i in range(5)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in cells
    )


def main(
    arguments: Sequence[str] | None = None, areas: Mapping[str, Sequence[Path]] = AREAS
) -> int:
    parser = argparse.ArgumentParser(prog="results", description=__doc__)
    parser.add_argument("--area", action="append", choices=sorted(areas), help="only this area")
    parser.add_argument("--out", type=Path, default=REPOSITORY / "out/results")
    parser.add_argument("--required", type=Path, default=BENCH / "required.toml")
    parser.add_argument(
        "--check", action="store_true", help="measure nothing, check what is on file"
    )
    parser.add_argument("--quick", action="store_true", help="few samples: tries the commands")
    options = parser.parse_args(arguments)
    chosen = [area for area in areas if not options.area or area in options.area]

    def say(text: str) -> None:
        print(text, flush=True)

    try:
        required = read_required(options.required)
    except ResultsError as error:
        parser.error(str(error))
    failures = []
    if not options.check:
        failures += measure(areas, chosen, options.out, ["--quick"] if options.quick else [], say)
    outcome = collect(list(areas), options.out)
    rows = [row for measurement in outcome.areas.values() for row in measurement.rows]
    judged = [row for row in rows if row.id.split(".")[0] in chosen]
    went_wrong = failures + outcome.failures
    wrong = went_wrong + problems(judged, required.of_areas(chosen))
    page = options.out / "index.html"
    # The page shows every area, so it is judged by all that is promised.
    on_page = went_wrong + problems(rows, required)
    write_page(page, outcome.areas, outcome.measured_at, machine(outcome.areas), on_page, required)
    say(table(rows))
    if wrong:
        say(f"\n{len(wrong)} of the results are not as promised:")
        for sentence in wrong:
            say(f"  - {sentence}")
    say(f"\nPage: {page}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
