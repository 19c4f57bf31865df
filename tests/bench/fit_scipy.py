"""The rival of the goniometer fit: the same least squares of an isotropic ji by scipy.optimize.least_squares.

Residuals of all readings in one vectorised numpy evaluation (550 nm, one turn of the sample), the terms that the core
fits for such a set: chi, mu, tilt in the plane of incidence, pedestal, a gain for each scan with its prior. The
starts and the relative tolerance of 1e-9 are the core's: the curves' own half width, and 0.7, 1.4, 1, 0.4 and 2.5 times
it. Written for the comparison alone; nothing else uses it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

F64 = NDArray[np.float64]
WIDENED = (1.0, 0.7, 1.4, 1.0, 0.4, 2.5)
GAIN_PRIOR = 0.01
TILT_PRIOR_DEG = 1.0
ROUGH = {"x_scale": "jac", "ftol": 1e-4, "xtol": 1e-4, "gtol": 1e-12}
FINE = {"x_scale": "jac", "ftol": 1e-9, "xtol": 1e-9, "gtol": 1e-12}
SHARED = 4  # ln chi, ln mu_deg, tilt (deg), pedestal; then ln gain of each scan


def disc_nodes(source_deg: float, detector_deg: float, rings: int) -> F64:
    """(K, 3): displacements of the line of sight along and across, in rad, and shares: Gauss quadrature of the radius of
    the sum of two displacements, each even over its disc (the moments by a fine grid)."""
    a, b = np.radians([source_deg / 2, detector_deg / 2])
    grid = (np.arange(400) + 0.5) / 400 * 2 - 1
    x, y = np.meshgrid(grid, grid)
    inside = x**2 + y**2 < 1
    first = np.stack([x[inside], y[inside]], axis=1)
    # Moments of s = r^2 of the sum: every tenth point of one disc against some of the other.
    one, two = first[::97] * a, first[::89] * b
    s = (
        (one[:, None, 0] + two[None, :, 0]) ** 2 + (one[:, None, 1] + two[None, :, 1]) ** 2
    ).reshape(-1) / (a + b) ** 2
    diagonal, off = [], []
    before, now, norm_before = np.zeros_like(s), np.ones_like(s), 1.0
    for k in range(rings):
        norm = float((now**2).sum())
        alpha = float((now**2 * s).sum() / norm)
        beta = norm / norm_before if k else 0.0
        diagonal.append(alpha)
        if k:
            off.append(np.sqrt(beta))
        before, now, norm_before = now, (s - alpha) * now - beta * before, norm
    values, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off, 1) + np.diag(off, -1))
    nodes = []
    for ring, (value, vector) in enumerate(zip(values, vectors.T, strict=True)):
        around = 4 * rings
        angle = 2 * np.pi * (np.arange(around) + 0.5 * (ring % 2)) / around
        radius = (a + b) * np.sqrt(max(value, 0.0))
        nodes.append(
            np.stack(
                [
                    radius * np.cos(angle),
                    radius * np.sin(angle),
                    np.full(around, vector[0] ** 2 / around),
                ],
                axis=1,
            )
        )
    return np.concatenate(nodes)


def fresnel(n: float, k: float, cosine: F64) -> F64:
    """Unpolarised reflectance of a conductor."""
    refracted = np.sqrt((n + 1j * k) ** 2 - (1 - cosine**2))
    s = (cosine - refracted) / (cosine + refracted)
    index2 = (n + 1j * k) ** 2
    p = (index2 * cosine - refracted) / (index2 * cosine + refracted)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


class Rival:
    """The least squares of one set of scans with stated sigma."""

    def __init__(self, scans: list[dict[str, Any]], n: float, k: float, rings: int = 2) -> None:
        self.n, self.k = n, k
        self.scan = np.concatenate([np.full(len(s["receive_deg"]), i) for i, s in enumerate(scans)])
        self.incidence = np.radians([s["incidence_deg"] for s in scans])
        self.receive = np.radians(np.concatenate([s["receive_deg"] for s in scans]))
        self.measured = np.concatenate([s["intensity"][:, 0] for s in scans])
        self.sigma = np.concatenate([s["sigma"][:, 0] for s in scans])
        # The core's order: readings over the largest of them.
        self.scale = float(self.measured.max())
        self.measured, self.sigma = self.measured / self.scale, self.sigma / self.scale
        self.nodes = disc_nodes(
            scans[0]["source_aperture_deg"], scans[0]["detector_aperture_deg"], rings
        )
        self.light = np.stack(
            [-np.sin(self.incidence), np.zeros(len(scans)), np.cos(self.incidence)], axis=1
        )
        self.scans = scans

    def views(self, rows: Any) -> F64:
        """(N, K, 3) to the detector: the stated direction, moved by each node."""
        receive = self.receive[rows]
        sine, cosine, zero = np.sin(receive), np.cos(receive), np.zeros_like(receive)
        stated = np.stack([sine, zero, cosine], axis=1)[:, None]
        along = np.stack([cosine, zero, -sine], axis=1)[:, None]
        view = stated + along * self.nodes[None, :, :1]
        view = view + np.array([0.0, 1.0, 0.0]) * self.nodes[None, :, 1:2]
        return view / np.linalg.norm(view, axis=2, keepdims=True)

    def residuals_of(self, rows: Any) -> Any:
        """The residuals as a function of the parameters, for some of the readings."""
        scan, measured, sigma = self.scan[rows], self.measured[rows], self.sigma[rows]
        half = self.views(rows) + self.light[scan][:, None]
        half /= np.linalg.norm(half, axis=2, keepdims=True)
        shares = self.nodes[:, 2]

        def residuals(p: F64) -> F64:
            tilt, mu = np.radians(p[2]), np.radians(np.exp(p[1]))
            normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
            up = half @ normal
            aside = np.linalg.norm(half - up[..., None] * normal, axis=2)
            lobe = np.exp(-np.log(2.0) * (np.arctan2(aside, up) / mu) ** 2) @ shares
            reflected = fresnel(self.n, self.k, self.light @ normal)
            gain = np.exp(p[SHARED:])
            modelled = gain[scan] * (np.exp(p[0]) * reflected[scan] * lobe + p[3])
            return np.concatenate(
                [
                    (measured - modelled) / sigma,
                    p[SHARED:] / GAIN_PRIOR,
                    [p[2] / TILT_PRIOR_DEG],
                ]
            )

        return residuals

    def half_widths_deg(self) -> F64:
        """Half width of the facet angle of each curve, as read off it."""
        widths = []
        for index, scan in enumerate(self.scans):
            rows = self.scan == index
            value, angle = self.measured[rows], self.receive[rows]
            above = angle[value > 0.5 * value.max()]
            blur = np.hypot(scan["source_aperture_deg"], scan["detector_aperture_deg"]) / 8 * 1.1774
            seen = np.degrees(np.ptp(above)) / 4
            widths.append(np.sqrt(max(seen**2 - blur**2, 0.04 * seen**2)))
        return np.array(widths)

    def starts(self) -> list[F64]:
        middle = float(np.median(self.half_widths_deg()))
        reflected = fresnel(self.n, self.k, self.light[:, 2]).mean()
        made = []
        for widen in WIDENED:
            start = np.zeros(SHARED + len(self.scans))
            start[1] = np.log(middle * widen)
            start[3] = np.percentile(self.measured, 5)
            start[0] = np.log(max(1 - start[3], 1e-3) / reflected)
            made.append(start)
        return made

    def fit(self, staged: bool) -> tuple[F64, float]:
        """Parameters and chi2 of the best. staged: in the core's own order, first all starts roughly on every n-th
        reading, so that some 500 are left, then the best of them on all; else each start on all readings."""
        every = self.residuals_of(slice(None))
        if not staged:
            all_found = [least_squares(every, start, **FINE) for start in self.starts()]
            best = min(all_found, key=lambda found: found.cost)
        else:
            few = self.residuals_of(slice(None, None, max(1, -(-len(self.measured) // 500))))
            rough = [least_squares(few, start, **ROUGH) for start in self.starts()]
            best = least_squares(every, min(rough, key=lambda found: found.cost).x, **FINE)
        return best.x, 2 * float(best.cost)

    def chi2_of(self, record: dict[str, Any], gains: list[float]) -> float:
        """chi2, priors included, of what the core found, by this evaluation."""
        value = {entry["name"]: entry["value"] for entry in record["parameter"]}
        p = np.concatenate(
            [
                [
                    np.log(value["chi"] / self.scale),
                    np.log(value["mu_t_deg"]),
                    value["tilt_t_deg"],
                    value["pedestal_550nm"] / self.scale,
                ],
                np.log(gains),
            ]
        )
        return float((self.residuals_of(slice(None))(p) ** 2).sum())
