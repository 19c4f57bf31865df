"""Extreme scenes have a stated result, and where it is not trivial the GPU's agrees with the double-precision reference.

What each line of the requirement "Stability" is held by. `formulas` is test_gpu_formulas.py, which holds float, double
and GPU of every shared function to their tolerances; `renderer` is test_engine_renderer.py; `python/reference` is
tests/python/test_reference.py; a test named alone is in this file.

| line                      | test                                                                                  |
|---------------------------|---------------------------------------------------------------------------------------|
| mu 0.001 to 80 degrees    | test_lobes_of_every_width_agree_with_the_reference; renderer:test_power_and_roughness |
| aspect up to 100:1        | test_lobes_of_every_width_agree_with_the_reference; renderer:test_anisotropy_of_hundred_to_one |
| incidence to 90 exactly   | test_grazing_light_agrees_with_the_reference_and_ends_in_black; renderer:test_lights_and_views_at_the_horizon |
| N.V = 0 and negative      | test_a_normal_that_the_viewer_does_not_see_is_black                                   |
| T parallel to N           | test_tangent_along_the_normal; formulas:test_any_tangent_gives_a_right_handed_orthonormal_frame |
| L = -V                    | test_light_opposite_to_the_view_is_black; formulas:DEGENERATE                         |
| zero and 1e8 power        | renderer:test_power_and_roughness (zero is black); test_power_scales_the_picture (1e8) |
| a single-wavelength light | renderer:test_agrees_with_the_reference[line:589.3]; python/reference:test_against_numpy_for_single_wavelengths |
| n = k = 0                 | test_metal_file_without_n_and_k_is_refused_and_iron_is_drawn; test_metal_of_almost_no_n_and_k_reflects_all; formulas:DEGENERATE |
| NaN and infinity in a map | test_broken_texels_become_their_neighbours; renderer:test_nan_and_infinity_in_a_map   |
| 1 x 1 map                 | renderer:test_map_of_one_texel_is_the_constant                                        |
| 16k x 1k map              | test_map_of_16k_by_1k_is_read_at_the_right_texel                                      |
| wider than the GPU allows | test_map_wider_than_the_gpus_textures_loses_its_finest_levels                         |
| empty mesh                | renderer:test_empty_mesh (black)                                                      |
| mesh without UVs          | renderer:test_mesh_without_uv_takes_constants                                         |
| 0 and 200 lights          | renderer:test_any_number_of_lights                                                    |
| scene in km and in mm     | renderer:test_scene_in_mm_or_km, test_a_kilometre_from_the_origin                     |
| nothing crashes, no NaN   | test_random_extremes_stay_finite_and_agree_with_the_reference (all at once), and every picture here |

Most pictures are of a plate seen along -z without perspective, under suns: view and light are then exact, and the
plate's corners carry whatever normals and tangents a test wants.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import togishi_core

pytestmark = pytest.mark.gpu

SIZE = (32, 32)
TO_XYZ = np.linalg.inv(np.asarray(togishi_core.xyz_to_rgb("rec709")))
# Of the picture against the 61-wavelength sum: the table's interpolation and the shader's float arithmetic.
TABLE_ERROR = 2e-3
# Angle between H and N in the shader's float arithmetic, rad (shaders/shared/lobe.glsl).
FACET_ERROR_RAD = 3e-7


@pytest.fixture
def scenes(gpu_context):
    import engine_scenes

    return engine_scenes


@pytest.fixture
def renderer(gpu_context):
    from togishi.engine.renderer import Renderer

    return Renderer()


@pytest.fixture
def camera(gpu_context):
    """Along -z without perspective, 2 units of the scene wide."""
    from togishi.core.scene_data import Camera

    view = np.eye(4)
    view[2, 3] = -5.0
    projection = np.diag([1.0, 1.0, -2.0 / 9.9, 1.0])
    projection[2, 3] = -10.1 / 9.9
    return Camera(view, projection)


CORNERS = np.asarray([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def plate(normals, tangents=None, uv=None, part: int = 1):
    """A square that fills the picture. normals, tangents: one, or one for each corner; uv: (4, 2)."""
    from togishi.core import packing

    def at_corners(vectors):
        return np.ascontiguousarray(np.broadcast_to(vectors, (4, 3)), np.float32)

    return packing.build_mesh(
        np.column_stack([CORNERS, np.zeros(4)]).astype(np.float32),
        np.arange(4, dtype=np.int32),
        np.asarray([(0, 1, 2), (0, 2, 3)], np.int32),
        np.zeros(2, np.int32),
        at_corners(normals),
        np.asarray([part]),
        None,
        None if uv is None else np.asarray(uv, np.float32),
        None if tangents is None else at_corners(tangents),
        frozenset({0}),
    )


def towards(angle_deg: float) -> np.ndarray:
    """Unit vector at an angle from +z, in the x-z plane."""
    angle = math.radians(angle_deg)
    return np.asarray((math.sin(angle), 0.0, math.cos(angle)))


def sun(to_light, power: float = 1.0):
    from togishi.core.scene_data import Light, LightKind

    return Light(LightKind.SUN, to_light=tuple(np.asarray(to_light, float)), power=power)


def colours(renderer, scene, camera, size=SIZE) -> np.ndarray:
    """(H, W, 3) in float32 without the half float's limit, found finite in both."""
    half = renderer.draw(scene, camera, size).read()
    assert np.isfinite(half).all()
    assert np.abs(half).max() <= 65504.0
    values = renderer.draw(scene, camera, size, float32=True).read()
    assert np.isfinite(values).all()
    assert values.min() >= 0.0, "iron in daylight lies inside of Rec.709"
    return values[..., :3]


