"""Goniometer scans of a rough metal by Mitsuba 3, as a stranger would send them: tests/bench/fit.py fits them.

Runs in .venv-mitsuba, with nothing of Togishi. Reads from standard input

    {"nm": [450, 550, 650], "eta": [...], "k": [...], "cases": [{"file": "PATH", "mu_t_deg": 2, "mu_b_deg": 1.2,
     "rho_deg": 30}]}

and writes each file: protocol (a), radiance, exact values beside the standard deviation that an instrument of 0.5 %
of the signal and 0.02 % of the peak would state. Source: the plugin `roughconductor` with Beckmann's distribution,
alpha = tan(mu)/sqrt(ln 2) along each axis, where D falls to its half at mu but for the factor 1/cos^4.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mitsuba
import numpy as np

INCIDENCE_DEG = 45.0
RECEIVE_DEG = np.round(np.arange(25.0, 65.0 + 0.1, 0.2), 6)
TURNS_DEG = (0.0, 45.0, 135.0, 180.0)


def variant() -> str:
    """Double precision where this build has it."""
    wanted = ("scalar_spectral_double", "scalar_spectral")
    return next(name for name in wanted if name in mitsuba.variants())


def directions(turn_deg: float, rho_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """(3,) to the light and (N, 3) to the detector, in the frame whose x is the lobe's wide axis. The sample's T lies
    at the azimuth turn, counter-clockwise, and its wide axis at rho from T."""
    incidence, receive = np.radians(INCIDENCE_DEG), np.radians(RECEIVE_DEG)
    light = np.array([-np.sin(incidence), 0.0, np.cos(incidence)])
    detector = np.stack([np.sin(receive), np.zeros_like(receive), np.cos(receive)], axis=1)
    angle = np.radians(turn_deg + rho_deg)
    back = np.array(
        [[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    return back @ light, detector @ back.T


def spectrum(nm: list[float], values: list[float]) -> dict[str, Any]:
    return {
        "type": "irregular",
        "wavelengths": ", ".join(str(value) for value in nm),
        "values": ", ".join(repr(value) for value in values),
    }


def radiance(bsdf: Any, light: np.ndarray, detector: np.ndarray, nm: list[float]) -> np.ndarray:
    """(N, C) L/E. Mitsuba's eval is f cos(theta_o) = L cos(theta_o)/(E cos(theta_i)), in four wavelengths at once."""
    context = mitsuba.BSDFContext()
    point = mitsuba.SurfaceInteraction3f()
    point.wi = mitsuba.Vector3f([float(value) for value in light])
    point.wavelengths = [*nm, *[nm[-1]] * (4 - len(nm))]
    values = np.empty((len(detector), len(nm)))
    for row, to in enumerate(detector):
        evaluated = bsdf.eval(context, point, mitsuba.Vector3f([float(value) for value in to]))
        values[row] = np.array(evaluated, float).reshape(-1)[: len(nm)] * light[2] / to[2]
    return values


def write_case(case: dict[str, Any], optics: dict[str, Any]) -> None:
    alpha = [
        float(np.tan(np.radians(case[name])) / np.sqrt(np.log(2.0)))
        for name in ("mu_t_deg", "mu_b_deg")
    ]
    bsdf = mitsuba.load_dict(
        {
            "type": "roughconductor",
            "distribution": "beckmann",
            "alpha_u": alpha[0],
            "alpha_v": alpha[1],
            "eta": spectrum(optics["nm"], optics["eta"]),
            "k": spectrum(optics["nm"], optics["k"]),
        }
    )
    scans = [radiance(bsdf, *directions(turn, case["rho_deg"]), optics["nm"]) for turn in TURNS_DEG]
    floor = 2e-4 * max(scan.max() for scan in scans)
    titles = [f"{nm:g}nm" for nm in optics["nm"]]
    lines = [
        "# format: togishi-scan 1",
        "# part: hamon",
        "# quantity: radiance",
        "# calibration: absolute",
        "# unit: 1/sr",
        "# source_aperture_deg: 0",
        "# detector_aperture_deg: 0",
        "# turn_sense: counter-clockwise",
        f"# metal: {optics['metal']}",
        f"# instrument: Mitsuba {mitsuba.__version__}, {mitsuba.variant()}",
        ";".join(
            ["incidence_deg", "receive_deg", "turn_deg"]
            + [f"intensity_{title}" for title in titles]
            + [f"sigma_{title}" for title in titles]
        ),
    ]
    for turn, scan in zip(TURNS_DEG, scans, strict=True):
        sigma = np.hypot(5e-3 * scan, floor)
        lines += [
            ";".join(f"{value:.9g}" for value in (INCIDENCE_DEG, receive, turn, *row, *spread))
            for receive, row, spread in zip(RECEIVE_DEG, scan, sigma, strict=True)
        ]
    Path(case["file"]).write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> int:
    wanted = json.load(sys.stdin)
    mitsuba.set_variant(variant())
    for case in wanted["cases"]:
        write_case(case, wanted)
    return 0


if __name__ == "__main__":
    sys.exit(main())
