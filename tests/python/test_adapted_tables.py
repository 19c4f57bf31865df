"""The add-on's tables for an eye that is adapted to one light of the room."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import togishi_core

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon"))

from togishi.core.scene_data import ColourSettings
from togishi.core.tables import Tables


def test_every_row_is_adapted_by_the_same_matrix() -> None:
    plain, adapted = ColourSettings(), ColourSettings(adaptation="cat16", white="A")
    matrix = togishi_core.adapt_rgb("A")
    tables = Tables()
    for metal in ("", togishi_core.metals()[0]["name"]):
        for spectrum in ("A", "D65", "LPS"):
            (row,) = tables.rows(metal, [spectrum], plain)
            (seen,) = tables.rows(metal, [spectrum], adapted)
            assert seen.dtype == np.float32 and seen.flags.c_contiguous
            np.testing.assert_allclose(seen, row @ matrix.T, atol=1e-6)
    np.testing.assert_allclose(tables.light_rgb("A", adapted), 1.0, atol=2e-3)
    daylight = tables.light_rgb("D65", adapted)
    assert daylight[2] > 1.5 * daylight[0], "daylight is blue to whom lamps are white"
    assert not tables.problems


def test_a_light_that_is_no_white_is_told_and_changes_nothing() -> None:
    tables = Tables()
    sodium = ColourSettings(adaptation="bradford", white="LPS")
    (seen,) = tables.rows("", ["D65"], sodium)
    (plain,) = tables.rows("", ["D65"], ColourSettings())
    np.testing.assert_array_equal(seen, plain)
    assert "white of the light" in tables.problems["LPS"]