def against_reference(renderer, scene, camera, size=SIZE):
    """The picture's XYZ and the reference's at the pixels of steel, (P, 3) each, and what they are made from."""
    picture = colours(renderer, scene, camera, size)
    inputs = renderer.gbuffer(scene, camera, size)
    covered = inputs.covered
    points = inputs.position[covered].astype(np.float64)
    directions, irradiance = [], []
    for light in scene.lights:
        if light.kind.value == "sun":
            to_light = camera.view[:3, :3] @ np.asarray(light.to_light)
            distance2 = np.ones(len(points))
            to_light = np.broadcast_to(to_light, points.shape)
            irradiance.append(np.full(len(points), light.power))
        else:
            to_light = camera.view[:3] @ np.asarray((*light.position, 1.0)) - points
            distance2 = np.maximum((to_light**2).sum(axis=1), 1e-12)
            irradiance.append(light.power / (4.0 * math.pi * distance2))
        directions.append(to_light / np.sqrt(distance2)[:, None])
    (material,) = scene.materials.values()
    expected = togishi_core.reference_xyz(
        material.steel.metal,
        ["D65"],
        np.zeros(len(scene.lights), np.int32),
        *(
            getattr(inputs, name)[covered].astype(np.float64)
            for name in ("normal", "tangent", "view")
        ),
        np.stack(directions, axis=1),
        np.stack(irradiance, axis=1),
        *(
            getattr(inputs, name)[covered].astype(np.float64)
            for name in ("lobe_ji", "lobe_hadori", "lobe_ha", "w", "h")
        ),
    )
    assert np.isfinite(expected).all()
    return picture[covered].astype(np.float64) @ TO_XYZ.T, np.asarray(expected), inputs


