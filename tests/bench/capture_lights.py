"""Photographs under many known lights: recovery of simulated pixels, a plate by Mitsuba 3, speed against SciPy, error
against effort, and a whole run from 16-bit TIFF files.

    python tests/bench/capture_lights.py --out ROWS [--pixels 3000] [--stacks 12] [--seed 1]
                                         [--only recovery mitsuba speed effort files]

The program bench_capture (built with the tests) simulates by the reference evaluation and fits; `togishi capture
lights` does the run from files.
"""

from __future__ import annotations

import base64
import io
import json
import os

# One core each, or the comparison with SciPy would be one of thread pools.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import by_mitsuba
import numpy as np
from bench_rows import (
    Measurement,
    Row,
    bench_program,
    command_line,
    median_and_spread,
    ratio_and_spread,
    togishi_command,
    write_measurement,
)
from capture_scipy import Rival
from PIL import Image

REPOSITORY = Path(__file__).resolve().parents[2]
STEPS = ("recovery", "mitsuba", "speed", "effort", "files")

LOOSE = {"mu_p50_pct": 1.2, "mu_p90_pct": 3.5, "rho_p90_deg": 2.5, "normal_p90_deg": 0.2}
TIGHT = {"mu_p50_pct": 1.0, "mu_p90_pct": 2.5, "rho_p90_deg": 1.2, "normal_p90_deg": 0.12}
# What is promised of a case: errors, flagged share, wrong ones that carry no flag.
PROMISED: dict[str, tuple[dict[str, float], float | None, float | None]] = {
    "graded.hamon": (LOOSE, 2.0, None),
    "graded.hadori": (LOOSE, 2.0, None),
    "concentrated.ji": (TIGHT, 30.0, 0.5),
}
STATED = ("dome.hamon", "concentrated.hadori")
HAZE = ("haze_1.ji", "haze_3.ji", "haze_10.ji")
CALIBRATED_TIMES = 4
END_TO_END_ROUNDS = 3
UNITS = {"pct": "%", "deg": "°"}


def bench(*arguments: object, simd: str = "") -> Any:
    done = subprocess.run(
        [str(bench_program("bench_capture")), *map(str, arguments)],
        stdout=subprocess.PIPE,
        check=True,
        env={**os.environ, **({"TOGISHI_SIMD": simd} if simd else {})},
    )
    return json.loads(done.stdout)


# --- recovery -------------------------------------------------------------------------------------


def of_case(case: dict[str, Any]) -> dict[str, float]:
    """The worse of the two half widths; the extremes of the coverage over μ, ρ, the normal and the weight."""
    mu = [case["mu_t_pct"], case["mu_b_pct"]]
    judged = [*mu, case["rho_deg"], case["normal_deg"], case["weight_pct"]]
    coverage = [errors["coverage"] for errors in judged]
    return {
        "mu_p50_pct": max(m["p50"] for m in mu),
        "mu_p90_pct": max(m["p90"] for m in mu),
        "rho_p90_deg": case["rho_deg"]["p90"],
        "normal_p90_deg": case["normal_deg"]["p90"],
        "coverage_lo": min(coverage),
        "coverage_hi": max(coverage),
    }


