"""Lights of a size, small highlights and surroundings: errors against quadrature, and what each quality level costs.

    python tests/bench/light.py --out ROWS [--configurations 1400] [--seed 1]

The program bench_light (built with the tests) draws the configurations and measures; its head says how. The levels:
4 slices of two nodes while something moves; 16 `fine` ones, cut where G bends, when the picture rests.
"""

from __future__ import annotations

import base64
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
from bench_rows import (
    Measurement,
    ResultsError,
    Row,
    bench_program,
    command_line,
    write_measurement,
)

mpl.use("agg")
from matplotlib import pyplot

AT_REST = "16_fine"
EIGHT = "8_fine"


def bench(*arguments: object) -> Any:
    done = subprocess.run(
        [str(bench_program("bench_light")), *map(str, arguments)],
        stdout=subprocess.PIPE,
        check=True,
    )
    return json.loads(done.stdout)


def level_name(level: dict[str, Any]) -> str:
    return f"{level['slices']}{'_fine' if level['fine'] else ''}"


def of_levels(kind: str, lobes: str, levels: list[dict[str, Any]], how: str) -> list[Row]:
    """Every level as it is; the bounds belong to the named rows of promises()."""
    rows = []
    for level in levels:
        prefix = f"light.{kind}.{lobes}{level_name(level)}"
        text = f"{how}, {level['points']} points"
        rows += [
            Row(f"{prefix}.max_pct", level["max"], "%", how=text),
            Row(f"{prefix}.p999_pct", level["p999"], "%", how=text),
            Row(f"{prefix}.mean_pct", level["mean"], "%", how=text),
            Row(f"{prefix}.ns", level["ns"], "ns", how="one light and lobe, one CPU core"),
        ]
    return rows