# --- lobes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [1, 3], ids=["ji", "ha"])
@pytest.mark.parametrize(
    ("mu_t_deg", "mu_b_deg"),
    [
        (0.001, 0.001),
        (0.05, 0.05),
        (5.0, 5.0),
        (80.0, 80.0),
        (0.1, 0.001),
        (5.0, 0.05),
        (80.0, 0.8),
    ],
)
def test_lobes_of_every_width_agree_with_the_reference(
    scenes, renderer, camera, mu_t_deg, mu_b_deg, part
):
    """The plate's normals sweep the lobe to 1.5 half widths, or to 35 degrees where that is less."""
    half = towards(20.0)
    along, across = towards(110.0), np.asarray((0.0, 1.0, 0.0))
    reach = [math.tan(math.radians(min(1.5 * mu, 35.0))) for mu in (mu_t_deg, mu_b_deg)]
    normals = half + CORNERS[:, :1] * reach[0] * along + CORNERS[:, 1:] * reach[1] * across
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lobe = {"mu_t_deg": mu_t_deg, "mu_b_deg": mu_b_deg, "rho_deg": 0.0}
    material = scenes.blade(**{"ji" if part == 1 else "ha": lobe})
    scene = scenes.scene_of(plate(normals, along, part=part), material, (sun(towards(40.0)),))
    got, expected, inputs = against_reference(renderer, scene, camera)
    assert len(got) == SIZE[0] * SIZE[1]
    np.testing.assert_allclose(
        inputs.lobe_ji[inputs.covered][:, 0], 0.5 * math.log(mu_t_deg * mu_b_deg), atol=1e-5
    )
    lit = expected[:, 1] > 1e-3 * expected[:, 1].max()
    assert lit.mean() > 0.8
    # At 1.5 half widths on both axes the exponent's slope is 3 ln2 / mu on each of them.
    facet = 6.0 * math.log(2.0) * FACET_ERROR_RAD / math.radians(mu_b_deg)
    tolerance = TABLE_ERROR + facet + 1e-7 * (mu_t_deg / mu_b_deg) ** 2
    error = np.abs(got - expected)[lit] / expected[lit, 1:2]
    assert error.max() < tolerance
    # The peak is that of the normalised lobe: ln2/(4 pi mu_t mu_b) G/cos, between half of it and all.
    peak = math.log(2.0) / (4.0 * math.pi * math.radians(mu_t_deg) * math.radians(mu_b_deg))
    assert 0.3 * peak < expected[:, 1].max() < 1.2 * peak


# --- directions ---------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [1, 3], ids=["ji", "ha"])
@pytest.mark.parametrize("angle_deg", [60.0, 85.0, 89.0, 89.9, 89.99, 89.995, 90.0, 90.001, 135.0])
def test_grazing_light_agrees_with_the_reference_and_ends_in_black(
    scenes, renderer, camera, angle_deg, part
):
    """Incidence on a plate that faces the viewer: as the reference, black from N.L = 1e-4 (89.994 degrees) on."""
    scene = scenes.scene_of(
        plate((0, 0, 1), part=part), scenes.isotropic_blade(80.0), (sun(towards(angle_deg)),)
    )
    got, expected, _ = against_reference(renderer, scene, camera)
    assert (expected[:, 1] > 0.0).all() == (angle_deg < 89.994)
    if angle_deg > 89.994:
        assert (got == 0.0).all()
        assert (expected == 0.0).all()
    else:
        # The sun's direction reaches the GPU in float: N.L is known to 6e-8.
        tolerance = TABLE_ERROR + 1.2e-7 / math.cos(math.radians(angle_deg))
        assert (np.abs(got - expected) / expected[:, 1:2]).max() < tolerance


@pytest.mark.parametrize("angle_deg", [60.0, 89.0, 89.9, 89.99])
def test_grazing_view_of_the_mirror_image_agrees_with_the_reference(
    scenes, renderer, camera, angle_deg
):
    """View and light at the same angle on both sides of N, up to where they are all but opposite."""
    normal, light = towards(angle_deg), towards(2.0 * angle_deg)
    scene = scenes.scene_of(plate(normal), scenes.isotropic_blade(80.0), (sun(light),))
    got, expected, _ = against_reference(renderer, scene, camera)
    assert (expected[:, 1] > 0.0).all()
    # Both cosines, and H from the short sum L + V, are known to 1.2e-7/cos(theta).
    tolerance = TABLE_ERROR + 5.0e-7 / math.cos(math.radians(angle_deg))
    assert (np.abs(got - expected) / expected[:, 1:2]).max() < tolerance


