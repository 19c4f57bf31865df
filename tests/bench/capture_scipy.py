"""The per-pixel fit as one would write it with SciPy: the rival of the kernel of cpp_core/capture, on its pixels, from
its starts, with its weights and tolerances. Residuals and slopes are vectorised over the lights."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

F64 = NDArray[np.float64]
LN2 = np.log(2.0)
HUBER_SIGMA, REJECT_SIGMA = 4.0, 6.0
TOLERANCE = 2e-5
"""Of the relative change of the cost, as the kernel's."""
MOST_EVALUATIONS = 14


class Rival:
    """Pixels as `bench_capture export` writes them."""

    def __init__(self, data: dict[str, Any]) -> None:
        count = data["lights"]
        self.u, self.v, self.gain, self.diffuse = (
            np.array(data[name]) for name in ("u", "v", "gain", "diffuse")
        )
        self.value = np.array(data["value"]).reshape(-1, count)
        self.scale = np.array(data["scale"]).reshape(-1, count)
        self.starts = np.array(data["start"]).reshape(-1, 7)
        self.noise = data["noise_gain"], data["noise_floor2"], data["sigma_h_deg"]

    def model(self, x: F64) -> tuple[F64, F64]:
        """Signal under each light, and its slopes over the seven unknowns."""
        p, q, s, e1, e2, ln_chi, rho = x
        r2 = e1 * e1 + e2 * e2
        r = np.sqrt(r2)
        a = LN2 * np.exp(-2 * s)
        c = np.cosh(2 * r)
        k = np.sinh(2 * r) / r if r > 1e-6 else 2.0
        slope = (2 * c - k) / r2 if r > 1e-3 else 8 / 3
        dx, dy = self.u - p, self.v - q
        m1, m2, n2 = dx * dx - dy * dy, 2 * dx * dy, dx * dx + dy * dy
        m = e1 * m1 + e2 * m2
        e = a * (c * n2 - k * m)
        lobe = self.gain * np.exp(ln_chi - e)
        qx = a * ((c - k * e1) * dx - k * e2 * dy)
        qy = a * ((c + k * e1) * dy - k * e2 * dx)
        common = 2 * k * n2 - slope * m
        slopes = np.stack(
            [
                2 * lobe * qx,
                2 * lobe * qy,
                2 * lobe * e,
                lobe * a * (k * m1 - e1 * common),
                lobe * a * (k * m2 - e2 * common),
                lobe,
                self.diffuse,
            ],
            -1,
        )
        return lobe + rho * self.diffuse, slopes

    def weights(self, x: F64, y: F64, t: F64, most_sigma: float) -> F64:
        gain, floor2, sigma_h = self.noise
        signal, slopes = self.model(x)
        size, bright = np.abs(t), np.maximum(y, 0)
        photons = gain * size * 0.5 * (bright + np.maximum(signal, 0)) + floor2 * size * size
        lobe = slopes[:, 5]
        excused = np.where(t < 0, 1.0, np.minimum(1, 2 * bright / np.maximum(lobe, 1e-30)))
        steep = (slopes[:, 0] ** 2 + slopes[:, 1] ** 2) * excused**2
        w = np.where((size > 0) & (self.gain > 0), 1 / np.sqrt(photons + sigma_h**2 * steep), 0)
        r = (signal - y) * w
        return np.where((np.abs(r) > most_sigma) & ~((t < 0) & (r > 0)), 0, w)

    def fit(self, pixel: int) -> F64:
        y, t, x = self.value[pixel], self.scale[pixel], self.starts[pixel]
        for robust in (True, False):
            w = self.weights(x, y, t, np.inf if robust else REJECT_SIGMA)

            def residuals(x: F64, w: F64 = w) -> F64:
                r = (self.model(x)[0] - y) * w
                return np.where((t < 0) & (r > 0), 0, r)

            def slopes(x: F64, w: F64 = w) -> F64:
                signal, j = self.model(x)
                idle = (t < 0) & (signal > y)
                return j * np.where(idle, 0, w)[:, None]

            x = least_squares(
                residuals,
                x,
                slopes,
                x_scale="jac",
                loss="huber" if robust else "linear",
                f_scale=HUBER_SIGMA,
                ftol=TOLERANCE,
                xtol=1e-8,
                gtol=1e-8,
                max_nfev=MOST_EVALUATIONS,
            ).x
        return x
