"""The plots of the results page, as SVG text that takes its colours from the page (light or dark)."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import matplotlib
import numpy as np
from bench_rows import TIME_UNITS_S, Curve, Row

matplotlib.use("agg")
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# Drawn in these colours, which then become the page's own.
INK, SOFT, LINE, ACCENT, PANEL = "#010101", "#020202", "#030303", "#040404", "#050505"
PAGE_COLOURS = {INK: "ink", SOFT: "soft", LINE: "line", ACCENT: "accent", PANEL: "panel"}
STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "togishi",
    "font.family": "sans-serif",
    "font.size": 10.5,
    "axes.edgecolor": LINE,
    "axes.labelcolor": SOFT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "grid.color": LINE,
    "text.color": INK,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
}
PARETO = "accuracy.pareto."


@dataclass(frozen=True)
class Simplification:
    name: str
    error: float
    error_unit: str
    time_ns: float


def simplifications(rows: Iterable[Row]) -> list[Simplification]:
    """Pairs of rows accuracy.pareto.<what>.<error or time>."""
    pairs: dict[str, dict[str, Row]] = {}
    for row in rows:
        if row.id.startswith(PARETO) and row.id.count(".") >= 3:
            what = row.id[len(PARETO) :].rpartition(".")[0]
            pairs.setdefault(what, {})["time" if row.unit in TIME_UNITS_S else "error"] = row
    return [
        Simplification(
            what.replace("_", " "),
            pair["error"].value,
            pair["error"].unit or "ΔE00",
            pair["time"].value * TIME_UNITS_S[pair["time"].unit] * 1e9,
        )
        for what, pair in pairs.items()
        if len(pair) == 2 and pair["error"].value > 0 and pair["time"].value > 0
    ]


def pareto_front(points: Iterable[Simplification]) -> list[Simplification]:
    """Those that no other beats in both error and time."""
    front: list[Simplification] = []
    for point in sorted(points, key=lambda p: (p.time_ns, p.error)):
        if not front or point.error < front[-1].error:
            front.append(point)
    return front


def _svg(figure: Figure, title: str) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    pyplot.close(figure)
    text = re.sub(r"^.*?(?=<svg)", "", buffer.getvalue(), flags=re.DOTALL)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    text = re.sub(r'(<svg[^>]*?) width="[^"]*"', r'\1 role="img"', text, count=1)
    text = text.replace(">", f"><title>{title}</title>", 1)
    for colour, name in PAGE_COLOURS.items():
        text = text.replace(colour, f"var(--{name})")
    # Presentation attributes do not take variables: everything that matplotlib sets goes into `style`.
    return re.sub(r'\b(fill|stroke)="(var\([^"]*\))"', r'style="\1: \2"', text)


def _log_axes(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(visible=True, which="major", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.minorticks_off()
    for side in ("left", "bottom"):
        axes.spines[side].set_linewidth(0.8)


def _place_labels(axes: Axes, points: list[Simplification], emphasised: set[str]) -> None:
    """Each label where it meets no point and no other label, tried around its point; else a little further off. Points
    that lie on one another share a label."""
    figure = axes.figure
    renderer = figure.canvas.get_renderer()
    spots = axes.transData.transform([(p.time_ns, p.error) for p in points])
    taken = [matplotlib.transforms.Bbox.from_extents(x - 5, y - 5, x + 5, y + 5) for x, y in spots]
    around = [(7, 4, "left"), (-7, 4, "right"), (7, -11, "left"), (-7, -11, "right")]
    around += [(0, 10, "center"), (0, -18, "center"), (12, 16, "left"), (-12, 16, "right")]
    around += [(14, -24, "left"), (-14, -24, "right"), (0, 24, "center"), (18, 30, "left")]
    inside = axes.get_window_extent()
    together: list[list[int]] = []
    for index, spot in enumerate(spots):
        near = (g for g in together if np.abs(spots[g[0]] - spot).max() < 8)
        group = next(near, None)
        if group is None:
            together.append([index])
        else:
            group.append(index)
    # The tall labels first: they find room hardest.
    for group in sorted(together, key=len, reverse=True):
        point = points[group[0]]
        names = [points[index].name for index in group]
        best = None
        for dx, dy, side in around:
            label = axes.annotate(
                "\n".join(names),
                (point.time_ns, point.error),
                (dx, dy),
                textcoords="offset points",
                ha=side,
                fontsize=9,
                color=INK if emphasised & set(names) else SOFT,
            )
            box = label.get_window_extent(renderer)
            members = [taken[index] for index in group]
            others = [t for t in taken if not any(t is m for m in members)]
            hits = sum(box.overlaps(t) for t in others) + 3 * (
                box.x0 < inside.x0 or box.x1 > figure.bbox.x1 - 4
            )
            if best is None or hits < best[0]:
                if best is not None:
                    best[1].remove()
                best = (hits, label, box)
            else:
                label.remove()
            if hits == 0:
                break
        if best is not None:
            taken.append(best[2])


def pareto_plot(rows: Iterable[Row]) -> str | None:
    points = simplifications(rows)
    if not points:
        return None
    front = pareto_front(points)
    on_front = {point.name for point in front}
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(9.2, 5.4), layout="constrained")
        _log_axes(axes)
        axes.step(
            [p.time_ns for p in front],
            [p.error for p in front],
            where="post",
            color=ACCENT,
            linewidth=1.2,
            alpha=0.6,
        )
        for point in points:
            best = point.name in on_front
            axes.plot(
                point.time_ns,
                point.error,
                "o",
                markersize=7 if best else 5.5,
                color=ACCENT if best else SOFT,
                markeredgecolor=PANEL,
                markeredgewidth=1.2,
            )
        axes.margins(0.12, 0.1)
        axes.set_xlabel("time of one evaluation, ns")
        axes.set_ylabel(f"worst error, {points[0].error_unit}")
        figure.canvas.draw()
        _place_labels(axes, points, on_front)
        return _svg(figure, "Error of every simplification against its time")


def scale_plots(curves: Mapping[str, Curve]) -> dict[str, str]:
    """One small plot per curve: the measured points and the fitted power law."""
    plots = {}
    for name, curve in curves.items():
        x, y = np.array(curve.x), np.array(curve.y)
        with pyplot.rc_context(STYLE):
            figure, axes = pyplot.subplots(figsize=(4.4, 3.1), layout="constrained")
            _log_axes(axes)
            level = np.exp(np.mean(np.log(y) - curve.exponent * np.log(x)))
            axes.plot(x, level * x**curve.exponent, color=ACCENT, linewidth=1.4)
            axes.plot(x, y, "o", color=INK, markersize=5, markeredgecolor=PANEL)
            # A plot of almost equal values must not look like a slope.
            low, high = y.min() / 1.3, y.max() * 1.3
            while high / low < 10:
                low, high = low / 1.2, high * 1.2
            axes.set_ylim(low, high)
            axes.set_xlabel(curve.x_label)
            axes.set_ylabel(curve.y_label)
            low_e, high_e = curve.exponent_interval
            axes.set_title(
                f"exponent {curve.exponent:.2f}  ({low_e:.2f} … {high_e:.2f})",
                fontsize=10.5,
                loc="left",
                color=INK,
            )
            plots[name] = _svg(figure, f"{curve.y_label} against {curve.x_label}")
    return plots