@pytest.mark.parametrize("angle_deg", [90.0, 90.001, 91.0, 135.0, 179.0, 179.9, 179.99999, 180.0])
def test_a_normal_that_the_viewer_does_not_see_is_black(scenes, renderer, camera, angle_deg):
    """N.V = 0, negative and -1, as custom normals give it to faces in sight: no lamp and no room is reflected."""
    from togishi.core.scene_data import World

    lights = tuple(sun(towards(a)) for a in (-60.0, 0.0, 45.0, 90.0, 135.0, 180.0))
    room = World((1.0, 1.0, 1.0))
    scene = scenes.scene_of(
        plate(towards(angle_deg)), scenes.isotropic_blade(80.0), lights, world=room
    )
    assert colours(renderer, scene, camera).max() == 0.0
    seen = scenes.scene_of(plate(towards(45.0)), scenes.isotropic_blade(80.0), lights, world=room)
    assert colours(renderer, seen, camera).min() > 0.0


@pytest.mark.parametrize("angle_deg", [0.0, 45.0, 89.99, 90.0])
def test_light_opposite_to_the_view_is_black(scenes, renderer, camera, angle_deg):
    """L = -V, whatever the normal: there is no half vector and no facet mirrors the light to the viewer."""
    scene = scenes.scene_of(
        plate(towards(angle_deg)), scenes.isotropic_blade(80.0), (sun((0, 0, -1), 1e8),)
    )
    got, expected, _ = against_reference(renderer, scene, camera)
    assert (got == 0.0).all()
    assert (expected == 0.0).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("angle_deg", [0.0, 20.0, 70.0])
def test_tangent_along_the_normal(scenes, renderer, camera, sign, angle_deg):
    """A lobe with a direction takes the fixed direction that a missing tangent gives; a round one is untouched."""
    normal, lights = towards(angle_deg), (sun(towards(40.0)),)
    brushed = scenes.blade(ji={"mu_t_deg": 40.0, "mu_b_deg": 4.0, "rho_deg": 30.0})
    parallel = scenes.scene_of(plate(normal, sign * normal), brushed, lights)
    got, expected, inputs = against_reference(renderer, parallel, camera)
    assert expected[:, 1].max() > 0.0
    np.testing.assert_allclose(got, expected, rtol=TABLE_ERROR, atol=1e-9)
    across = (inputs.tangent[inputs.covered] * normal).sum(axis=1)
    assert np.abs(across).max() < 1e-6
    missing = scenes.scene_of(plate(normal, (0, 0, 0)), brushed, lights)
    np.testing.assert_allclose(
        colours(renderer, parallel, camera), colours(renderer, missing, camera), rtol=1e-4
    )
    # The ha is brushed, so the program has tangents; the plate is ji, whose lobe is round.
    round_ji = scenes.blade(
        ji={"mu_t_deg": 20.0, "mu_b_deg": 20.0, "rho_deg": 0.0},
        ha={"mu_t_deg": 40.0, "mu_b_deg": 4.0, "rho_deg": 30.0},
    )
    pictures = [
        colours(renderer, scenes.scene_of(plate(normal, t), round_ji, lights), camera)
        for t in (sign * normal, np.asarray((0.0, 1.0, 0.0)))
    ]
    assert pictures[0].min() > 0.0
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=1e-5)


# --- lamps and metals ---------------------------------------------------------------------------


