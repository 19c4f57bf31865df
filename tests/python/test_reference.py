"""The double-precision reference against the design's formulas written once more in numpy, and against limits."""

from __future__ import annotations

import time

import numpy as np
import pytest
import togishi_core as core

IRON = "iron_johnson_christy"
WAVELENGTHS_NM = np.arange(400.0, 701.0, 5.0)


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def polar(theta_deg, azimuth_deg):
    t, a = np.radians(theta_deg), np.radians(azimuth_deg)
    return np.array([np.sin(t) * np.cos(a), np.sin(t) * np.sin(a), np.cos(t)])


def complex_fresnel(n, k, cosine):
    """Born & Wolf in complex numbers; (W,) for one cosine."""
    index = n + 1j * k
    inside = np.sqrt(index**2 - (1.0 - cosine**2))
    r_s = (cosine - inside) / (cosine + inside)
    r_p = (index**2 * cosine - inside) / (index**2 * cosine + inside)
    return 0.5 * (np.abs(r_s) ** 2 + np.abs(r_p) ** 2)


def evaluate(**changes):
    """One point facing +Z, one light; changes replace the defaults."""
    arguments = {
        "metal": IRON,
        "lights": ["D65"],
        "light_of": np.zeros(1, np.int32),
        "normal": np.array([[0.0, 0.0, 1.0]]),
        "tangent": np.array([[1.0, 0.0, 0.0]]),
        "view": polar(40, 0)[None],
        "light_direction": polar(43, 175)[None, None],
        "irradiance": np.ones((1, 1)),
        "lobe_ji": core.encode_lobe(np.array(2.0), np.array(1.0), np.array(30.0)).astype(float),
        "lobe_hadori": core.encode_lobe(np.array(3.0), np.array(3.0), np.array(0.0)).astype(float),
        "lobe_ha": core.encode_lobe(np.array(6.0), np.array(5.0), np.array(80.0)).astype(float),
        "w": np.array([0.3]),
        "h": np.array([0.4]),
    }
    arguments.update(changes)
    return core.reference_xyz(**arguments)


def numpy_radiance(normal, tangent, view, light, lobes_deg, w, h, chi=-1.0, betas=(-1.0, -1.0)):
    """Radiance per wavelength by the design's section 1, word by word. lobes_deg: ji, hadori, ha as (mu_t, mu_b, rho)."""
    normal, view, light = unit(normal), unit(view), unit(light)
    tangent = unit(tangent - normal * (normal @ tangent))
    bitangent = np.cross(normal, tangent)
    half = unit(light + view)
    phi = np.arctan2(np.linalg.norm(np.cross(normal, half)), normal @ half)
    azimuth = np.arctan2(half @ bitangent, half @ tangent)
    shadowing = min(
        1.0,
        2 * (normal @ half) * (normal @ view) / (view @ half),
        2 * (normal @ half) * (normal @ light) / (view @ half),
    )
    n, k = core.metal_nk(IRON, WAVELENGTHS_NM)
    f_i = complex_fresnel(n, k, normal @ light)
    f_h = complex_fresnel(n, k, light @ half)

    def lobe(axes):
        mu_t, mu_b, rho = np.radians(axes)
        psi = azimuth - rho
        d = np.exp(-np.log(2) * phi**2 * (np.cos(psi) ** 2 / mu_t**2 + np.sin(psi) ** 2 / mu_b**2))
        return d, np.log(2) / (4 * np.pi * mu_t * mu_b)

    over_cos = shadowing / (normal @ view)
    d, norm = lobe(lobes_deg[0])
    c_f = d * f_i * (norm * over_cos if chi < 0 else chi)
    d, norm = lobe(lobes_deg[1])
    c_hadori = d * f_h * over_cos * (norm if betas[0] < 0 else betas[0])
    d, norm = lobe(lobes_deg[2])
    c_ha = d * f_h * over_cos * (norm if betas[1] < 0 else betas[1])
    return (1 - w) * ((1 - h) * c_f + h * c_hadori) + w * c_ha


LOBES_DEG = ((2.0, 1.0, 30.0), (3.0, 3.0, 0.0), (6.0, 5.0, 80.0))


