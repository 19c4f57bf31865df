"""Spectra and colour against colour-science and SciPy, which compute the same independently."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import togishi_core
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it warns of optional packages that are not needed here
    import colour

DATA = Path(__file__).parents[2] / "data"
METALS = [metal["name"] for metal in togishi_core.metals()]
LIGHTS = [light["name"] for light in togishi_core.lights()]
IRON = METALS[0]
OBSERVERS = {
    "cie1931_2": "CIE 1931 2 Degree Standard Observer",
    "cie1964_10": "CIE 1964 10 Degree Standard Observer",
}
VISIBLE_NM = np.arange(360.0, 831.0)


def file_columns(path: Path) -> np.ndarray:
    lines = path.read_text(encoding="utf-8").splitlines()
    return np.array([[float(f) for f in line.split(",")] for line in lines if line[0] != "#"]).T


def their_spectrum(name: str) -> colour.SpectralDistribution:
    return (
        colour.SDS_LIGHT_SOURCES[name] if name in ("HPS", "LPS") else colour.SDS_ILLUMINANTS[name]
    )


def their_xyz(nm: np.ndarray, power: np.ndarray, observer: str) -> np.ndarray:
    """By the CIE sum at 1 nm, Y = 1."""
    functions = (
        colour.MSDS_CMFS[OBSERVERS[observer]].copy().align(colour.SpectralShape(360, 830, 1))
    )
    xyz = np.interp(VISIBLE_NM, nm, power, 0.0, 0.0) @ functions.values
    return xyz / xyz[1]


def test_what_is_built_in() -> None:
    assert METALS[0] == "iron_johnson_christy"
    assert LIGHTS[0] == "D65"
    assert togishi_core.observers() == list(OBSERVERS)
    assert togishi_core.colour_spaces()[0] == "rec709"
    for entry in [*togishi_core.metals(), *togishi_core.lights()]:
        assert all(entry[key] for key in ("name", "title", "source", "licence"))
    assert togishi_core.PART_NAMES[1] == "ji"


@pytest.mark.parametrize("metal", METALS)
def test_n_and_k_are_scipys_pchip_of_the_file(metal: str) -> None:
    nm, n, k = file_columns(DATA / "metals" / f"{metal}.csv")
    at = np.concatenate([np.linspace(nm[0], nm[-1], 3001), nm])
    ours_n, ours_k = togishi_core.metal_nk(metal, at)
    np.testing.assert_allclose(ours_n, PchipInterpolator(nm, n)(at), rtol=1e-12)
    np.testing.assert_allclose(ours_k, PchipInterpolator(nm, k)(at), rtol=1e-12)


@pytest.mark.parametrize("light", LIGHTS)
def test_lights_are_those_of_colour_science(light: str) -> None:
    theirs = their_spectrum(light)
    ours = togishi_core.light_power(light, theirs.wavelengths)
    np.testing.assert_allclose(ours, theirs.values, rtol=0, atol=1e-9 * theirs.values.max())


@pytest.mark.parametrize("observer", OBSERVERS)
@pytest.mark.parametrize("light", LIGHTS)
def test_xyz_of_lights(light: str, observer: str) -> None:
    theirs = their_spectrum(light)
    expected = their_xyz(theirs.wavelengths, theirs.values, observer)
    np.testing.assert_allclose(
        togishi_core.light_rgb(light, observer, "xyz"), expected, rtol=0, atol=1e-10
    )


@pytest.mark.parametrize("cct_k", [4000, 4500.5, 5003, 6504, 7000, 7001, 10000, 25000])
def test_daylight(cct_k: float) -> None:
    xy = colour.temperature.CCT_to_xy_CIE_D(cct_k)
    theirs = colour.sd_CIE_illuminant_D_series(xy)
    nm = np.arange(330.0, 831.0, 5.0)
    ours = togishi_core.light_power(f"daylight:{cct_k}", nm)
    theirs_there = np.array([theirs[w] for w in nm])
    np.testing.assert_allclose(ours, theirs_there, rtol=1e-9)


def test_daylight_of_6504_k_is_d65() -> None:
    # To the rounding of M1 and M2 to three decimals, which the CIE prescribes.
    ours = togishi_core.light_rgb("daylight:6504", space="xyz")
    np.testing.assert_allclose(ours, togishi_core.light_rgb("D65", space="xyz"), atol=5e-4)


@pytest.mark.parametrize("kelvin", [800, 2000, 3200, 6500, 20000])
def test_blackbody(kelvin: float) -> None:
    ours = togishi_core.light_power(f"blackbody:{kelvin}", VISIBLE_NM)
    theirs = colour.colorimetry.planck_law(VISIBLE_NM * 1e-9, kelvin)
    theirs *= 100.0 / theirs[200]  # at 560 nm
    # Their second radiation constant is rounded to four digits (1.4388e-2 m K), ours is CODATA 2018.
    np.testing.assert_allclose(ours, theirs, rtol=2e-3 if kelvin < 1000 else 1e-3)


def test_blackbody_of_2856_k_is_illuminant_a() -> None:
    # A is defined as Planck's law of 2848 K with c2 = 1.435e-2 m K (CIE 015:2018).
    kelvin = 2848 * 1.438776877 / 1.435
    nm = np.arange(360.0, 781.0, 5.0)
    a = togishi_core.light_power("A", nm)
    np.testing.assert_allclose(togishi_core.light_power(f"blackbody:{kelvin!r}", nm), a, rtol=5e-6)


@pytest.mark.parametrize(
    ("space", "theirs"),
    [("rec709", "ITU-R BT.709"), ("rec2020", "ITU-R BT.2020"), ("acescg", "ACEScg")],
)
def test_matrices(space: str, theirs: str) -> None:
    derived = colour.RGB_COLOURSPACES[theirs].copy()
    derived.use_derived_transformation_matrices(True)
    np.testing.assert_allclose(
        togishi_core.xyz_to_rgb(space), derived.matrix_XYZ_to_RGB, rtol=0, atol=1e-6
    )


def test_acescg_of_blender_shows_d65_as_white() -> None:
    d65 = colour.xy_to_XYZ([0.3127, 0.3290])
    np.testing.assert_allclose(togishi_core.xyz_to_rgb("acescg_d65") @ d65, 1.0, atol=1e-12)
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        d65, colour.xy_to_XYZ([0.32168, 0.33767]), transform="Bradford"
    )
    np.testing.assert_allclose(
        togishi_core.xyz_to_rgb("acescg_d65"), togishi_core.xyz_to_rgb("acescg") @ adapt, atol=1e-9
    )


@pytest.mark.parametrize(("name", "theirs"), [("bradford", "Bradford"), ("cat16", "CAT16")])
def test_adaptation(name: str, theirs: str) -> None:
    # Adapted under A, a table must be the unadapted one times colour-science's matrix.
    a = togishi_core.light_rgb("A", space="xyz")
    d65 = colour.xy_to_XYZ([0.3127, 0.3290])
    matrix = colour.adaptation.matrix_chromatic_adaptation_VonKries(a, d65, transform=theirs)
    plain = togishi_core.fresnel_table(METALS[3], "A", space="xyz")
    adapted = togishi_core.fresnel_table(METALS[3], "A", space="rec709", adaptation=name)
    expected = plain @ (togishi_core.xyz_to_rgb("rec709") @ matrix).T
    np.testing.assert_allclose(adapted, expected, atol=2e-6)


@pytest.mark.parametrize(("name", "theirs"), [("bradford", "Bradford"), ("cat16", "CAT16")])
def test_one_white_for_a_room(name: str, theirs: str) -> None:
    # Under lamps of 3200 K, whoever is adapted to them sees daylight blue, as colour-science has it.
    whites = [togishi_core.light_rgb(n, space="xyz") for n in ("blackbody:3200", "D65")]
    d65 = colour.xy_to_XYZ([0.3127, 0.3290])
    matrix = colour.adaptation.matrix_chromatic_adaptation_VonKries(
        whites[0], d65, transform=theirs
    )
    adapt = togishi_core.adapt_rgb("blackbody:3200", adaptation=name)
    expected = np.array(whites) @ (togishi_core.xyz_to_rgb("rec709") @ matrix).T
    plain = np.array([togishi_core.light_rgb(n) for n in ("blackbody:3200", "D65")])
    np.testing.assert_allclose(plain @ adapt.T, expected, atol=2e-6)
    np.testing.assert_allclose(plain[0] @ adapt.T, 1.0, atol=1e-3)
    np.testing.assert_allclose(
        togishi_core.adapt_rgb("D50", adaptation="none"), np.eye(3), atol=1e-12
    )


def test_a_line_is_no_white_to_bradford() -> None:
    with pytest.raises(togishi_core.InputError, match="white"):
        togishi_core.adapt_rgb("LPS", adaptation="bradford")


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(*[st.floats(0.0, 1.2)] * 6), min_size=1, max_size=20))
def test_ciede2000(rows: list[tuple[float, ...]]) -> None:
    xy = np.array([0.3127, 0.3290])
    xyz = np.array(rows)
    ours = togishi_core.delta_e00(xyz[:, :3], xyz[:, 3:], colour.xy_to_XYZ(xy))
    theirs = colour.delta_E(
        colour.XYZ_to_Lab(xyz[:, :3], xy), colour.XYZ_to_Lab(xyz[:, 3:], xy), method="CIE 2000"
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


def test_ciede2000_refuses_other_shapes() -> None:
    with pytest.raises(togishi_core.InputError, match="rows"):
        togishi_core.delta_e00(np.zeros((2, 3)), np.zeros((3, 3)), np.ones(3))
    with pytest.raises(togishi_core.InputError, match="shape"):
        togishi_core.delta_e00(np.zeros(3), np.zeros(3), np.ones(3))
    with pytest.raises(togishi_core.InputError, match="white_xyz"):
        togishi_core.delta_e00(np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(3))
    assert togishi_core.delta_e00(np.zeros((0, 3)), np.zeros((0, 3)), np.ones(3)).shape == (0,)


def test_a_users_spectrum(tmp_path: Path) -> None:
    nm = np.linspace(350.0, 850.0, 913)
    power = 2.0 + np.sin(nm / 31.0) + np.exp(-0.5 * ((nm - 611.0) / 4.0) ** 2)
    path = tmp_path / "lamp.csv"
    path.write_text("nm;W\n" + "".join(f"{a};{b}\n" for a, b in zip(nm, power, strict=True)))
    ours = togishi_core.light_rgb(f"csv:{path}", space="xyz")
    np.testing.assert_allclose(ours, their_xyz(nm, power, "cie1931_2"), rtol=1e-4)
    notes = togishi_core.light_notes(f"csv:{path}")
    assert any("column titles" in note for note in notes)
    assert any("closer than 1 nm" in note for note in notes)
    assert togishi_core.light_notes("D65") == []


def test_bad_input_says_what_is_allowed(tmp_path: Path) -> None:
    path = tmp_path / "falling.csv"
    path.write_text("500,1\n400,1\n")
    for call, words in [
        (lambda: togishi_core.metal_nk("tin", np.array([500.0])), "iron_johnson_christy"),
        (lambda: togishi_core.metal_nk(IRON, np.array([[500.0]])), "one dimension"),
        (lambda: togishi_core.metal_nk(IRON, np.array([np.nan])), "element 0"),
        (lambda: togishi_core.metal_nk(IRON, np.array([3000.0])), "188"),
        (lambda: togishi_core.light_power("D65", np.array([500.0, 400.0])), "increasing"),
        (lambda: togishi_core.light_rgb("D65", "cie2006"), "cie1931_2"),
        (lambda: togishi_core.light_rgb("D65", space="srgb"), "rec709"),
        (lambda: togishi_core.light_rgb("D65", adaptation="cat02"), "bradford"),
        (lambda: togishi_core.light_rgb(f"csv:{path}"), "line 2"),
        (lambda: togishi_core.light_rgb(f"csv:{tmp_path}"), "folder"),
    ]:
        with pytest.raises(togishi_core.InputError, match=words):
            call()


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=400))
def test_any_bytes_as_a_file_are_read_or_refused(tmp_path_factory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    try:
        xyz = togishi_core.light_rgb(f"csv:{path}", space="xyz")
    except togishi_core.InputError as error:
        assert "any.csv" in str(error)
    else:
        assert np.isfinite(xyz).all()
        assert xyz[1] == pytest.approx(1.0)


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(1.0, 1200.0), st.floats(0.0, 1e60)),
        min_size=1,
        max_size=30,
        unique_by=lambda row: row[0],
    )
)
def test_any_spectrum_gives_a_finite_white_of_luminance_one(tmp_path_factory, rows) -> None:
    path = tmp_path_factory.getbasetemp() / "some.csv"
    path.write_text("".join(f"{nm!r},{power!r}\n" for nm, power in sorted(rows)))
    try:
        table = togishi_core.fresnel_table(IRON, f"csv:{path}", space="xyz")
    except togishi_core.InputError:
        return
    assert np.isfinite(table).all()
    assert table[0, 1] == pytest.approx(1.0, abs=1e-6)
    assert (np.diff(table[[0, -1], 1]) < 0).all()