@pytest.mark.parametrize("power", [1e-20, 1e-6, 1e8])
def test_power_scales_the_picture(scenes, renderer, camera, power):
    """A picture in float32 is proportional to the lamp's power over 28 decades."""
    material = scenes.isotropic_blade(20.0)
    one, other = (
        colours(
            renderer,
            scenes.scene_of(plate((0, 0, 1)), material, (sun(towards(40.0), p),)),
            camera,
        ).astype(np.float64)
        for p in (1.0, power)
    )
    assert one.min() > 0.0
    np.testing.assert_allclose(other / power, one, rtol=1e-5)


def metal_file(path, n: float, k: float) -> str:
    rows = "".join(f"{nm},{n},{k}\n" for nm in (300, 500, 700, 900))
    path.write_text(
        "# format: togishi-table 1\n# kind: metal\n# name: own\n# title: A metal of its own\n"
        "# source: a test\n# licence: CC0-1.0\n# columns: wavelength_nm,n,k\n" + rows
    )
    return str(path)


def of_metal(material, metal: str):
    import dataclasses

    return dataclasses.replace(material, steel=dataclasses.replace(material.steel, metal=metal))


def test_metal_file_without_n_and_k_is_refused_and_iron_is_drawn(
    scenes, renderer, camera, tmp_path
):
    """No matter has n = k = 0: the file is refused by name, and the picture is that of the default iron."""
    metal = metal_file(tmp_path / "nothing.csv", 0.0, 0.0)
    with pytest.raises(togishi_core.InputError, match=r"nothing\.csv, line 8.*not both 0"):
        togishi_core.fresnel_table(metal, "D65")
    iron, lights = scenes.isotropic_blade(20.0), (sun(towards(40.0)),)
    assert iron.steel.metal == togishi_core.metals()[0]["name"]
    drawn = colours(
        renderer, scenes.scene_of(plate((0, 0, 1)), of_metal(iron, metal), lights), camera
    )
    assert "nothing.csv" in renderer.tables.problems[metal]
    np.testing.assert_array_equal(
        drawn, colours(renderer, scenes.scene_of(plate((0, 0, 1)), iron, lights), camera)
    )


def test_a_repaired_metal_file_applies_at_the_next_picture(scenes, renderer, camera, tmp_path):
    metal = metal_file(tmp_path / "repaired.csv", 0.0, 0.0)
    iron, lights = scenes.isotropic_blade(20.0), (sun(towards(40.0)),)
    scene = scenes.scene_of(plate((0, 0, 1)), of_metal(iron, metal), lights)
    as_iron = colours(renderer, scene, camera)
    assert list(renderer.tables.problems) == [metal]
    metal_file(tmp_path / "repaired.csv", 0.05, 30.0)
    as_mirror = colours(renderer, scene, camera)
    assert not renderer.tables.problems
    assert as_mirror.max() > 1.3 * as_iron.max()


@pytest.mark.parametrize(("n", "k"), [(1e-6, 0.0), (0.0, 1e-6), (0.0, 3.0)])
def test_metal_of_almost_no_n_and_k_reflects_all(scenes, renderer, camera, tmp_path, n, k):
    """F = 1 at every angle: the room is mirrored as it is."""
    from togishi.core.scene_data import World

    mirror = of_metal(scenes.isotropic_blade(), metal_file(tmp_path / "mirror.csv", n, k))
    room = World((0.25, 0.5, 0.75))
    for angle_deg in (0.0, 45.0, 80.0, 89.9):
        scene = scenes.scene_of(plate(towards(angle_deg)), mirror, (), world=room)
        picture = colours(renderer, scene, camera)
        np.testing.assert_allclose(
            picture, np.broadcast_to(room.radiance, picture.shape), rtol=1e-3
        )
    assert not renderer.tables.problems


# --- maps ---------------------------------------------------------------------------------------


