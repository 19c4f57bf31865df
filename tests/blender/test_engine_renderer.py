"""The drawing class on scene data: what it uploads, that it agrees with the reference, and extreme scenes."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import togishi_core
from togishi.core import packing
from togishi.core.scene_data import Light, LightKind, World

pytestmark = pytest.mark.gpu

SIZE = (96, 96)
HALF_LIMIT = 65504.0


@pytest.fixture
def scenes(gpu_context):
    import engine_scenes

    return engine_scenes


@pytest.fixture
def renderer(gpu_context):
    from togishi.engine.renderer import Renderer

    return Renderer()


def finite(picture) -> np.ndarray:
    values = picture.read()
    assert np.isfinite(values).all()
    assert np.abs(values).max() < HALF_LIMIT
    return values


# --- against the reference ----------------------------------------------------------------------


def reference_rgb(inputs, scene, camera, material, spectra):
    """RGB of the covered pixels by the plain 61-wavelength sum in double precision."""
    covered = inputs.covered
    points = inputs.position[covered].astype(np.float64)
    places = [camera.view[:3] @ np.asarray((*light.position, 1.0)) for light in scene.lights]
    to_light = np.stack([place - points for place in places], axis=1)
    distance2 = (to_light**2).sum(axis=2)
    power = np.asarray([light.power for light in scene.lights])
    xyz = togishi_core.reference_xyz(
        material.steel.metal,
        spectra,
        np.asarray([spectra.index(light.spectrum) for light in scene.lights], np.int32),
        inputs.normal[covered].astype(np.float64),
        inputs.tangent[covered].astype(np.float64),
        inputs.view[covered].astype(np.float64),
        to_light / np.sqrt(distance2)[..., None],
        power / (4.0 * math.pi * distance2),
        inputs.lobe_ji[covered].astype(np.float64),
        inputs.lobe_hadori[covered].astype(np.float64),
        inputs.lobe_ha[covered].astype(np.float64),
        inputs.w[covered].astype(np.float64),
        inputs.h[covered].astype(np.float64),
        beta_hadori=-1.0,
    )
    return np.asarray(xyz) @ np.asarray(togishi_core.xyz_to_rgb("rec709")).T, np.asarray(xyz)


@pytest.mark.parametrize("spectrum", ["D65", "A", "line:589.3"])
@pytest.mark.parametrize(
    "kind", ["one lobe", "anisotropic", "rough part", "maps", "maps with shape"]
)
def test_agrees_with_the_reference(scenes, renderer, kind, spectrum):
    mesh = scenes.sphere(part=3 if kind == "rough part" else 1)
    rng = np.random.default_rng(7)
    lobes = np.empty((32, 64, 4), np.float32)
    lobes[..., 0], lobes[..., 1] = math.log(2.0), math.log(8.0)
    lobes[..., 2], lobes[..., 3] = rng.random((32, 64)), 0.4
    shape = np.full((32, 64, 4), (0.3, 0.2, -0.1, 0.25), np.float32)
    wide = {"mu_t_deg": 9.0, "mu_b_deg": 3.0, "rho_deg": 30.0}
    material = {
        "one lobe": lambda: scenes.isotropic_blade(4.0),
        "anisotropic": lambda: scenes.blade(ji=wide),
        "rough part": lambda: scenes.isotropic_blade(6.0),
        "maps": lambda: scenes.isotropic_blade(3.0, scenes.maps_of(lobes)),
        "maps with shape": lambda: scenes.blade(scenes.maps_of(lobes, shape), hadori=wide),
    }[kind]()
    lights = (
        scenes.point_light((3.0, -3.0, 2.0), 400.0, spectrum=spectrum),
        scenes.point_light((-2.0, -4.0, 0.5), 300.0, spectrum=spectrum),
    )
    scene = scenes.scene_of(mesh, material, lights)
    camera = scenes.look_at((0.3, -4.0, 1.0), fov_deg=32.0)
    picture = renderer.draw(scene, camera, SIZE, float32=True).read()
    inputs = renderer.gbuffer(scene, camera, SIZE)
    assert inputs.covered.mean() > 0.3
    expected, xyz = reference_rgb(inputs, scene, camera, material, [spectrum])
    bright = xyz[:, 1] > 1e-4 * xyz[:, 1].max()
    assert bright.sum() > 500
    to_xyz = np.linalg.inv(np.asarray(togishi_core.xyz_to_rgb("rec709")))
    # Sodium light lies outside of Rec.709: its blue is negative, and kept.
    got = picture[inputs.covered][:, :3].astype(np.float64)
    assert (spectrum != "line:589.3") or got.min() < 0.0
    error = np.abs((got - expected)[bright] @ to_xyz.T) / xyz[bright, 1:2]
    assert error.max() < 2e-3


def test_a_room_is_mirrored_as_fresnel(scenes, renderer):
    from togishi.core.scene_data import World

    scene = scenes.scene_of(
        scenes.sphere(), scenes.isotropic_blade(), (), world=World((0.5, 0.5, 0.5))
    )
    camera = scenes.look_at((0.0, -4.0, 0.0), fov_deg=35.0)
    picture = renderer.draw(scene, camera, SIZE, float32=True).read()
    inputs = renderer.gbuffer(scene, camera, SIZE)
    cosine = (inputs.normal * inputs.view).sum(axis=-1)
    row = togishi_core.fresnel_table(scene.materials["material"].steel.metal, "D65", size=4096)
    expected = 0.5 * row[np.rint(np.sqrt(np.clip(cosine, 0, 1)) * 4095).astype(int)]
    inner = inputs.covered & (cosine > 0.1)
    assert inner.sum() > 1000
    np.testing.assert_allclose(picture[inner][:, :3], expected[inner], rtol=2e-3)
    # The room itself is behind the sphere.
    np.testing.assert_allclose(picture[0, 0], (0.5, 0.5, 0.5, 1.0), rtol=1e-3)


@pytest.mark.parametrize("step", [2, 4])
def test_coarse_pixels_lie_where_the_fine_ones_do(scenes, renderer, step):
    """Drawn with wider pixels and put on the screen again: a silhouette's middle and area stay."""
    import gpu
    from togishi.core import pace
    from togishi.engine.renderer import read_texture

    size = (101, 91)  # no multiple of the step
    scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(), (), world=World((0.5,) * 3))
    scene = dataclasses.replace(scene, transparent=True)
    camera = scenes.look_at((0.3, -4.0, 0.2), (0.3, 0.0, 0.1), fov_deg=40.0, aspect=101 / 91)
    fine = renderer.draw(scene, camera, size, float32=True).read()[..., 3]
    picture, following = renderer.draw_moving(scene, camera, size, step)
    assert picture.size == pace.coarse_size(size, step)
    assert following in (1, 2, 4)
    screen = gpu.types.GPUTexture(size, format="RGBA32F")
    with gpu.types.GPUFrameBuffer(color_slots=[screen]).bind():
        renderer.copy(picture.colour, step=step)
    coarse = read_texture(screen)[..., 3]
    assert fine.sum() == pytest.approx(coarse.sum(), rel=0.02)
    for axis in (0, 1):
        places = np.arange(fine.shape[axis])
        middles = [(a.sum(axis=1 - axis) * places).sum() / a.sum() for a in (fine, coarse)]
        # Whole pixels are in or out: that noise grows with their size.
        assert abs(middles[0] - middles[1]) < 0.12 * step


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_the_far_side_does_not_shine_through_at_the_edge(scenes, renderer, mirror):
    """A wedge whose thin edge has many small steps, with a lamp where only the far side, turned over, would mirror it."""
    from togishi.engine.renderer import FAR_DEPTH, read_texture

    steps, slope = 400, 0.15
    rng = np.random.default_rng(1)
    x = np.linspace(-1.0, 1.0, steps)
    edge = np.stack([x, np.zeros(steps), 0.02 * rng.random(steps)], -1)
    front, back = (np.stack([x, y * np.ones(steps), 1.0 + 0 * x], -1) for y in (-slope, slope))
    place = np.concatenate([edge, front, back]).astype(np.float32)
    i = np.arange(steps - 1)

    def strip(a, b):
        return np.concatenate(
            [np.stack([a + i, a + i + 1, b + i + 1], -1), np.stack([a + i, b + i + 1, b + i], -1)]
        )

    def ends(k):
        return [(k, steps + k, 2 * steps + k)]

    faces = [strip(0, steps), strip(2 * steps, 0), strip(steps, 2 * steps)]
    faces += [np.asarray(ends(steps - 1))[:, ::-1], ends(0)]
    triangles = np.concatenate(faces)
    corner = place[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # The faces, not their small steps: one normal each.
    normal[: 2 * (steps - 1)] = np.array([0.0, -1.0, -slope]) / math.hypot(1.0, slope)
    normal[2 * (steps - 1) : 4 * (steps - 1)] = np.array([0.0, 1.0, -slope]) / math.hypot(
        1.0, slope
    )
    part = np.full(len(triangles), 1, np.int32)
    part[2 * (steps - 1) : 4 * (steps - 1)] = 2
    mesh = packing.build_mesh(
        place,
        triangles.reshape(-1).astype(np.int32),
        np.arange(triangles.size).reshape(-1, 3),
        np.arange(len(triangles)),
        np.repeat(normal, 3, axis=0).astype(np.float32),
        part,
        None,
        None,
        None,
        frozenset({0}),
    )
    assert mesh.closed
    camera = scenes.look_at((0.0, -6.0, 0.0), fov_deg=22.0, near=1e-4)
    lamp = Light(LightKind.SUN, to_light=(0.0, -0.958, 0.287), power=1.0)
    flip = np.diag([mirror, 1.0, 1.0, 1.0])

    def brightest_and_parts(skin):
        scene = scenes.scene_of(skin, scenes.isotropic_blade(1.0), (lamp,), flip)
        picture = renderer.draw(scene, camera, (900, 90), float32=True).read()[..., :3]
        aux = renderer.draw_aux(scene, camera, (900, 90))
        seen = read_texture(aux.part)[read_texture(aux.depth) < FAR_DEPTH]
        return picture.max(), set(seen.tolist())

    light, parts = brightest_and_parts(dataclasses.replace(mesh, closed=False))
    assert light > 1.0
    assert 2.0 in parts
    light, parts = brightest_and_parts(mesh)
    assert light < 1e-3
    assert parts == {1.0}


def test_a_mirrored_object_is_the_mirror_image(scenes, renderer):
    """x -> -x in the object's matrix, in the lamps and in the camera gives the flipped picture, grooves included."""
    material = scenes.blade(ji={"mu_t_deg": 12.0, "mu_b_deg": 2.0, "rho_deg": 35.0})
    camera = scenes.look_at((0.0, -4.0, 0.0), fov_deg=35.0)
    place, other = (2.0, -3.0, 1.0), (-2.0, -3.0, 1.0)
    plain = renderer.draw(
        scenes.scene_of(scenes.sphere(), material, (scenes.point_light(place),)),
        camera,
        SIZE,
        float32=True,
    ).read()
    flip = np.diag([-1.0, 1.0, 1.0, 1.0])
    mirrored = renderer.draw(
        scenes.scene_of(scenes.sphere(), material, (scenes.point_light(other),), flip),
        camera,
        SIZE,
        float32=True,
    ).read()
    assert plain[..., :3].max() > 0.1
    difference = np.abs(plain[:, ::-1] - mirrored)[..., :3]
    assert np.median(difference[plain[:, ::-1, 0] > 0.01]) < 1e-4 * plain[..., :3].max()


def test_non_uniform_scale_carries_normals(scenes, renderer):
    """A sphere scaled to an ellipsoid has the ellipsoid's normals."""
    matrix = np.diag([1.0, 0.4, 0.7, 1.0])
    scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(), (), matrix)
    camera = scenes.look_at((0.0, -4.0, 0.0), fov_deg=35.0)
    inputs = renderer.gbuffer(scene, camera, SIZE)
    world = (
        np.linalg.inv(camera.view)
        @ np.concatenate(
            [inputs.position[inputs.covered], np.ones((inputs.covered.sum(), 1))], axis=1
        ).T
    ).T[:, :3]
    normal = world / np.diag(matrix)[:3] ** 2
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    got = inputs.normal[inputs.covered] @ camera.view[:3, :3]
    assert ((got * normal).sum(axis=1)).min() > 0.998