@pytest.mark.parametrize("weights", [(-1.0, -1.0, -1.0), (30.0, 20.0, 7.0)])
def test_against_numpy_for_single_wavelengths(weights):
    """Under a spectral line on a sample, XYZ is the line's own XYZ times the radiance at that wavelength."""
    rng = np.random.default_rng(1)
    chi, beta_hadori, beta_ha = weights
    for _ in range(40):
        normal = unit(rng.normal(size=3))
        tangent = rng.normal(size=3) * 7.0
        side = unit(np.cross(normal, rng.normal(size=3)))
        angle = np.radians(rng.uniform(0, 85))
        view = np.cos(angle) * normal + np.sin(angle) * side
        mirror = 2 * (normal @ view) * normal - view
        light = unit(mirror + 0.15 * rng.normal(size=3))
        if normal @ light < 0.01:
            continue
        w, h = rng.uniform(size=2)
        expected = numpy_radiance(
            normal, tangent, view, light, LOBES_DEG, w, h, chi, (beta_hadori, beta_ha)
        )
        for i in (0, 20, 31, 60):
            nm = WAVELENGTHS_NM[i]
            spectrum = f"line:{nm:g}"
            own = core.light_rgb(spectrum, space="xyz")
            got = evaluate(
                lights=[spectrum],
                normal=3.0 * normal[None],
                tangent=tangent[None],
                view=0.2 * view[None],
                light_direction=5.0 * light[None, None],
                irradiance=np.array([[2.5]]),
                lobe_ji=exact_lobe(LOBES_DEG[0]),
                lobe_hadori=exact_lobe(LOBES_DEG[1]),
                lobe_ha=exact_lobe(LOBES_DEG[2]),
                w=np.array([w]),
                h=np.array([h]),
                chi=chi,
                beta_hadori=beta_hadori,
                beta_ha=beta_ha,
            )
            np.testing.assert_allclose(got[0], 2.5 * expected[i] * own, rtol=1e-9, atol=1e-14)


def exact_lobe(axes):
    mu_t, mu_b, rho = axes
    r = 0.5 * np.log(mu_t / mu_b)
    two_rho = np.radians(2 * rho)
    return np.array([0.5 * np.log(mu_t * mu_b), r * np.cos(two_rho), r * np.sin(two_rho)])


def test_light_of_many_lines_is_the_sum_of_them():
    """Under a broad light, XYZ over the light's own lies among the radiances of its single wavelengths."""
    xyz = evaluate(lights=["E"])
    lines = [f"line:{nm:g}" for nm in WAVELENGTHS_NM]
    whites = np.array([core.light_rgb(line, space="xyz") for line in lines])
    single = np.array([evaluate(lights=[line])[0] for line in lines])
    radiance = single[:, 1] / whites[:, 1]  # per wavelength, relative to F = 1 there
    # What all wavelengths together give lies between the extremes of the single ones, and near the Y-weighted mean.
    white = core.light_rgb("E", space="xyz")
    ratio = xyz[0] / white
    assert radiance.min() < ratio.min()
    assert ratio.max() < radiance.max()
    green = radiance[np.searchsorted(WAVELENGTHS_NM, 560)]
    assert abs(ratio[1] / green - 1) < 0.01


def test_grids_agree():
    """61 samples against 1 nm from 360 to 830 nm: the design promises Delta E00 below .1."""
    view, light = polar(20, 0), polar(22, 178)
    for spectrum in ("D65", "A", "FL11", "LED-B3", "HPS"):
        white = core.light_rgb(spectrum, space="xyz")
        pair = []
        for grid in ("61", "1nm"):
            xyz = evaluate(
                lights=[spectrum],
                grid=grid,
                view=view[None],
                light_direction=light[None, None],
            )
            pair.append(xyz)
        assert np.all(pair[0] > 0)
        scale = 0.6 / pair[1][0, 1]
        assert core.delta_e00(pair[0] * scale, pair[1] * scale, white)[0] < 0.1


def test_room_is_fresnel_times_the_room():
    dark = np.zeros((1, 1))
    for angle in (0.0, 45.0, 80.0, 89.9):
        got = evaluate(view=polar(angle, 0)[None], irradiance=dark, world=("line:550", 0.7))
        n, k = core.metal_nk(IRON, np.array([550.0]))
        expected = 0.7 * complex_fresnel(n, k, np.cos(np.radians(angle)))[0]
        np.testing.assert_allclose(got[0, 1], expected, rtol=1e-12)
    assert np.all(evaluate(view=polar(91, 0)[None], irradiance=dark, world=("E", 1.0)) == 0)
    both = evaluate(world=("A", 0.2))
    np.testing.assert_allclose(both, evaluate() + evaluate(irradiance=dark, world=("A", 0.2)))


def test_lights_add_and_scale():
    two = evaluate(
        lights=["D65", "A"],
        light_of=np.array([1, 0, 1], np.int32),
        light_direction=np.stack([polar(43, 175), polar(30, 180), polar(50, 170)])[None],
        irradiance=np.array([[1.0, 2.0, 0.0]]),
    )
    one = evaluate(lights=["A"]) + 2.0 * evaluate(light_direction=polar(30, 180)[None, None])
    np.testing.assert_allclose(two, one, rtol=1e-12)
    np.testing.assert_allclose(evaluate(irradiance=np.array([[1e8]])), 1e8 * evaluate(), rtol=1e-12)