def by_name(levels: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {level_name(level): level for level in levels}


def rectangle(levels: list[dict[str, Any]], how: str) -> list[Row]:
    best = by_name(levels)[AT_REST]
    return [
        Row("light.rect.max_pct", best["max"], "%", 8.0, "<=", how=how),
        Row("light.rect.mean_pct", best["mean"], "%", 0.13, "<=", how=how),
        Row("light.rect.usual_max_pct", best["usual_max"], "%", 3.0, "<=", how=how),
        Row("light.rect.usual_mean_pct", best["usual_mean"], "%", 0.08, "<=", how=how),
    ]


def pareto(title: str, levels: list[dict[str, Any]]) -> str:
    """Time against the 99.9th percentile and the mean of the error, as a PNG in base64."""
    figure, axes = pyplot.subplots(figsize=(6.4, 4.2), layout="constrained", dpi=110)
    for fine, marker in ((False, "o"), (True, "s")):
        chosen = sorted(
            (level for level in levels if level["fine"] == fine), key=lambda level: level["ns"]
        )
        for key, colour, label in (
            ("p999", "#b4532a", "99.9 % of all points are below"),
            ("mean", "#2f5d8a", "mean"),
        ):
            axes.plot(
                [level["ns"] / 1000 for level in chosen],
                [level[key] for level in chosen],
                marker=marker,
                linewidth=1.2,
                color=colour,
                linestyle="--" if fine else "-",
                label=f"{label}{', fine' if fine else ''}",
            )
        for level in chosen:
            axes.annotate(
                str(level["slices"]),
                (level["ns"] / 1000, level["p999"]),
                (4, 5),
                textcoords="offset points",
                fontsize=8,
            )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(mpl.ticker.LogFormatter(minor_thresholds=(2, 1)))
    axes.xaxis.set_minor_formatter(mpl.ticker.LogFormatter(minor_thresholds=(2, 1)))
    axes.yaxis.set_major_formatter(mpl.ticker.StrMethodFormatter("{x:g}"))
    axes.set_xlabel("time of one light and lobe on one CPU core, µs; numbers: slices")
    axes.set_ylabel("error, % of the profile's peak")
    axes.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    axes.set_title(title, loc="left", fontsize=11)
    axes.legend(fontsize=8, frameon=False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    pyplot.close(figure)
    return base64.b64encode(buffer.getvalue()).decode()


def anti_aliasing(trials: int, seed: int) -> list[Row]:
    found = bench("aa", trials, seed)
    rows = []
    for entry in found["straight"]:
        prefix = f"light.aa.straight_{entry['width_px']:g}px"
        how = "8 phases against 65536 samples a pixel"
        rows += [
            Row(f"{prefix}.energy_pct", entry["energy"], "%", 0.2, "<=", how=how),
            Row(f"{prefix}.peak_pct", entry["peak"], "%", 5.0, "<=", how=how),
        ]
    how = f"worst of {trials} trials"
    return [
        *rows,
        Row("light.aa.turned.energy_pct", found["turned_energy"], "%", 0.2, "<=", how=how),
        Row("light.aa.turned.peak_pct", found["turned_peak"], "%", 5.0, "<=", how=how),
        Row("light.aa.curved.1_node_pct", found["curved_1"], "%", how=how),
        Row(
            "light.aa.curved.4_nodes_pct",
            found["curved_4"],
            "%",
            10.0,
            "<=",
            how=f"{how}, lobe 1:1 to 9:1, 0.1 to 2 pixels, both curvatures",
        ),
        Row(
            "light.aa.ridge_pct",
            found["ridge"],
            "%",
            10.0,
            "<=",
            how=f"{how}: a rounded edge of 5 to 60 degrees, 0.001 to 30 pixels wide, against 4096 samples a pixel; the formula alone, which no picture uses yet: shinogi and yokote are drawn as sharp creases",
        ),
    ]


def surroundings() -> list[Row]:
    bounds = {(3, 5): 3.5, (10, 25): 2.0}
    rows = []
    for entry in bench("env")["taps"]:
        key = (round(entry["aspect"]), entry["taps"])
        bound = bounds.get(key)
        prefix = f"light.env.aspect{key[0]}_taps{key[1]}"
        rows += [
            Row(
                f"{prefix}.patch_pct",
                entry["patch"],
                "%",
                bound,
                None if bound is None else "<=",
                how="largest error of the reflection of a patch as wide as the lobe's short axis, of its peak",
            ),
            Row(f"{prefix}.point_pct", entry["point"], "%", how="the same for a point"),
        ]
    return rows


def main() -> int:
    parser = command_line(__doc__.splitlines()[0])
    parser.add_argument("--configurations", type=int, default=1400)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    count = 40 if options.quick else options.configurations
    how = f"{count} configurations of seed {options.seed}, float"
    measured = Measurement()

    levels = bench("rectangle", count, options.seed)["levels"]
    measured.rows += rectangle(levels, f"16 fine slices; {how}")
    measured.rows += of_levels("rect", "", levels, how)
    measured.pictures["Rectangles: error against time"] = pareto("Rectangle", levels)
    for kind, short in (("disk", "disk"), ("sphere", "sphere"), ("sun", "sun")):
        round_lobes = bench(kind, count, options.seed, "isotropic")["levels"]
        levels = bench(kind, count, options.seed)["levels"]
        measured.rows += [
            Row(
                f"light.{short}.isotropic_max_pct",
                by_name(round_lobes)[EIGHT]["max"],
                "%",
                0.15,
                "<=",
                how=f"8 fine slices; {how}",
            ),
            Row(
                f"light.{short}.anisotropic_max_pct",
                by_name(levels)[EIGHT]["max"],
                "%",
                0.6,
                "<=",
                how=f"8 fine slices; {how}",
            ),
        ]
        measured.rows += of_levels(short, "isotropic.", round_lobes, how)
        measured.rows += of_levels(short, "", levels, how)
        measured.pictures[f"{kind.capitalize()}: error against time"] = pareto(
            f"{kind.capitalize()}, lobes of aspect 1 to 10", levels
        )
    measured.rows += anti_aliasing(20 if options.quick else 200, options.seed)
    measured.rows += surroundings()
    write_measurement(options.out, measured)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (ResultsError, subprocess.CalledProcessError) as error:
        sys.exit(f"{Path(__file__).name}: {error}")