# --- what is uploaded ---------------------------------------------------------------------------


def changed(renderer, scene, camera, **change):
    before = renderer.counters.copy()
    renderer.draw(dataclasses.replace(scene, **change), camera, SIZE)
    return renderer.counters.since(before)


def test_lights_change_without_upload_of_meshes_maps_or_programs(scenes, renderer):
    lobes = np.full((16, 16, 4), (0.0, 1.0, 0.5, 0.0), np.float32)
    material = scenes.isotropic_blade(3.0, scenes.maps_of(lobes))
    light = scenes.point_light((2.0, -3.0, 2.0))
    scene = scenes.scene_of(scenes.sphere(), material, (light,))
    camera = scenes.look_at((0.0, -4.0, 0.0))
    renderer.draw(scene, camera, SIZE)
    for new in (
        dataclasses.replace(light, position=(1.0, -3.0, 2.0)),
        dataclasses.replace(light, power=20.0),
        dataclasses.replace(light, colour=(1.0, 0.2, 0.1)),
        dataclasses.replace(light, spectrum="blackbody:3111"),
    ):
        renderer.draw(scene, camera, SIZE)
        count = changed(renderer, scene, camera, lights=(new,))
        assert (count.mesh_uploads, count.map_uploads, count.programs_built) == (0, 0, 0)
        assert count.block_uploads == 1, new
    assert changed(renderer, scene, camera, lights=(light,)).block_uploads >= 1
    # The same scene again uploads nothing.
    assert changed(renderer, scene, camera, lights=(light,)).block_uploads == 0


