"""`make results` must notice what is missing, changed, out of bounds or unreadable."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

BENCH = Path(__file__).resolve().parents[1] / "bench"
sys.path.insert(0, str(BENCH))

import bench_rows  # noqa: E402
import required  # noqa: E402
import results  # noqa: E402
import results_plots  # noqa: E402

REQUIRED = """
[[row]]
id = "speed.ratio"
what = "ours over theirs"
op = "<="
bound = 0.5

[[row]]
id = "speed.count"
what = "how many"
op = ">="
bound = 3

[[family]]
prefix = "speed.pareto."
what = "simplifications"
at_least = 2
"""

GOOD = [
    {
        "id": "speed.ratio",
        "value": 0.4,
        "bound": 0.5,
        "op": "<=",
        "spread": [0.38, 0.41],
        "how": "x",
    },
    {"id": "speed.count", "value": 3, "bound": 3, "op": ">=", "unit": "pieces"},
    {"id": "speed.pareto.a", "value": 1, "unit": "ns"},
    {"id": "speed.pareto.b", "value": 2, "unit": "ns", "spread": 0.1},
]


class Bench:
    """A results tool with one area, whose measuring command writes what the test wants."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.out = folder / "out"
        self.required = folder / "required.toml"
        self.required.write_text(REQUIRED)
        self.areas = {"speed": [folder / "speed.py"]}

    def command(self, name: str, body: str) -> Path:
        script = self.folder / f"{name}.py"
        script.write_text("import sys, pathlib\nout = pathlib.Path(sys.argv[2])\n" + body)
        return script

    def writes(self, rows: object, name: str = "speed") -> None:
        text = rows if isinstance(rows, str) else json.dumps({"rows": rows})
        self.command(
            name, f"out.parent.mkdir(exist_ok=True, parents=True)\nout.write_text({text!r})"
        )

    def run(self, *arguments: str) -> int:
        return results.main(
            ["--out", str(self.out), "--required", str(self.required), *arguments], self.areas
        )


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    bench = Bench(tmp_path)
    bench.writes(GOOD)
    return bench


def changed(index: int, **fields: object) -> list[dict[str, object]]:
    rows = [dict(row) for row in GOOD]
    rows[index].update(fields)
    return rows


def test_all_there_and_within_bounds_is_success(bench, capsys):
    assert bench.run() == 0
    printed = capsys.readouterr().out
    assert re.search(r"ok\s+speed\.ratio\s+0\.4\s+<= 0\.5\s+0\.38 … 0\.41", printed)
    assert "MISSED" not in printed
    page = (bench.out / "index.html").read_text()
    assert "All 2 bounds are kept" in page
    assert "http" not in page.replace("http://www.w3.org", "")


@pytest.mark.parametrize(
    "rows, sentence",
    [
        (GOOD[1:], "speed.ratio is missing"),
        (changed(0, value=0.51), r"speed.ratio = 0.51 misses its bound <= 0.5"),
        (changed(1, value=2.9), r"speed.count = 2.9 pieces misses its bound >= 3"),
        (changed(0, bound=0.6), "speed.ratio is held to <= 0.6, but what is promised is <= 0.5"),
        (changed(0, op=">="), "speed.ratio is held to >= 0.5, but"),
        (changed(0, bound=None, op=None), "speed.ratio is held to no bound, but"),
        (changed(0, value=float("nan")), "speed.ratio is nan: nothing was measured"),
        (changed(1, value=float("inf")), "speed.count is inf"),
        (changed(2, value=float("nan")), "speed.pareto.a is nan"),
        (GOOD[:3], r"speed.pareto.\* has 1 rows, at least 2"),
    ],
)
def test_what_is_not_as_promised_fails_with_a_sentence(bench, capsys, rows, sentence):
    bench.writes(rows)
    assert bench.run() == 1
    assert re.search(sentence, capsys.readouterr().out)
    assert "Not as promised" in (bench.out / "index.html").read_text()