def test_broken_texels_become_their_neighbours(scenes, renderer, camera):
    """NaN and infinity in one channel or in all of a texel: the picture of the map without them."""
    lobes = np.full((16, 16, 4), (1.0, 2.0, 0.5, 0.25), np.float32)
    shape = np.full((16, 16, 4), (0.3, 0.2, -0.1, 0.25), np.float32)
    broken, bent = lobes.copy(), shape.copy()
    broken[3, 4], broken[8, 9], broken[0, 0], broken[15, 15, 1] = np.nan, np.inf, -np.inf, np.nan
    bent[5, 5], bent[8, 8:12] = np.nan, np.inf
    with pytest.warns(Warning):
        repaired = scenes.maps_of(broken, bent)
    uv, lights = (CORNERS + 1.0) / 2.0, (sun(towards(10.0)),)
    pictures = [
        colours(
            renderer,
            scenes.scene_of(plate((0, 0, 1), (1, 0, 0), uv), scenes.blade(maps), lights),
            camera,
        )
        for maps in (scenes.maps_of(lobes, shape), repaired)
    ]
    assert pictures[0].min() > 0.0
    np.testing.assert_array_equal(pictures[1], pictures[0])


def test_map_of_16k_by_1k_is_read_at_the_right_texel(scenes, renderer, camera):
    """ln mu rises along u and w along v: the last 16 texels in level 0, the last 1024 in level 5."""
    width, height = 16384, 1024
    lobes = np.zeros((height, width, 4), np.float32)
    lobes[..., 0] = (np.arange(width) + 0.5) / width
    lobes[..., 1] = 2.0
    lobes[..., 2] = ((np.arange(height) + 0.5) / height)[:, None]
    maps = scenes.maps_of(lobes)
    del lobes
    for texels, tolerance in ((16, 1e-3), (1024, 2e-3)):
        low = 1.0 - texels / np.asarray((width, height))
        uv = low + (CORNERS + 1.0) / 2.0 * (1.0 - low)
        scene = scenes.scene_of(
            plate((0, 0, 1), uv=uv), scenes.isotropic_blade(3.0, maps), (sun(towards(4.0)),)
        )
        got, expected, inputs = against_reference(renderer, scene, camera)
        at = (np.arange(SIZE[0]) + 0.5) / SIZE[0]
        u, v = (start + at * (1.0 - start) for start in low)
        inner = slice(1, -1)  # the outermost pixels of level 0 lie in the last texel's outer half
        np.testing.assert_allclose(
            inputs.lobe_ji[inner, inner, 0],
            np.tile(u[inner], (SIZE[1] - 2, 1)),
            rtol=0,
            atol=tolerance,
        )
        np.testing.assert_allclose(
            inputs.w[inner, inner],
            np.tile(v[inner, None], (1, SIZE[0] - 2)),
            rtol=0,
            atol=tolerance,
        )
        assert (np.abs(got - expected) / expected[:, 1:2]).max() < TABLE_ERROR


@pytest.mark.parametrize("size", [(20000, 1), (1, 20000), (4096, 2)])
def test_map_wider_than_the_gpus_textures_loses_its_finest_levels(scenes, renderer, camera, size):
    """Maps may have 32768 texels to a side: what no texture of this GPU holds is drawn from a coarser level, and said."""
    width, height = size
    if size == (4096, 2):
        renderer._largest_texture = (
            1024  # a GPU of the least size, with more than one level left out
        )
    lobes = np.zeros((height, width, 4), np.float32)
    longer = 0 if width > height else 1
    ramp = (np.arange(max(size)) + 0.5) / max(size)
    lobes[..., 2] = ramp[None, :] if longer == 0 else ramp[:, None]
    shape = np.full_like(lobes, 0.25)
    uv = (CORNERS + 1.0) / 2.0
    scene = scenes.scene_of(
        plate((0, 0, 1), (1, 0, 0), uv),
        scenes.blade(scenes.maps_of(lobes, shape)),
        (sun((0, 0, 1)),),
    )
    got, expected, inputs = against_reference(renderer, scene, camera)
    at = (np.arange(SIZE[0]) + 0.5) / SIZE[0]
    rows = np.broadcast_to(at, SIZE) if longer == 0 else np.broadcast_to(at[:, None], SIZE)
    np.testing.assert_allclose(inputs.w, rows, rtol=0, atol=2e-3)
    np.testing.assert_allclose(inputs.lobe_ha[..., 1:], 0.25, rtol=0, atol=0.02)
    assert (np.abs(got - expected) / expected[:, 1:2]).max() < TABLE_ERROR
    (sentence,) = renderer.problems
    assert f"{width} x {height}" in sentence
    assert str(renderer._largest_texture) in sentence