def test_a_new_spectrum_takes_under_a_millisecond(scenes, renderer):
    import time

    light = scenes.point_light((2.0, -3.0, 2.0))
    scene = scenes.scene_of(scenes.sphere(rings=4), scenes.isotropic_blade(), (light,))
    camera = scenes.look_at((0.0, -4.0, 0.0))
    renderer.draw(scene, camera, (4, 4))
    times = []
    for kelvin in range(2000, 2030):
        new = dataclasses.replace(
            scene, lights=(dataclasses.replace(light, spectrum=f"blackbody:{kelvin}"),)
        )
        start = time.process_time_ns()
        renderer.prepare_lights(new)
        times.append((time.process_time_ns() - start) * 1e-6)
    assert np.median(times) < 1.0


def test_variants_are_kept_and_only_hold_what_is_needed(scenes, renderer):
    from togishi.core.shader_source import LightVariant, SteelVariant, steel_light_program

    camera = scenes.look_at((0.0, -4.0, 0.0))
    scene = scenes.scene_of(
        scenes.sphere(), scenes.isotropic_blade(), (scenes.point_light((2, -3, 2)),)
    )
    for _ in range(3):
        renderer.draw(scene, camera, SIZE)
    assert renderer.program_count == 2
    names = {name for name, _ in steel_light_program(LightVariant(), SteelVariant()).defines}
    assert "TG_ONE_LOBE" in names
    assert not names & {"TG_SPOTS", "TG_SUNS", "TG_WORLD", "TG_MAPS", "TG_HADORI", "TG_ANISOTROPIC"}