def recovery(pixels: int, stacks: int, seed: int) -> list[Row]:
    # What calibrated lights leave is common to all pixels of a stack: one draw a stack, however many
    # pixels it has. So there are more of these stacks, or their coverage would be a throw of few dice.
    calibrated = ["concentrated.ji", *HAZE]
    others = [name for name in (*PROMISED, *STATED, "dome.ji") if name not in calibrated]
    cases = bench("recover", pixels, seed, stacks, *others)["cases"]
    cases |= bench("recover", pixels, seed, CALIBRATED_TIMES * stacks, *calibrated)["cases"]
    rows: list[Row] = []
    how = (
        f"{stacks} stacks of {pixels} pixels ({CALIBRATED_TIMES * stacks} where the lights are calibrated), "
        f"each with lights of its own, seed {seed}"
    )

    def add(name: str, value: float, unit: str, bound: float | None, op: str = "<=") -> None:
        held = None if bound is None else op
        rows.append(Row(f"capture.{name}", value, unit, bound, held, how=how))

    for name in (*PROMISED, *STATED, *HAZE):
        case = cases[name]
        errors, flagged, wrong = PROMISED.get(name, ({}, None, None))
        for quantity, value in of_case(case).items():
            if quantity.startswith("coverage"):
                low = quantity.endswith("lo")
                add(f"{name}.{quantity}", value, "%", 60.0 if low else 90.0, ">=" if low else "<=")
            else:
                unit = UNITS[quantity.rpartition("_")[2]]
                add(f"{name}.{quantity}", value, unit, errors.get(quantity))
        add(f"{name}.flagged", case["flagged_pct"], "%", flagged)
        add(f"{name}.wrong_unflagged", case["wrong_unflagged_pct"], "%", wrong)
        print(f"{name:<22}" + "".join(f"{v:8.3g}" for v in of_case(case).values()), flush=True)
    worst = max(cases[name]["wrong_unflagged_pct"] for name in HAZE)
    add("haze.wrong_unflagged", worst, "%", 3.0)
    add("dome.ji.flagged", cases["dome.ji"]["flagged_pct"], "%", 99.0, ">=")
    left = cases["concentrated.ji"]["calibration"]
    add("calibration.before_deg", left["before_deg"], "°", None)
    add("calibration.after_deg", left["after_deg"], "°", None)
    return rows


# --- speed ----------------------------------------------------------------------------------------