@pytest.mark.parametrize(
    "content, sentence",
    [
        ('{"rows": [', "is not JSON"),
        ("[1, 2]", 'expected an object with a list "rows"'),
        ('{"rows": [{"id": "speed.ratio"}]}', "the field 'value' is missing"),
        ('{"rows": [{"id": "speed.ratio", "value": "0.4"}]}', "'0.4' is not a number"),
        ('{"rows": [{"id": "speed.ratio", "value": true}]}', "True is not a number"),
        ('{"rows": [{"id": "speed.x", "value": 1, "bound": 2}]}', "bound and op come together"),
        (
            '{"rows": [{"id": "speed.x", "value": 1, "bound": 2, "op": "<"}]}',
            "field op: '<'; allowed",
        ),
        ('{"rows": [{"id": "speed.x", "value": 1, "uint": "s"}]}', "unknown field 'uint'"),
        ('{"rows": [{"id": "speed.x", "value": 1, "spread": [1]}]}', r"is not \[low, high\]"),
        ('{"rows": [{"id": "other.x", "value": 1}]}', "belongs to none of the areas speed"),
        (json.dumps({"rows": [*GOOD, GOOD[0]]}), "'speed.ratio' stands there twice"),
        ('{"rows": [], "curves": {"a": {"x": [1]}}}', "curve 'a'"),
    ],
)
def test_a_file_that_cannot_be_believed_fails_with_a_sentence(bench, capsys, content, sentence):
    bench.writes(content)
    assert bench.run() == 1
    assert re.search(sentence, capsys.readouterr().out)


def test_a_command_that_fails_does_not_leave_old_figures(bench, capsys):
    assert bench.run() == 0
    bench.command("speed", "sys.exit('no GPU here')")
    assert bench.run() == 1
    printed = capsys.readouterr().out
    assert "speed.py ended with exit code 1" in printed
    assert "no GPU here" in printed
    assert "nothing of the area speed was measured" in printed
    assert not (bench.out / "speed.json").exists()


def test_a_command_that_writes_nothing_fails(bench, capsys):
    bench.command("speed", "")
    assert bench.run() == 1
    assert "speed.py wrote no rows" in capsys.readouterr().out


def test_two_commands_may_not_measure_the_same_row(bench, capsys):
    bench.writes(GOOD[:1], "again")
    bench.areas["speed"].append(bench.folder / "again.py")
    assert bench.run() == 1
    assert "'speed.ratio' was measured by two commands" in capsys.readouterr().out


def test_one_area_is_measured_and_judged_alone(bench, capsys):
    """The other area keeps its figures; a command that serves both runs once."""
    runs = bench.folder / "runs"
    both = json.dumps({"rows": [*GOOD, {"id": "size.mb", "value": 5}]})
    bench.command(
        "speed",
        f"out.parent.mkdir(exist_ok=True, parents=True)\nout.write_text({both!r})\n"
        f"open({str(runs)!r}, 'a').write('x')",
    )
    bench.required.write_text(
        REQUIRED + '\n[[row]]\nid = "size.mb"\nwhat = "m"\nop = "<="\nbound = 4\n'
    )
    bench.areas["size"] = bench.areas["speed"]
    assert bench.run() == 1  # size.mb has no bound
    assert runs.read_text() == "x"
    assert bench.run("--area", "speed") == 0
    # The page shows the other area too, and must not call it kept.
    page = (bench.out / "index.html").read_text()
    assert "nothing is missing" not in page
    assert "Not as promised" in page
    assert "size.mb" in capsys.readouterr().out
    assert json.loads((bench.out / "size.json").read_text())["rows"][0]["value"] == 5


def test_check_measures_nothing(bench):
    assert bench.run("--check") == 1
    assert bench.run() == 0
    bench.command("speed", "sys.exit(3)")
    assert bench.run("--check") == 0


def test_an_unknown_area_is_wrong_usage(bench):
    with pytest.raises(SystemExit) as ended:
        bench.run("--area", "colour")
    assert ended.value.code == 2


def test_nothing_half_written_is_left(bench):
    bench.run()
    assert not [path for path in bench.out.rglob("*") if ".part" in path.name]