# --- extreme scenes -----------------------------------------------------------------------------


@pytest.mark.parametrize("count", [0, 1, 64, 200, 300])
def test_any_number_of_lights(scenes, renderer, count):
    """N lamps of power P/N at one place are one lamp of power P."""
    camera = scenes.look_at((0.0, -4.0, 0.0), fov_deg=35.0)
    material = scenes.isotropic_blade(5.0)
    one = renderer.draw(
        scenes.scene_of(scenes.sphere(), material, (scenes.point_light((2, -3, 2), 100.0),)),
        camera,
        SIZE,
        float32=True,
    ).read()
    lights = tuple(scenes.point_light((2, -3, 2), 100.0 / max(count, 1)) for _ in range(count))
    many = renderer.draw(
        scenes.scene_of(scenes.sphere(), material, lights), camera, SIZE, float32=True
    ).read()
    np.testing.assert_allclose(many[..., :3], one[..., :3] if count else 0.0, rtol=1e-3, atol=1e-6)


def test_more_spectra_than_one_block_holds(scenes, renderer):
    from togishi.core import packing

    kelvins = range(2000, 2000 + 50 * 40, 50)
    lights = tuple(
        scenes.point_light((2, -3, 2), 10.0, spectrum=f"blackbody:{kelvin}") for kelvin in kelvins
    )
    scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(5.0), lights)
    assert (
        len(packing.light_passes(lights, scene.world)) == -(-len(lights) // packing.TABLE_ROWS) > 1
    )
    camera = scenes.look_at((0.0, -4.0, 0.0), fov_deg=35.0)
    together = renderer.draw(scene, camera, SIZE, float32=True).read()
    apart = sum(
        renderer.draw(
            dataclasses.replace(scene, lights=(light,)), camera, SIZE, float32=True
        ).read()
        for light in lights
    )
    np.testing.assert_allclose(together[..., :3], apart[..., :3], rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("power", [0.0, 1e-20, 1e8, 1e30])
@pytest.mark.parametrize("mu_deg", [0.001, 0.05, 80.0])
def test_power_and_roughness(scenes, renderer, power, mu_deg):
    lights = (scenes.point_light((0, -4.0, 0.0), power), scenes.point_light((0, -1.0001, 0), power))
    scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(mu_deg), lights)
    values = finite(renderer.draw(scene, scenes.look_at((0, -4, 0), fov_deg=35), SIZE))
    # A lobe of a thousandth of a degree falls between the pixels.
    assert mu_deg < 1.0 or (values[..., :3].max() > 0.0) == (power > 1e-10)
    assert power > 0.0 or values[..., :3].max() == 0.0


def test_anisotropy_of_hundred_to_one(scenes, renderer):
    material = scenes.blade(ji={"mu_t_deg": 50.0, "mu_b_deg": 0.5, "rho_deg": 77.0})
    scene = scenes.scene_of(scenes.sphere(), material, (scenes.point_light((2, -3, 2), 1e4),))
    assert (
        finite(renderer.draw(scene, scenes.look_at((0, -4, 0), fov_deg=35), SIZE))[..., :3].max()
        > 0
    )


def test_nan_and_infinity_in_a_map(scenes, renderer):
    lobes = np.full((16, 32, 4), (0.0, 1.5, 0.5, 0.2), np.float32)
    lobes[3, 4], lobes[8, 9], lobes[10, 20] = np.nan, np.inf, -np.inf
    with pytest.warns(Warning):
        maps = scenes.maps_of(lobes)
    scene = scenes.scene_of(
        scenes.sphere(), scenes.isotropic_blade(3.0, maps), (scenes.point_light((2, -3, 2), 1e3),)
    )
    assert (
        finite(renderer.draw(scene, scenes.look_at((0, -4, 0), fov_deg=35), SIZE))[..., :3].max()
        > 0
    )


def test_map_of_one_texel_is_the_constant(scenes, renderer):
    lobes = np.asarray([[(math.log(4.0), math.log(4.0), 0.0, 0.0)]], np.float32)
    camera = scenes.look_at((0, -4, 0), fov_deg=35)
    lights = (scenes.point_light((2, -3, 2), 1e3),)
    mapped = renderer.draw(
        scenes.scene_of(
            scenes.sphere(), scenes.isotropic_blade(9.0, scenes.maps_of(lobes)), lights
        ),
        camera,
        SIZE,
    ).read()
    constant = renderer.draw(
        scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(4.0), lights), camera, SIZE
    ).read()
    np.testing.assert_allclose(mapped, constant, rtol=1e-2, atol=1e-3)