def test_half_turn_of_rho_and_mirrored_scene():
    turned = core.encode_lobe(np.array(2.0), np.array(1.0), np.array(210.0)).astype(float)
    np.testing.assert_allclose(evaluate(lobe_ji=turned), evaluate(), rtol=1e-6)
    np.testing.assert_allclose(evaluate(tangent=np.array([[-5.0, 0, 0]])), evaluate(), rtol=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        {"view": np.array([[1.0, 0, 0]])},
        {"view": np.array([[0.0, 0, -1]])},
        {"view": np.zeros((1, 3))},
        {"view": np.full((1, 3), np.nan)},
        {"light_direction": np.array([[[1.0, 0, 0]]])},
        {"light_direction": -polar(40, 0)[None, None]},
        {"light_direction": np.full((1, 1, 3), np.inf)},
        {"normal": np.zeros((1, 3))},
        {"normal": np.array([[np.nan, 0, 1]])},
        {"irradiance": np.zeros((1, 1))},
        {"irradiance": np.full((1, 1), np.nan)},
        {"irradiance": np.full((1, 1), -1.0)},
    ],
)
def test_nothing_comes_from_nothing(change):
    assert np.all(evaluate(**change) == 0)


def test_extreme_input_stays_finite():
    rng = np.random.default_rng(3)
    nasty = np.array([0, 1, -1, np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 2.3, -6.9, 4.4])
    points = 4000
    xyz = evaluate(
        normal=rng.choice(nasty, (points, 3)),
        tangent=rng.choice(nasty, (points, 3)),
        view=rng.choice(nasty, (points, 3)),
        light_direction=rng.choice(nasty, (points, 1, 3)),
        irradiance=rng.choice(nasty[:6], (points, 1)),
        lobe_ji=rng.choice(nasty, (points, 3)),
        lobe_hadori=rng.choice(nasty, (points, 3)),
        lobe_ha=rng.choice(nasty, (points, 3)),
        w=rng.choice(nasty, points),
        h=rng.choice(nasty, points),
        world=("D65", 1.0),
    )
    assert np.all(np.isfinite(xyz))
    assert np.all(xyz >= 0)
    assert np.any(xyz > 0)


def test_tangent_along_the_normal_matters_to_nobody_isotropic():
    round_lobe = core.encode_lobe(np.array(2.0), np.array(2.0), np.array(0.0)).astype(float)
    lobes = {"lobe_ji": round_lobe, "lobe_hadori": round_lobe, "lobe_ha": round_lobe}
    expected = evaluate(**lobes)
    for tangent in ([0, 0, 3.0], [0, 0, 0], [np.nan, 0, 0], [0, 7.0, 0]):
        np.testing.assert_allclose(
            evaluate(tangent=np.array([tangent]), **lobes), expected, rtol=1e-9
        )


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({"metal": "cheese"}, ["cheese"]),
        ({"lights": ["X99"]}, ["X99"]),
        ({"light_of": np.array([1], np.int32)}, ["light_of", "1"]),
        ({"light_of": np.array([-1], np.int32)}, ["light_of", "-1"]),
        ({"grid": "31"}, ["grid", "31", "1nm"]),
        ({"observer": "me"}, ["me"]),
        ({"view": np.zeros((2, 3))}, ["view", "(2, 3)", "(P, 3)"]),
        ({"irradiance": np.ones((1, 2))}, ["irradiance"]),
        ({"lobe_ji": np.zeros((1, 2))}, ["lobe_ji"]),
        ({"w": np.zeros(3)}, ["w", "(3)"]),
        ({"world": ("D65", -1.0)}, ["world", "-1"]),
    ],
)
def test_wrong_input_is_named(change, names):
    with pytest.raises(core.InputError) as error:
        evaluate(**change)
    for name in names:
        assert name in str(error.value)


def test_no_points_and_no_lights():
    none = np.zeros((0, 3))
    assert evaluate(
        normal=none,
        tangent=none,
        view=none,
        light_direction=np.zeros((0, 1, 3)),
        irradiance=np.zeros((0, 1)),
        w=np.zeros(0),
        h=np.zeros(0),
    ).shape == (0, 3)
    unlit = evaluate(
        light_of=np.zeros(0, np.int32),
        light_direction=np.zeros((1, 0, 3)),
        irradiance=np.zeros((1, 0)),
    )
    assert np.all(unlit == 0)


def test_cost_per_point_and_light(capsys):
    """A figure for the record; only a gross loss of speed (a hundredfold) fails."""
    points = 20_000
    many = {name: np.tile(np.array([[0.0, 0, 1]]), (points, 1)) for name in ("normal", "view")}
    start = time.process_time()
    evaluate(
        **many,
        tangent=np.tile(np.array([[1.0, 0, 0]]), (points, 1)),
        light_direction=np.tile(polar(1, 0)[None, None], (points, 1, 1)),
        irradiance=np.ones((points, 1)),
        w=np.full(points, 0.5),
        h=np.zeros(points),
    )
    nanoseconds = 1e9 * (time.process_time() - start) / points
    with capsys.disabled():
        print(
            f"\n  reference: {nanoseconds:.0f} ns of CPU per point and light (both Fresnel terms)"
        )
    assert nanoseconds < 300_000