# --- all at once --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(24))
def test_random_extremes_stay_finite_and_agree_with_the_reference(scenes, renderer, seed):
    """A closed sphere, so every angle, under lamps anywhere from its surface to far off, with any lobe, power and unit
    of length. Where the lobe is resolved by floats, and the lamp is not on the surface, the reference's picture."""
    rng = np.random.default_rng([11, seed])
    unit = float(rng.choice([1e-3, 1.0, 1e3]))
    wide = 10.0 ** rng.uniform(-3.0, math.log10(80.0))
    narrow = max(wide / 10.0 ** rng.uniform(0.0, 2.0), 0.001)
    lobe = {"mu_t_deg": wide, "mu_b_deg": narrow, "rho_deg": rng.uniform(0.0, 180.0)}
    material = scenes.blade(ji=lobe)
    lamps = [
        scenes.point_light(tuple(unit * distance * direction), float(power) * unit**2)
        for direction, distance, power in zip(
            rng.normal(size=(6, 3)) / 1.7,
            (0.0, 1.0, 1.001, 3.0, 30.0, 1e6),
            10.0 ** rng.uniform(-20.0, 8.0, 6),
            strict=True,
        )
    ]
    place = 4.0 * towards(rng.uniform(20.0, 160.0))[[2, 1, 0]] + (0.0, rng.uniform(-4.0, 1.0), 0.0)
    place *= 4.0 / np.linalg.norm(place)
    eye = np.asarray((0.2, -4.0, rng.uniform(-2.0, 2.0)))
    eye *= 4.0 / np.linalg.norm(eye)
    clear = (scenes.point_light(tuple(unit * place), 100.0 * unit**2),)
    # At equal distances the highlight lies half way; the picture shows it to twice the wide half width.
    highlight = (eye + place) / np.linalg.norm(eye + place)
    radius = math.radians(min(max(2.0 * wide, 0.3), 40.0))
    span = 2.0 * math.degrees(math.atan(radius / np.linalg.norm(eye - highlight)))
    matrix = np.diag([unit, unit, unit, 1.0])
    mesh = scenes.sphere()
    scene = scenes.scene_of(mesh, material, clear, matrix)
    everything = scenes.scene_of(mesh, material, (*lamps, *clear), matrix)
    for target, fov_deg in ((np.zeros(3), 35.0), (highlight, span)):
        view = scenes.look_at(
            tuple(unit * eye),
            tuple(unit * target),
            fov_deg=fov_deg,
            near=0.1 * unit,
            far=100.0 * unit,
        )
        colours(renderer, everything, view)
    got, expected, _ = against_reference(renderer, scene, view)
    # Below 1e-13 of its peak the shader skips a lobe.
    peak = math.log(2.0) / (4.0 * math.pi * math.radians(wide) * math.radians(narrow))
    lit = expected[:, 1] > 1e-6 * peak * 100.0 / (4.0 * math.pi * 16.0)
    if narrow > 0.02:
        assert lit.sum() >= 4
        # 1e-6 of the peak is at 4.5 half widths: a slope of 6.2/mu.
        tolerance = TABLE_ERROR + 6.2 * 2e-6 / math.radians(narrow) + 1e-6 * (wide / narrow) ** 2
        error = np.abs(got - expected)[lit] / expected[lit, 1:2]
        assert error.max() < tolerance
