"""Where in a pixel the samples of a picture lie: always the same points, so renders repeat exactly."""

from __future__ import annotations

import numpy as np

from .scene_data import F64

# Steps of the R2 sequence (Roberts 2018): powers of the plastic number's inverse.
_STEP = (0.7548776662466927, 0.5698402909980532)


def _blackman_harris_inverse(u: F64, width: float) -> F64:
    """Offsets in pixels distributed as Blackman-Harris' window of `width` pixels, Cycles' and EEVEE's filter."""
    x = np.linspace(-0.5, 0.5, 513)
    angle = 2.0 * np.pi * (x + 0.5)
    window = (
        0.35875
        - 0.48829 * np.cos(angle)
        + 0.14128 * np.cos(2 * angle)
        - 0.01168 * np.cos(3 * angle)
    )
    cdf = np.concatenate([[0.0], np.cumsum(0.5 * (window[1:] + window[:-1]))])
    result: F64 = np.interp(u, cdf / cdf[-1], x) * width
    return result


def pixel_offsets(samples: int, filter_width: float = 1.5) -> F64:
    """(samples, 2) offsets in pixels from the pixel's centre; one sample lies in the centre.

    filter_width: of Blender's pixel filter, in pixels; below 0.02 all samples lie in the centre.
    """
    if samples <= 1:
        return np.zeros((max(samples, 1), 2))
    k = np.arange(samples, dtype=np.float64)[:, None]
    u = np.mod(0.5 + k * np.asarray(_STEP), 1.0)
    # Evenly spread in each axis whatever the number of samples is.
    ranks = np.argsort(np.argsort(u, axis=0, kind="stable"), axis=0, kind="stable")
    return _blackman_harris_inverse((ranks + 0.5) / samples, max(filter_width, 0.02))
