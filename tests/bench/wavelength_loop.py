"""What the 61-wavelength variant of the steel shader (TG_BENCH_61) reads: n, k and the lights' colours per wavelength."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import togishi_core
from togishi.core.shader_source import WAVELENGTH_ROWS, WAVELENGTHS

OBSERVERS = Path(__file__).resolve().parents[2] / "data/observers"
WAVELENGTHS_NM = np.linspace(400.0, 700.0, WAVELENGTHS)


def observer_at(wavelengths_nm: np.ndarray, name: str = "cie1931_2") -> np.ndarray:
    """(N, 3) colour-matching values."""
    table = np.loadtxt(OBSERVERS / f"{name}.csv", delimiter=",", comments="#")
    return np.column_stack([np.interp(wavelengths_nm, table[:, 0], table[:, i]) for i in (1, 2, 3)])


def wavelengths_block(metal: str, spectra: Sequence[str], space: str = "rec709") -> np.ndarray:
    """TgWavelengths (shaders/viewport/interface.glsl) as float32 rows of four."""
    assert len(spectra) <= WAVELENGTH_ROWS
    block = np.zeros((WAVELENGTHS * (1 + WAVELENGTH_ROWS), 4), np.float32)
    block[:WAVELENGTHS, 0], block[:WAVELENGTHS, 1] = togishi_core.metal_nk(metal, WAVELENGTHS_NM)
    observer = observer_at(WAVELENGTHS_NM)
    for row, spectrum in enumerate(spectra):
        xyz = togishi_core.light_power(spectrum, WAVELENGTHS_NM)[:, None] * observer
        # The white correction: the sum is the light's own colour.
        xyz *= togishi_core.light_rgb(spectrum, space="xyz") / xyz.sum(axis=0)
        first = WAVELENGTHS * (1 + row)
        block[first : first + WAVELENGTHS, :3] = xyz @ togishi_core.xyz_to_rgb(space).T
    return block
