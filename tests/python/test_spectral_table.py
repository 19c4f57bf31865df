"""The Fresnel table against colour-science's Fresnel equations and its own promise of speed."""

import time
import warnings

import numpy as np
import pytest
import togishi_core
from hypothesis import given, settings
from hypothesis import strategies as st

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

METALS = [metal["name"] for metal in togishi_core.metals()]


def complex_fresnel(n: np.ndarray, k: np.ndarray, cos_i: float) -> np.ndarray:
    """Fresnel's equations in complex arithmetic (Born & Wolf 1.5, 14.2), unpolarised."""
    eta = n + 1j * k
    cos_t = np.sqrt(1.0 - (1.0 - cos_i**2) / eta**2)
    r_s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    r_p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return 0.5 * (np.abs(r_s) ** 2 + np.abs(r_p) ** 2)


@pytest.mark.parametrize("metal", METALS)
@pytest.mark.parametrize("light", ["D65", "A", "FL11", "LPS", "line:589.3", "blackbody:2000"])
def test_table_against_one_nanometre(metal: str, light: str) -> None:
    """The whole way by other means: complex Fresnel, colour-science's observer, 1 nm."""
    nm = np.arange(360.0, 831.0)
    n, k = togishi_core.metal_nk(metal, nm)
    power = togishi_core.light_power(light, nm)
    functions = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy()
    weights = power[:, None] * functions.align(colour.SpectralShape(360, 830, 1)).values
    weights /= weights[:, 1].sum()
    size = 33
    table = togishi_core.fresnel_table(metal, light, space="xyz", size=size)
    cosines = (np.arange(size) / (size - 1)) ** 2
    expected = np.array([complex_fresnel(n, k, c) @ weights for c in cosines])
    white = togishi_core.light_rgb("D65", space="xyz")
    assert togishi_core.delta_e00(table.astype(float), expected, white).max() <= 0.03
    assert table.dtype == np.float32
    np.testing.assert_allclose(table[0], weights.sum(axis=0), rtol=1e-6)


def test_spot_value_of_iron() -> None:
    # ((n - 1)^2 + k^2)/((n + 1)^2 + k^2) at 549 nm, a row of the table of Johnson & Christy: n 2.95, k 2.93.
    line = togishi_core.fresnel_table("iron_johnson_christy", "line:550", space="xyz", size=2)
    n, k = togishi_core.metal_nk("iron_johnson_christy", np.array([549.0, 550.0]))
    assert (n[0], k[0]) == (2.95, 2.93)
    assert pytest.approx(0.51215, abs=1e-5) == (1.95**2 + 2.93**2) / (3.95**2 + 2.93**2)
    expected = ((n[1] - 1) ** 2 + k[1] ** 2) / ((n[1] + 1) ** 2 + k[1] ** 2)
    assert line[1, 1] == pytest.approx(expected, rel=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(METALS), st.floats(400.0, 700.0), st.integers(2, 300))
def test_reflectance_stays_between_zero_and_one(metal: str, nm: float, size: int) -> None:
    light = f"line:{nm!r}"
    luminance = togishi_core.fresnel_table(metal, light, space="xyz", size=size)[:, 1]
    assert luminance[0] == pytest.approx(1.0, abs=1e-6)
    assert (luminance > 0.0).all()
    assert (luminance <= 1.0 + 1e-6).all()


def test_a_lights_new_spectrum_takes_less_than_a_millisecond(tmp_path) -> None:
    path = tmp_path / "measured.csv"
    path.write_text("".join(f"{nm},{1 + nm % 7}\n" for nm in range(380, 781)))
    togishi_core.fresnel_table(METALS[0], "D65")
    for name in ("daylight:{}", "blackbody:{}", f"csv:{path}"):
        seconds = []
        for i in range(200):
            begin = time.process_time_ns()
            togishi_core.fresnel_table(METALS[0], name.format(5000 + i))
            seconds.append(1e-9 * (time.process_time_ns() - begin))
        assert np.median(seconds) < 1e-3