def test_mesh_without_uv_takes_constants(scenes, renderer):
    lobes = np.full((4, 4, 4), (3.0, 3.0, 1.0, 0.0), np.float32)
    camera = scenes.look_at((0, -4, 0), fov_deg=35)
    lights = (scenes.point_light((2, -3, 2), 1e3),)
    mesh = scenes.sphere(uv=False)
    mapped = renderer.draw(
        scenes.scene_of(mesh, scenes.isotropic_blade(4.0, scenes.maps_of(lobes)), lights),
        camera,
        SIZE,
    ).read()
    constant = renderer.draw(
        scenes.scene_of(mesh, scenes.isotropic_blade(4.0), lights), camera, SIZE
    ).read()
    np.testing.assert_array_equal(mapped, constant)


def test_empty_mesh(scenes, renderer):
    from togishi.core import packing

    nothing = np.zeros((0, 3), np.int32)
    mesh = packing.build_mesh(
        np.zeros((0, 3), np.float32),
        np.zeros(0, np.int32),
        nothing,
        np.zeros(0, np.int32),
        np.zeros((0, 3), np.float32),
        None,
        None,
        None,
        None,
    )
    scene = scenes.scene_of(mesh, scenes.isotropic_blade(), (scenes.point_light((2, -3, 2)),))
    assert finite(renderer.draw(scene, scenes.look_at((0, -4, 0)), SIZE))[..., :3].max() == 0.0
    renderer.draw_aux(scene, scenes.look_at((0, -4, 0)), SIZE)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_scene_in_mm_or_km(scenes, renderer, unit):
    """The same scene in another unit, lamps with the power that the distance asks for, is the same picture."""
    material = scenes.isotropic_blade(3.0)

    def picture(u, place=(0.0, 0.0, 0.0)):
        shift = np.eye(4)
        shift[:3, :3] *= u
        shift[:3, 3] = place
        eye = tuple(np.add((0.0, -4.0 * u, 0.5 * u), place))
        lamp = tuple(np.add((2.0 * u, -3.0 * u, 2.0 * u), place))
        camera = scenes.look_at(eye, place, fov_deg=35.0, near=0.1 * u, far=100.0 * u)
        scene = scenes.scene_of(
            scenes.sphere(), material, (scenes.point_light(lamp, 100.0 * u * u),), shift
        )
        return renderer.draw(scene, camera, SIZE, float32=True).read()[..., :3]

    expected = picture(1.0)
    assert expected.max() > 0.1
    np.testing.assert_allclose(picture(unit), expected, rtol=2e-3, atol=1e-4)


