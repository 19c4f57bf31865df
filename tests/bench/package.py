"""The extension as a user gets it: its size, the time to the first picture, memory over many redraws, and in how many
Blender versions its whole life-cycle passes.

The life-cycle (tests/window/lifecycle.py) is run in each bpy wheel here, from an empty user folder. That of a real
window is run by `make test-window`, which leaves out/window/lifecycle.json; it is counted where it is there.
"""

from __future__ import annotations

import datetime
import json
import sys
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench_rows import Measurement, ResultsError, Row, command_line, write_measurement

BENCH = Path(__file__).resolve().parent
ROOT = BENCH.parents[1]
sys.path.insert(0, str(ROOT / "tests/package"))

from clean_blender import CleanBlender, make_package  # noqa: E402 - its folder is found above
from version_table import WHEELS  # noqa: E402

LIFECYCLE = ROOT / "tests/window/lifecycle.py"
WINDOW_RESULT = ROOT / "out/window/lifecycle.json"
Say = Callable[[str], None]


def extension_zip(folder: Path) -> tuple[Path, str]:
    """The package in dist/, or one around the modules of `make core`; and which it is."""
    manifest = tomllib.loads((ROOT / "addon/togishi/blender_manifest.toml").read_text())
    released = ROOT / f"dist/togishi-{manifest['version']}-linux_x64.zip"
    if released.is_file():
        return released, "made by `make package`"
    modules = [row.module for row in WHEELS if row.module is not None]
    return make_package(folder, *modules), "around the modules of `make core`"


def live(blender: CleanBlender, zip_path: Path) -> dict[str, Any]:
    """What the life-cycle leaves behind in one version."""
    out, console = blender.folder / "out", blender.folder / "console.txt"
    blender.process(
        LIFECYCLE,
        *("--zip", zip_path, "--out", out, "--console", console),
        output=console,
        timeout_s=900.0,
    )
    results = list(out.glob("lifecycle*.json"))
    if len(results) != 1:
        tail = console.read_text(errors="replace")[-2000:]
        raise ResultsError(f"Blender {blender.row.label}: the life-cycle left no result:\n{tail}")
    return json.loads(results[0].read_text(encoding="utf-8"))


def lives(zip_path: Path, quick: bool, say: Say) -> list[tuple[str, dict[str, Any]]]:
    """(label, result) of each version at hand."""
    found = []
    for row in WHEELS[:1] if quick else WHEELS:
        if row.module is None:
            say(f"      Blender {row.label} is not set up")
            continue
        with tempfile.TemporaryDirectory() as folder:
            found.append((row.label, live(CleanBlender(row, Path(folder)), zip_path)))
    if WINDOW_RESULT.is_file():
        result = json.loads(WINDOW_RESULT.read_text(encoding="utf-8"))
        day = datetime.datetime.fromtimestamp(WINDOW_RESULT.stat().st_mtime).astimezone()
        found.append((f"{result['blender']} in a window, {day:%Y-%m-%d %H:%M}", result))
    for label, result in found:
        wrong = [step for step in result["steps"] if not step["ok"]]
        said = f"failed at {wrong[0]['name']!r}: {wrong[0]['note']}" if wrong else "passed"
        say(f"      Blender {label}: {said if result['passed'] or wrong else 'not finished'}")
    return found


def figures(found: list[tuple[str, dict[str, Any]]], name: str) -> dict[str, float]:
    """A figure of all versions that have it."""
    return {label: float(result[name]) for label, result in found if result[name] is not None}


def listed(values: dict[str, float]) -> str:
    return "; ".join(f"{label}: {value:.2f}" for label, value in values.items())


def measure(quick: bool, say: Say) -> Measurement:
    with tempfile.TemporaryDirectory() as folder:
        zip_path, origin = extension_zip(Path(folder))
        rows = [Row("package.zip_mb", zip_path.stat().st_size / 1e6, "MB", 20.0, "<=", how=origin)]
        found = lives(zip_path, quick, say)
    times = figures(found, "install_to_picture_s")
    if times:
        how = "slowest version: installing, enabling, a whole blade with its maps baked, a spot lamp, shaders, drawing; "
        spread = (min(times.values()), max(times.values()))
        rows.append(
            Row(
                "package.install_to_picture_s",
                max(times.values()),
                "s",
                spread=spread,
                how=how + listed(times),
            )
        )
    growth = figures(found, "rss_growth_mb_per_100_redraws")
    if growth:
        how = "worst version: resident memory over 200 redraws with a moving light, after 60 that fill caches; "
        rows.append(
            Row(
                "package.memory_growth_mb_per_100_redraws",
                max(growth.values()),
                "MB",
                spread=(min(growth.values()), max(growth.values())),
                how=f"{how}on llvmpipe the GPU's memory is the process's; {listed(growth)}",
            )
        )
    passed = [label for label, result in found if result["passed"]]
    rows.append(
        Row("package.versions_passed", len(passed), "", 3.0, ">=", how="; ".join(passed) or "none")
    )
    return Measurement(rows)


if __name__ == "__main__":
    options = command_line(__doc__ or "").parse_args()
    write_measurement(
        options.out, measure(options.quick, lambda text: print(text, file=sys.stdout, flush=True))
    )