def test_names_in_the_page_are_escaped(bench):
    bench.writes(changed(0, how="<script>alert(1)</script>"))
    bench.run()
    assert "<script>" not in (bench.out / "index.html").read_text()


# --- the promises themselves ----------------------------------------------------------------------

PROMISED = {
    "viewport.ratio_eevee": 0.5,
    "viewport.ratio_eevee_maps": 0.7,
    "viewport.ratio_61": 1 / 8,
    "viewport.first_picture_s": 2,
    "viewport.light_update_ms": 1,
    "bake.table_us": 100,
    "accuracy.gpu_xyz_rel": 2e-3,
    "accuracy.gpu_de00": 0.1,
    "accuracy.grid_de00": 0.1,
}


def test_the_required_file_asks_for_what_was_promised():
    found = required.read_required(BENCH / "required.toml")
    bounds = {row.id: (row.op, row.bound) for row in found.rows}
    for name, bound in PROMISED.items():
        assert bounds[name] == ("<=", bound)
    exponents = [row for row in found.rows if row.id.endswith(".exponent_lo")]
    assert {(row.op, row.bound) for row in exponents} == {("<=", 1.05)}
    assert len(exponents) >= 4
    assert any(family.prefix == "accuracy.pareto." for family in found.families)
    for row in found.rows:
        assert row.id.split(".")[0] in results.AREAS


# --- statistics -----------------------------------------------------------------------------------


@pytest.mark.parametrize("slope", [0.0, 0.6, 1.0, 2.0])
def test_exponent_finds_the_slope_and_its_interval_holds_it(slope):
    x = np.array([1, 2, 4, 8, 16, 32, 64.0])
    rng = np.random.default_rng(3)
    held = 0
    for _ in range(400):
        y = 7 * x**slope * np.exp(0.05 * rng.normal(size=7))
        found, (low, high) = bench_rows.exponent(x, y)
        assert found == pytest.approx(slope, abs=0.1)
        held += low <= slope <= high
    assert held / 400 == pytest.approx(0.95, abs=0.04)


def test_ratio_of_interleaved_frames_is_untouched_by_a_slow_minute():
    theirs = np.array([10.0] * 10 + [30.0] * 10)
    middle, (low, high) = bench_rows.ratio_and_spread(theirs * 0.4, theirs)
    assert (middle, low, high) == pytest.approx((0.4, 0.4, 0.4))


# --- plots ----------------------------------------------------------------------------------------


def pareto_rows() -> list[bench_rows.Row]:
    figures = {"table_64_half": (0.05, 3), "rgb_nk": (6.1, 12), "exact_61": (0.04, 400)}
    return [
        row
        for name, (error, time_ns) in figures.items()
        for row in (
            bench_rows.Row(f"accuracy.pareto.{name}.de00", error, "ΔE00"),
            bench_rows.Row(f"accuracy.pareto.{name}.us", time_ns / 1000, "us"),
        )
    ]


def test_the_pareto_front_holds_what_nothing_else_beats():
    points = results_plots.simplifications(pareto_rows())
    assert {p.name: p.time_ns for p in points} == pytest.approx(
        {"table 64 half": 3, "rgb nk": 12, "exact 61": 400}
    )
    assert [p.name for p in results_plots.pareto_front(points)] == ["table 64 half", "exact 61"]


def test_the_plots_label_every_point_in_the_colours_of_the_page():
    svg = results_plots.pareto_plot(pareto_rows())
    for name in ("table 64 half", "rgb nk", "exact 61"):
        assert name in svg
    assert "var(--ink)" in svg
    assert not re.search("#0[1-5]0[1-5]0[1-5]", svg)
    assert results_plots.pareto_plot([]) is None


def test_a_scale_plot_states_its_exponent():
    curve = bench_rows.Curve("lights", "ms", (1, 2, 4), (10, 11, 13), 0.19, (0.1, 0.3))
    assert "exponent 0.19" in results_plots.scale_plots({"lights": curve})["lights"]
