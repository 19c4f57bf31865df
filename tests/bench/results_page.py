"""out/results/index.html: every figure with its bound, and the plots. One file, no network, light and dark."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path

from bench_rows import Measurement, Row, write_text
from required import Required
from results_plots import PARETO, pareto_plot, scale_plots

STYLE = """
:root { color-scheme: light dark; --ground: #f6f4ef; --panel: #fffdf8; --ink: #23211d; --soft: #6d685e; --line: #ddd8cc;
  --accent: #8a6a2b; --good: #2f6b45; --bad: #a8321f; --bad-ground: #f8e6e0; }
@media (prefers-color-scheme: dark) { :root { --ground: #121110; --panel: #1a1917; --ink: #e9e5dc; --soft: #a39d90; --line: #35322d;
  --accent: #c9b28a; --good: #86c79b; --bad: #f08f7a; --bad-ground: #35201b; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 15.5px/1.55 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 2.6rem 1.4rem 4rem; }
h1 { font: 400 2.1rem/1.2 "Iowan Old Style", Georgia, serif; margin: 0 0 .3rem; }
h2 { font: 400 1.35rem/1.3 "Iowan Old Style", Georgia, serif; margin: 2.8rem 0 .2rem; }
p { color: var(--soft); max-width: 46rem; margin: .2rem 0 .8rem; }
.verdict { font-size: 1.05rem; color: var(--good); margin-top: .8rem; }
.verdict.bad { color: var(--bad); }
ul.wrong { background: var(--bad-ground); border-left: 3px solid var(--bad); margin: .6rem 0; padding: .7rem 1rem .7rem 2rem; white-space: pre-line;
  overflow-wrap: anywhere; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; }
th, td { text-align: left; padding: .42rem 1.1rem .42rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 500; color: var(--soft); font-size: .82rem; }
td.n { font-variant-numeric: tabular-nums; white-space: nowrap; }
td small { display: block; color: var(--soft); font-size: .86em; line-height: 1.4; max-width: 40rem; }
code { font: .9em ui-monospace, Menlo, Consolas, monospace; }
.ok { color: var(--good); } .missed { color: var(--bad); font-weight: 600; }
.plots { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fit, minmax(310px, 1fr)); }
figure { margin: .6rem 0; background: var(--panel); border: 1px solid var(--line); border-radius: 6px; padding: .8rem 1rem; }
figure svg, figure img { width: 100%; height: auto; display: block; }
figcaption { color: var(--soft); font-size: .86rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1.2rem; font-size: .92rem; margin: .4rem 0; }
dt { color: var(--soft); } dd { margin: 0; }
"""

AREAS = {
    "viewport": (
        "Viewport",
        "Times on the light-sweep scene, ours and the rival's in turns in one process.",
    ),
    "accuracy": (
        "Accuracy",
        "Errors against the double-precision evaluation of 61 wavelengths, and of those against 1 nm.",
    ),
    "bake": ("Tables", "What a new light spectrum costs."),
    "scale": (
        "Scale",
        "Frame time while one size grows and all others stay. An exponent of 1 is proportional growth.",
    ),
    "fit": (
        "Goniometer fit",
        "Medians of the errors over simulated measurements (a: hamon, μ wide and narrow in degrees; b: ji), how often the "
        "1-σ intervals hold the truth, scans made with Mitsuba, and times. Rows without_terms: the same trials fitted "
        "without aperture, tilt and gain terms.",
    ),
    "light": (
        "Exhibition light",
        "Full radiance (Fresnel, G, cosines) of lights that have a size against adaptive quadrature, in % of the profile's peak; "
        "highlights smaller than a pixel; surroundings as rows of taps. Levels: slices of the lobe, fine ones cut where G bends.",
    ),
    "capture": (
        "Photographs",
        "Maps from photographs under many known lights: errors over simulated stacks (directions known to 0.5°, 1 % noise "
        "at full scale, 12 bits), what is flagged, how often the 1-σ intervals hold the truth, times, and a run from files.",
    ),
}


def _number(value: float, unit: str) -> str:
    return html.escape(f"{value:.4g} {unit}".strip())


def _spread(row: Row) -> str:
    if row.spread is None:
        return ""
    if isinstance(row.spread, tuple):
        return f"{row.spread[0]:.3g} … {row.spread[1]:.3g}"
    return f"± {row.spread:.3g}"


def _row(row: Row, what: str) -> str:
    words = html.escape(what[:1].upper() + what[1:]) if what else ""
    note = f"<small>{html.escape(row.how)}</small>" if row.how else ""
    bound = state = ""
    if row.bound is not None:
        sign = {"<=": "≤", ">=": "≥"}[row.op or "<="]
        bound = f"{sign} {row.bound:g}"
        state = '<span class="ok">kept</span>' if row.kept else '<span class="missed">missed</span>'
    name = (
        f"{words}<br><code>{html.escape(row.id)}</code>"
        if words
        else f"<code>{html.escape(row.id)}</code>"
    )
    return (
        f"<tr><td>{name}{note}</td>"
        f'<td class="n">{_number(row.value, row.unit)}</td><td class="n">{bound}</td>'
        f'<td class="n">{_spread(row)}</td><td class="n">{state}</td></tr>'
    )


def _table(rows: Sequence[Row], required: Required) -> str:
    what = {row.id: row.what for row in required.rows}
    # What is promised first.
    ordered = sorted(rows, key=lambda row: row.bound is None)
    body = "".join(_row(row, what.get(row.id, "")) for row in ordered)
    return (
        '<div class="scroll"><table><thead><tr><th>figure</th><th>measured</th><th>bound</th><th>spread</th><th></th></tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _area(name: str, measurement: Measurement, measured_at: str, required: Required) -> str:
    title, introduction = AREAS.get(name, (name.capitalize(), ""))
    parts = [
        f'<h2 id="{html.escape(name)}">{html.escape(title)}</h2>',
        f"<p>{html.escape(introduction)} Measured {html.escape(measured_at)}.</p>",
    ]
    pareto = pareto_plot(measurement.rows)
    if pareto:
        parts.append(
            f"<figure>{pareto}<figcaption>Error and time of each simplification; lower left is better. "
            "Coloured: no other one is both faster and more accurate.</figcaption></figure>"
        )
    plots = scale_plots(measurement.curves)
    if plots:
        figures = "".join(f"<figure>{svg}</figure>" for svg in plots.values())
        parts.append(f'<div class="plots">{figures}</div>')
    for caption, png in measurement.pictures.items():
        words = html.escape(caption)
        parts.append(
            f'<figure class="picture"><img alt="{words}" src="data:image/png;base64,{png}">'
            f"<figcaption>{words}</figcaption></figure>"
        )
    shown = [row for row in measurement.rows if not (pareto and row.id.startswith(PARETO))]
    if shown:
        parts.append(_table(shown, required))
    if pareto:
        rows = [row for row in measurement.rows if row.id.startswith(PARETO)]
        parts.append(
            f"<details><summary>Figures of the plot ({len(rows)})</summary>{_table(rows, required)}</details>"
        )
    return "".join(parts)


def write_page(
    path: Path,
    areas: Mapping[str, Measurement],
    measured_at: Mapping[str, str],
    machine: Mapping[str, str],
    wrong: Sequence[str],
    required: Required,
) -> None:
    promised = [row for m in areas.values() for row in m.rows if row.bound is not None]
    kept = sum(row.kept for row in promised)
    if wrong:
        items = "".join(f"<li>{html.escape(sentence)}</li>" for sentence in wrong)
        verdict = (
            f'<p class="verdict bad">{kept} of {len(promised)} bounds are kept. Not as promised:</p>'
            f'<ul class="wrong">{items}</ul>'
        )
    else:
        verdict = (
            f'<p class="verdict">All {len(promised)} bounds are kept, and nothing is missing.</p>'
        )
    order = [name for name in AREAS if name in areas] + [n for n in areas if n not in AREAS]
    body = "".join(_area(name, areas[name], measured_at[name], required) for name in order)
    described = "".join(
        f"<dt>{html.escape(key)}</dt><dd>{html.escape(value)}</dd>"
        for key, value in machine.items()
    )
    write_text(
        path,
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Togishi: results</title><style>{STYLE}</style><main><h1>Results</h1>"
        "<p>What Togishi promises of its speed and its accuracy, measured on this machine.</p>"
        f"{verdict}{body}<h2>Machine</h2><dl>{described}</dl></main></html>\n",
    )