def test_a_kilometre_from_the_origin(scenes, renderer):
    material = scenes.isotropic_blade(0.3)

    def picture(place):
        matrix = np.eye(4)
        matrix[:3, 3] = place
        camera = scenes.look_at(tuple(np.add((0.0, -4.0, 0.5), place)), place, fov_deg=35.0)
        lamp = tuple(np.add((2.0, -3.0, 2.0), place))
        scene = scenes.scene_of(scenes.sphere(), material, (scenes.point_light(lamp),), matrix)
        return renderer.draw(scene, camera, SIZE, float32=True).read()[..., :3]

    expected = picture((0.0, 0.0, 0.0))
    np.testing.assert_allclose(
        picture((1e5, 2e5, -1e5)), expected, rtol=5e-3, atol=1e-4 * expected.max()
    )


def test_lights_and_views_at_the_horizon(scenes, renderer):
    """Lamps behind, beside, inside the surface and at the camera."""
    places = [(0, 4, 0), (4, 0, 0), (0, 0, 0), (0, -4, 0), (0, -1, 0), (0, -0.5, 0)]
    lights = tuple(scenes.point_light(place, 1e3) for place in places)
    scene = scenes.scene_of(scenes.sphere(rings=6), scenes.isotropic_blade(2.0), lights)
    for eye in [(0, -4, 0), (0.2, -1.01, 0.1), (0.0, -0.2, 0.0)]:
        finite(renderer.draw(scene, scenes.look_at(eye, (0, 0, 0.01), near=0.001), SIZE))


def test_two_renderers_do_not_disturb_each_other(scenes, renderer):
    from togishi.engine.renderer import Renderer

    camera = scenes.look_at((0, -4, 0), fov_deg=35)
    first = scenes.scene_of(
        scenes.sphere(), scenes.isotropic_blade(4.0), (scenes.point_light((2, -3, 2)),)
    )
    second = scenes.scene_of(
        scenes.sphere(0.5), scenes.isotropic_blade(9.0), (scenes.point_light((-2, -3, 2)),)
    )
    other = Renderer()
    alone = renderer.draw(first, camera, SIZE).read()
    other.draw(second, camera, (64, 32))
    np.testing.assert_array_equal(renderer.draw(first, camera, SIZE).read(), alone)


def test_two_steels_in_one_picture(scenes, renderer):
    """Each blade keeps its own material and variant where several are in sight."""
    from togishi.core.scene_data import Instance, SceneData

    smooth = scenes.isotropic_blade(4.0)
    wide = scenes.blade(ji={"mu_t_deg": 20.0, "mu_b_deg": 5.0, "rho_deg": 0.0})
    left, right = np.eye(4), np.eye(4)
    left[0, 3], right[0, 3] = -1.1, 1.1
    camera = scenes.look_at((0, -7, 0), fov_deg=35)
    lights = (scenes.point_light((0, -6, 3), 1e3),)
    mesh = {"mesh": scenes.sphere()}

    def picture(*instances):
        scene = SceneData(mesh, instances, {"a": smooth, "b": wide}, lights)
        return renderer.draw(scene, camera, SIZE).read()[..., :3]

    a, b = Instance("mesh", left, ("a",)), Instance("mesh", right, ("b",))
    np.testing.assert_allclose(picture(a, b), picture(a) + picture(b), atol=1e-6)
    assert picture(a).max() > 0.01
    assert picture(b).max() > 0.01
