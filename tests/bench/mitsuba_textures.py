"""Textures of a rough conductor, for the scripts that run in .venv-mitsuba."""

from __future__ import annotations

from typing import Any

import mitsuba
import numpy as np


def texture(values: np.ndarray) -> dict[str, Any]:
    """(H, W) as they are."""
    return {
        "type": "bitmap",
        "bitmap": mitsuba.Bitmap(np.ascontiguousarray(values[..., None], np.float32)),
        "raw": True,
        "wrap_mode": "clamp",
    }


def alpha(ln_mu_deg: np.ndarray) -> np.ndarray:
    """Beckmann's alpha of a half width: tan(mu)/sqrt(ln 2)."""
    return np.tan(np.radians(np.exp(ln_mu_deg))) / np.sqrt(np.log(2.0))