def speed(pixels: int, rounds: int, seed: int) -> list[Row]:
    case = "graded.hamon"
    rival = Rival(bench("export", case, pixels, seed))
    data = bench("export", case, pixels, seed)
    truth = np.array(data["truth"]).reshape(-1, 2)
    ours, theirs, baseline, found = [], [], [], []
    chunk = max(1, pixels // rounds)
    for i in range(rounds):
        mine = bench("time", case, pixels, seed, 5)
        if mine["kernel"] == "avx2" or not ours:
            ours.append(float(np.median(mine["px_per_s"])))
        begin = time.process_time()
        for pixel in range(i * chunk, (i + 1) * chunk):
            found.append(rival.fit(pixel))
        theirs.append(chunk / (time.process_time() - begin))
        slow = bench("time", case, pixels, seed, 5, simd="baseline")
        baseline.append(float(np.median(slow["px_per_s"])))
    ratio, spread = ratio_and_spread(ours, theirs)
    rate, rate_spread = median_and_spread(ours)
    base, base_spread = median_and_spread(baseline)

    def mu_error(x: Any) -> float:
        x = np.asarray(x)
        n = len(x)
        r = np.hypot(x[:, 3], x[:, 4])
        mu = np.exp(np.stack([x[:, 2] + r, x[:, 2] - r], -1))
        return float(np.median(np.abs(mu / truth[:n] - 1)))

    own = mu_error(np.array(data["found"]).reshape(-1, 7)[: len(found)])
    both = own / mu_error(found)
    how = f"{case}, 60 lights, {pixels} pixels, {rounds} rounds in turns, CPU time of one core"
    return [
        Row("capture.px_per_s_core", rate, "px/s", 100_000.0, ">=", rate_spread, how),
        Row("capture.px_per_s_core_baseline", base, "px/s", 50_000.0, ">=", base_spread, how),
        Row("capture.ratio_scipy", ratio, "", 300.0, ">=", spread, how),
        Row("capture.mu_error_over_scipy", both, "", 1.02, "<=", None, "median error of μ, " + how),
    ]


# --- error against effort -------------------------------------------------------------------------

WAYS = {
    "moments": "moments",
    "log_linear": "log-linear",
    "full": "full fit",
    "calibrated": "full fit, lights calibrated",
}


def effort(pixels: int, seed: int) -> tuple[list[Row], str]:
    from matplotlib import pyplot, ticker

    points = bench("efforts", "graded.hadori", pixels, seed)["rows"]
    how = f"hadori, graded half vectors, two exposures, {pixels} pixels, seed {seed}"
    rows = []
    for p in points:
        name = f"capture.effort.{p['way']}.{p['lights']}"
        rows.append(Row(f"{name}.mu_p50_pct", p["mu_p50_pct"], "%", how=how))
        rows.append(Row(f"{name}.us_per_px", p["us_per_px"], "us", how=how))
    figure, axes = pyplot.subplots(figsize=(9, 5), dpi=110, layout="constrained")
    for (way, label), colour in zip(
        WAYS.items(), ("#9a9488", "#6b7f99", "#8a6a2b", "#2f6b45"), strict=True
    ):
        own = [p for p in points if p["way"] == way]
        x, y = [p["us_per_px"] for p in own], [p["mu_p50_pct"] for p in own]
        axes.plot(x, y, "o-", color=colour, label=label, markersize=5)
        for p, shift in ((own[0], (6, 4)), (own[-1], (-8, -14))):
            axes.annotate(
                f"{p['lights']} lights",
                (p["us_per_px"], p["mu_p50_pct"]),
                shift,
                textcoords="offset points",
                fontsize=8,
                color=colour,
            )
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="time of a pixel on one core, µs (without the lights' calibration, which a stack needs once)",
        ylabel="median error of the half widths, %",
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(ticker.LogLocator(subs=(1, 3)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(ticker.NullFormatter())
    axes.grid(visible=True, which="major", linewidth=0.5, color="#ddd8cc")
    axes.legend(frameon=False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    pyplot.close(figure)
    return rows, base64.b64encode(buffer.getvalue()).decode()


# --- from files -----------------------------------------------------------------------------------


def run_command(*arguments: object) -> tuple[dict[str, Any], float, float]:
    """The report (and the CPU's seconds in it), seconds, and the largest memory in GiB."""
    command = [str(togishi_command()), "--json", *map(str, arguments)]
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    report = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    spent = time.perf_counter() - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"togishi capture lights ended with exit code {process.returncode}")
    found = json.loads(report) | {"cpu_seconds": usage.ru_utime + usage.ru_stime}
    return found, spent, usage.ru_maxrss / 2**20


def write_lights(folder: Path, directions: Any, names: list[str], file: str = "stack.lp") -> Path:
    lines = [
        str(len(names)),
        *(f"{n} {x} {y} {z}" for n, (x, y, z) in zip(names, directions, strict=True)),
    ]
    path = folder / file
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def files(width: int, height: int, wide: tuple[int, int], seed: int) -> list[Row]:
    data = bench("export", "graded.single", 4096, seed)
    value = np.array(data["value"]).reshape(-1, data["lights"])
    full = value.max()
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory(dir=REPOSITORY / "build") as name:
        folder = Path(name)
        # Regions of 16 x 16 pixels of one kind each.
        kind = np.kron(
            rng.integers(0, len(value), (-(-height // 16), -(-width // 16))).astype(np.int32),
            np.ones((16, 16), np.int32),
        )[:height, :width]
        names = []
        for i in range(data["lights"]):
            noise = rng.normal(scale=2e-4, size=(height, 1)) + rng.normal(
                scale=2e-4, size=(1, width)
            )
            steps = np.clip((value[:, i] / full)[kind] + noise, 0, 1) * 65535
            names.append(f"{i:03d}.tif")
            Image.fromarray(np.round(steps).astype(np.uint16)).save(folder / names[-1])
        file = write_lights(folder, data["directions"], names)
        tilt = np.radians(12)
        options = ["--normal", np.sin(tilt), 0, np.cos(tilt), "--threads", 2]
        pixels = width * height
        rates, runs, memory = [], [], 0.0
        for _ in range(END_TO_END_ROUNDS):
            rates.append(
                2 * float(np.median(bench("time", "graded.single", 3000, seed, 5)["px_per_s"]))
            )
            report, spent, held = run_command(
                "capture", "lights", file, "-o", folder / "maps.exr", *options
            )
            runs.append(pixels / spent)
            memory = max(memory, held)
        share, spread = ratio_and_spread(100 * np.array(runs), rates)
        how = (
            f"60 uncompressed 16-bit TIFF files of {width} x {height}, 2 threads, {END_TO_END_ROUNDS} rounds in turns with "
            f"the fit alone ({np.median(rates) / 2:.0f} px/s a core); the last took {spent:.0f} s, of which "
            f"{report['seconds_reading']:.0f} s reading ({report['cpu_seconds']:.0f} s of the two CPUs)"
        )
        rows = [Row("capture.end_to_end_share", share, "%", 60.0, ">=", spread, how)]
        # 60 names of one large picture: what the memory depends on is its size.
        big = folder / "big.tif"
        ramp = np.tile(np.linspace(0, 60000, wide[0]).astype(np.uint16), (wide[1], 1))
        Image.fromarray(ramp).save(big)
        links = []
        for i in range(data["lights"]):
            links.append(f"big{i:03d}.tif")
            os.link(big, folder / links[-1])
        file = write_lights(folder, data["directions"], links)
        _, _, large = run_command(
            "capture", "lights", file, "-o", folder / "big.exr", *options, "--effort", "moments"
        )
        how = f"the most that the process held at once: 60 TIFF files of {wide[0]} x {wide[1]}"
        rows.append(Row("capture.peak_gib", max(memory, large), "GiB", 2.0, "<=", how=how))
    return rows


# --- a stranger's photographs ---------------------------------------------------------------------

PLATE = {
    "width": 80,
    "height": 60,
    "tilt_deg": 12,
    "turn_deg": 30,
    "mu_deg": [2, 6],
    "eta": 2.9,
    "k": 3.1,
}


def rendered(wanted: dict[str, Any]) -> Any:
    """What mitsuba_stack.py writes."""
    by_mitsuba.run("mitsuba_stack.py", wanted)
    return np.load(wanted["file"])


def turned(directions: Any, rms_deg: float, rng: np.random.Generator) -> Any:
    """Directions that are off by so much, rms of both components together."""
    off = rng.normal(scale=np.radians(rms_deg) / np.sqrt(2), size=directions.shape)
    off -= (off * directions).sum(-1, keepdims=True) * directions
    moved = directions + off
    return moved / np.linalg.norm(moved, axis=-1, keepdims=True)


def photographs(
    pictures: Any, folder: Path, relative: float, rng: np.random.Generator
) -> list[str]:
    """12 bits in 16-bit TIFF files, noise of 1 % at full scale and 1.2 steps; full scale is 1/relative."""
    names = []
    for i, picture in enumerate(pictures * relative):
        noise = np.sqrt(1e-4 * picture + (1.2 / 4095) ** 2) * rng.normal(size=picture.shape)
        steps = np.clip(np.round((picture + noise) * 4095), 0, 4095)
        names.append(f"{relative:g}_{i:03d}.tif")
        Image.fromarray(np.round(steps * (65535 / 4095)).astype(np.uint16)).save(folder / names[-1])
    return names


def mitsuba(seed: int) -> list[Row]:
    rng = np.random.default_rng(seed)
    light_error_deg, short = 0.5, 1 / 32
    exact = np.array(bench("export", "graded.hadori", 16, seed)["directions"])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plate = rendered({**PLATE, "file": str(folder / "plate.npz"), "lights": exact.tolist()})
        pictures = plate["pictures"]
        long = 16 * 0.9 / np.percentile(pictures.max(0), 90)
        known = turned(exact, light_error_deg, rng)
        first = photographs(pictures, folder, long, rng)
        second = photographs(pictures, folder, long * short, rng)
        tilt = np.radians(PLATE["tilt_deg"])

        def captured(directions: Any, error_deg: float) -> tuple[Any, Any, Any, list[Any]]:
            """The report, the maps, which pixels are good, and how far their half widths are off, in %."""
            stack = write_lights(folder, directions, first)
            bracket = write_lights(folder, directions, second, "short.lp")
            report, _, _ = run_command(
                *("capture", "lights", stack, "-o", folder / "maps.exr"),
                *("--bracket", f"{bracket}={short}", "--light-error", error_deg),
                *("--read-noise", 1.25 / 4095, "--normal", np.sin(tilt), 0, np.cos(tilt)),
            )
            found = rendered({"maps": str(folder / "maps.exr"), "file": str(folder / "maps.npz")})
            good = found["flags"] == 0
            shape = np.hypot(found["lobe.e1"], found["lobe.e2"])
            mu = [np.exp(found["lobe.ln_mu_deg"] + sign * shape) for sign in (1, -1)]
            off = [
                100 * np.abs(own / plate[truth] - 1)[good]
                for own, truth in zip(mu, ("mu_t_deg", "mu_b_deg"), strict=True)
            ]
            return report, found, good, off

        form = max(np.percentile(o, 50) for o in captured(exact, 0.02)[3])
        report, found, good, off = captured(known, light_error_deg)
        rho = np.degrees(0.5 * np.arctan2(found["lobe.e2"], found["lobe.e1"]))
        turn = np.abs((rho - plate["rho_deg"] + 90) % 180 - 90)[good]
        normal = np.stack([found[f"N.{axis}"] for axis in "XYZ"], -1)
        lean = np.degrees(np.arccos(np.clip(normal @ plate["normal"], -1, 1)))[good]
    how = (
        f"plate of {PLATE['width']} x {PLATE['height']} pixels, μ 2 to 6°, ρ 30°, 60 lights with graded half vectors, "
        f"two exposures, 1 % noise, 12 bits, directions {light_error_deg}° off, seed {seed}; μ is where "
        "Beckmann's D falls to its half. Our lobe is a Gaussian of the half vector's angle, Beckmann's one of its "
        "slope over cos^4, which falls faster beyond its half: two exposures weigh the flanks, so the fitted μ is "
        "smaller (the row form.mu_p50_pct: lights exact). All pixels of a flat plate see the same half vectors, so "
        "the lights' error moves their μ alike; the bound is that of pixels of our own form, with scattered normals"
    )
    errors, flagged, _ = PROMISED["graded.hadori"]
    values = {
        "mu_p50_pct": max(np.percentile(o, 50) for o in off),
        "mu_p90_pct": max(np.percentile(o, 90) for o in off),
        "rho_p90_deg": np.percentile(turn, 90),
        "normal_p90_deg": np.percentile(lean, 90),
    }
    rows = [
        Row(
            f"capture.mitsuba.{name}",
            float(value),
            UNITS[name.rpartition("_")[2]],
            errors[name],
            "<=",
            how=how,
        )
        for name, value in values.items()
    ]
    share = 100 * report["flagged"] / good.size
    wrong = 100 * float(np.mean(np.maximum(*off) > 25))
    return [
        *rows,
        Row("capture.mitsuba.form.mu_p50_pct", float(form), "%", how=how),
        Row("capture.mitsuba.flagged", share, "%", flagged, "<=", how=how),
        Row("capture.mitsuba.wrong_unflagged", wrong, "%", how=how),
    ]


def main() -> None:
    parser = command_line(__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--pixels", type=int, default=3000)
    parser.add_argument("--stacks", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", choices=STEPS, default=STEPS)
    options = parser.parse_args()
    quick = options.quick
    measurement = Measurement(machine={"cores": str(os.cpu_count())})
    if "recovery" in options.only:
        measurement.rows += recovery(
            500 if quick else options.pixels, 2 if quick else options.stacks, options.seed
        )
    if "mitsuba" in options.only:
        measurement.rows += mitsuba(options.seed)
    if "speed" in options.only:
        measurement.rows += speed(40 if quick else 500, 2 if quick else 10, options.seed)
    if "effort" in options.only:
        rows, picture = effort(300 if quick else options.pixels, options.seed)
        measurement.rows += rows
        caption = "Error of the half widths against the time of a pixel, from 12 to 120 lights"
        measurement.pictures[caption] = picture
    if "files" in options.only:
        sizes = (512, 384, (2000, 500)) if quick else (4000, 3000, (8660, 5774))
        measurement.rows += files(*sizes, options.seed)
    write_measurement(options.out, measurement)
    for row in measurement.rows:
        if row.bound is not None:
            state = "kept" if row.kept else "MISSED"
            print(f"{row.id:<44}{row.value:>12.4g} {row.unit:<5}{row.op} {row.bound:g}  {state}")


if __name__ == "__main__":
    main()
