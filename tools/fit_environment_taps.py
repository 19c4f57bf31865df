"""Derives shaders/shared/area/environment_taps.glsl: an anisotropic Gaussian as a row of round ones.

    python tools/fit_environment_taps.py [--check] [FILE]

K taps along the long axis at (j - (K - 1)/2) step, weights exp(-x^2/2 tau^2) made to add up to 1, each a round Gaussian of
width s, all in units of the short axis's standard deviation. For each K and aspect the three numbers minimise the largest
error of a bright patch's reflection, a Gaussian as wide as the lobe's short axis, in shares of the reflection's peak:
smaller sources than that are better taken out of the surroundings and treated as lights. --check compares with FILE and writes nothing.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

SHADER = Path(__file__).resolve().parents[1] / "shaders/shared/area/environment_taps.glsl"
COUNTS = (3, 5, 7, 9, 13, 25)
ASPECTS = tuple(20.0 ** (i / 8) for i in range(9))
"""1 to 20, evenly in the logarithm: what the shader interpolates between."""


def error(
    parameters: np.ndarray, count: int, aspect: float, steps: int = 241, patch: float = 1.0
) -> np.ndarray:
    """(approximation - exact)/peak over a quarter of the plane: (steps along, 49 across). patch: the source's width."""
    step, tau, s = np.abs(parameters)
    at = (np.arange(count) - (count - 1) / 2) * step
    weight = np.exp(-0.5 * (at / tau) ** 2)
    weight /= weight.sum()
    long, short, tap = aspect**2 + patch**2, 1 + patch**2, s**2 + patch**2
    x = np.linspace(0, 4.5 * aspect, steps)[:, None]
    y = np.linspace(0, 4.5 * np.sqrt(short), 49)[None, :]
    row = (weight * np.exp(-0.5 * (x - at) ** 2 / tap)).sum(axis=1)[:, None] / tap
    exact = np.exp(-0.5 * x**2 / long - 0.5 * y**2 / short)
    return row * np.exp(-0.5 * y**2 / tap) * np.sqrt(long * short) - exact


def fit(count: int, aspect: float, start: np.ndarray) -> np.ndarray:
    def smooth_maximum(p: np.ndarray) -> float:
        return float(np.mean(error(p, count, aspect) ** 16) ** (1 / 16))

    def largest(p: np.ndarray) -> float:
        return float(np.abs(error(p, count, aspect)).max())

    options = {"maxiter": 1200, "xatol": 1e-6, "fatol": 1e-9}
    found = minimize(smooth_maximum, start, method="Nelder-Mead", options=options).x
    return np.abs(minimize(largest, found, method="Nelder-Mead", options=options).x)


def table() -> dict[int, list[np.ndarray]]:
    found: dict[int, list[np.ndarray]] = {}
    for count in COUNTS:
        rows: list[np.ndarray] = []
        for aspect in ASPECTS:
            # Three starts: what the last aspect gave, and rows that reach 2 and 2.5 standard deviations.
            starts = [
                np.array([max(2 * reach * aspect / (count - 1), 0.2), aspect, 1.1])
                for reach in (1.6, 2.0, 2.5)
            ]
            if rows:
                starts.append(rows[-1])
            if aspect == 1.0:
                # A round lobe is one tap: the row has no length.
                rows.append(np.array([0.0, 1.0, 1.0]))
                continue
            rows.append(
                min(
                    (fit(count, aspect, start) for start in starts),
                    key=lambda p: float(np.abs(error(p, count, aspect)).max()),
                )
            )
        found[count] = rows
    return found


def text(found: dict[int, list[np.ndarray]]) -> str:
    total = len(COUNTS) * len(ASPECTS)
    values = [row for count in COUNTS for row in found[count]]
    arrays = []
    for column, name in enumerate(("STEP", "TAU", "WIDTH")):
        lines = [
            "    " + ", ".join(f"float({row[column]:.4f})" for row in values[i : i + len(ASPECTS)])
            for i in range(0, total, len(ASPECTS))
        ]
        arrays.append(f"const float TG_TAP_{name}[{total}] = {{\n" + ",\n".join(lines) + "\n};")
    head = "| taps | " + " | ".join(f"{a:.2g}" for a in ASPECTS[1:]) + " |"
    errors = [
        f"// | {count} | "
        + " | ".join(
            f"{100 * np.abs(error(row, count, aspect, 961)).max():.2g}"
            for row, aspect in zip(found[count][1:], ASPECTS[1:], strict=True)
        )
        + " |"
        for count in COUNTS
    ]
    return "\n".join(
        [
            "// Surroundings reflected by an anisotropic lobe: a row of round taps along its long axis.",
            "// Written by tools/fit_environment_taps.py, which says what was minimised.",
            "//",
            "// Largest error of the reflection of a patch as wide as the short axis, in % of its peak, by aspect:",
            "//",
            f"// {head}",
            "// |" + "---|" * len(ASPECTS),
            *errors,
            "//",
            "// Source of the idea: McCormack et al., Feline, 1999.",
            "",
            "// One row for each of 3, 5, 7, 9, 13 and 25 taps; columns: aspect 20^(i/8), i = 0 to 8.",
            *arrays,
            "",
            "// In units of the short axis's standard deviation.",
            "struct EnvironmentTaps {",
            "    float step;   // from tap to tap",
            "    float tau;    // standard deviation of the weights",
            "    float width;  // of each tap",
            "};",
            "",
            "// count: 3, 5, 7, 9, 13 or 25 (another number: the next smaller of them). aspect: 1 to 20, else the nearer end.",
            "TG_FN EnvironmentTaps environment_taps(float aspect, int count) {",
            "    int row = count < 5 ? 0 : count < 7 ? 1 : count < 9 ? 2 : count < 13 ? 3 : count < 25 ? 4 : 5;",
            "    float x = clamp(log(max(aspect, float(1.0))) * float(8.0) / log(float(20.0)), float(0.0), float(7.9999));",
            "    int i = int(x);",
            "    float share = x - float(i);",
            f"    int at = row * {len(ASPECTS)} + i;",
            "    EnvironmentTaps taps;",
            "    taps.step = TG_TAP_STEP[at] + (TG_TAP_STEP[at + 1] - TG_TAP_STEP[at]) * share;",
            "    taps.tau = TG_TAP_TAU[at] + (TG_TAP_TAU[at + 1] - TG_TAP_TAU[at]) * share;",
            "    taps.width = TG_TAP_WIDTH[at] + (TG_TAP_WIDTH[at + 1] - TG_TAP_WIDTH[at]) * share;",
            "    return taps;",
            "}",
            "",
            "// Place of tap k of count on the long axis; the weights' sum is the caller's, who divides by it.",
            "TG_FN float environment_tap_place(EnvironmentTaps taps, int count, int k) {",
            "    return (float(k) - float(0.5) * float(count - 1)) * taps.step;",
            "}",
            "",
            "TG_FN float environment_tap_weight(EnvironmentTaps taps, float place) {",
            "    return exp(float(-0.5) * place * place / (taps.tau * taps.tau));",
            "}",
            "",
        ]
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=SHADER)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    wanted = text(table())
    if options.check:
        same = options.file.read_text(encoding="utf-8") == wanted
        print("same" if same else f"{options.file} is not what the fit gives")
        return 0 if same else 1
    options.file.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
