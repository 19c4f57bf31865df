"""Things that hide lamps and things in the blade's mirror, held to what follows exactly: a lamp half covered is a lamp of
half the size, a shadow's edge lies where geometry says, a mirrored card has its own radiance times the steel's reflectance."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from togishi.core.scene_data import Instance, Light, LightKind, PlainMaterial, SceneData, World

pytestmark = pytest.mark.gpu

SIZE = (96, 96)
GREY = PlainMaterial((0.5, 0.5, 0.5), ior=1.0, gloss_ln_mu_deg=3.0)
BLACK = PlainMaterial((0.0, 0.0, 0.0), ior=1.0, gloss_ln_mu_deg=3.0)


@pytest.fixture
def scenes(gpu_context):
    import engine_scenes

    return engine_scenes


@pytest.fixture
def traced(gpu_context):
    import traced_scenes

    return traced_scenes


@pytest.fixture(scope="module")
def renderer(gpu_context):
    from togishi.engine.renderer import Renderer

    return Renderer()


def scene_of(things, lights, world=None, **more) -> SceneData:
    """things: (mesh, material) or (mesh, material, what an Instance has besides)."""
    meshes, materials, instances = {}, {}, []
    for number, (mesh, material, *rest) in enumerate(things):
        meshes[f"{number}"], materials[f"{number}"] = mesh, material
        instances.append(
            Instance(f"{number}", np.eye(4), (f"{number}",), **(rest[0] if rest else {}))
        )
    return SceneData(meshes, tuple(instances), materials, tuple(lights), world or World(), **more)


def picture(renderer, scene, camera, size=SIZE, **how):
    values = renderer.draw(scene, camera, size, float32=True, **how).read()[..., :3]
    assert np.isfinite(values).all()
    return values


def gathered(renderer, scene, camera, samples):
    """Mean of samples that differ in their rays only."""
    return np.mean(
        [picture(renderer, scene, camera, added=(k, samples)) for k in range(samples)], axis=0
    )


@pytest.mark.parametrize("mu_deg", [0.5, 8.0])
@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_a_lamp_half_covered_is_mirrored_as_half_a_lamp(scenes, traced, renderer, mu_deg, shape):
    """A cover close to the lamp, out of the picture: what the steel mirrors is cut, not dimmed."""
    ball = scenes.sphere(0.8, rings=64)
    material = scenes.isotropic_blade(mu_deg)
    camera = scenes.look_at((0.0, -4.0, 1.5), fov_deg=30.0)
    lamp = dataclasses.replace(traced.square_lamp(), kind=LightKind(shape))
    cover = traced.box((0.0, -0.6, 2.995), (0.6, 0.6, 2.998))
    covered = picture(renderer, scene_of([(ball, material), (cover, BLACK)], [lamp]), camera)
    whole = picture(renderer, scene_of([(ball, material)], [lamp]), camera)
    assert whole.max() > 0.0
    if shape == "rectangle":
        half = traced.square_lamp(-0.25, 0.25, 0.5, 50.0)
        expected = picture(renderer, scene_of([(ball, material)], [half]), camera)
    else:
        # The rest and what is covered add up to the whole.
        other = traced.box((-0.6, -0.6, 2.995), (0.0, 0.6, 2.998))
        rest = picture(renderer, scene_of([(ball, material), (other, BLACK)], [lamp]), camera)
        expected = whole - rest
    # Nodes of a slice are seen or hidden whole: 16 slices of two nodes and more.
    error = np.abs(covered - expected).max() / whole.max()
    assert error < (0.09 if mu_deg < 1.0 else 0.05)
    assert abs(covered.sum() / expected.sum() - 1.0) < 0.02
    # The far side of what is mirrored is as bright as without a cover.
    bright = whole[..., 1] > 0.7 * whole[..., 1].max()
    if mu_deg < 1.0:
        share = covered[..., 1][bright] / whole[..., 1][bright]
        assert (share > 0.95).sum() > 0.25 * bright.sum()
        assert (share < 0.05).sum() > 0.25 * bright.sum()


def test_a_shadows_edge_lies_where_geometry_says(scenes, traced, renderer):
    """A point lamp above an edge at half its height: the shadow on the floor begins at twice the edge's x."""
    floor = traced.box((-4.0, -4.0, -0.1), (4.0, 4.0, 0.0))
    card = traced.box((0.5, -3.0, 1.0), (3.0, 3.0, 1.001))
    lamp = Light(LightKind.POINT, position=(0.0, 0.0, 2.0), power=100.0, shadows=True)
    camera = scenes.look_at((0.0, -0.001, 8.0), fov_deg=40.0)
    hidden = {"casts": True, "mirrored": False}
    lit = picture(renderer, scene_of([(floor, GREY)], [lamp]), camera)
    both = picture(renderer, scene_of([(floor, GREY), (card, BLACK, hidden)], [lamp]), camera)
    # A pixel's x on the floor, at the picture's middle row.
    middle = SIZE[1] // 2
    x = ((np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2.0 - 1.0) * math.tan(math.radians(20.0)) * 8.0
    beside_card = x < 0.5 * 8.0 / 7.0
    row, open_row = both[middle, :, 1], lit[middle, :, 1]
    np.testing.assert_allclose(row[beside_card], open_row[beside_card], rtol=1e-5)
    # Seen beyond the card, whose far edge the camera sees at 3 * 8/7.
    camera_low = scenes.look_at((0.0, -7.0, 0.9), target=(0.0, 0.0, 0.4), fov_deg=40.0)
    low = picture(renderer, scene_of([(floor, GREY), (card, BLACK, hidden)], [lamp]), camera_low)
    low_open = picture(renderer, scene_of([(floor, GREY)], [lamp]), camera_low)
    # Each pixel's place on the floor.
    ndc = (np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2.0 - 1.0
    forward = np.array([0.0, 7.0, -0.5]) / np.hypot(7.0, 0.5)
    up = np.cross((1.0, 0.0, 0.0), forward)
    f = math.tan(math.radians(20.0))
    rays = forward + f * (ndc[None, :, None] * np.array([1.0, 0.0, 0.0]) + ndc[:, None, None] * up)
    with np.errstate(divide="ignore"):
        place = np.array([0.0, -7.0, 0.9]) + rays * (-0.9 / rays[..., 2:3])
    seen = (rays[..., 2] < 0.0) & (np.abs(place[..., 0]) < 3.5) & (np.abs(place[..., 1]) < 2.0)
    on_floor = seen & (low_open[..., 1] > 0.0)
    lit_side = on_floor & (place[..., 0] < 0.9)
    dark_side = on_floor & (place[..., 0] > 1.1)
    assert lit_side.sum() > 100
    assert dark_side.sum() > 100
    np.testing.assert_allclose(low[lit_side], low_open[lit_side], rtol=1e-5)
    assert low[dark_side].max() == 0.0


@pytest.mark.parametrize("kind", ["rectangle", "ball", "sun"])
def test_half_a_lamp_lights_a_floor_by_half(scenes, traced, renderer, kind):
    """Under the middle of a covered lamp half the light is left, and with all samples the noise is gone."""
    floor = traced.box((-4.0, -4.0, -0.1), (4.0, 4.0, 0.0))
    lamps = {
        "rectangle": traced.square_lamp(),
        "ball": Light(LightKind.POINT, position=(0, 0, 3), power=100.0, radius=0.3, shadows=True),
        "sun": Light(
            LightKind.SUN, to_light=(0, 0, 1), power=3.0, half_angle_rad=0.1, shadows=True
        ),
    }
    card = traced.box((0.0, -2.0, 2.4), (2.0, 2.0, 2.401))
    camera = scenes.look_at((0.0, -6.0, 1.0), fov_deg=3.0)
    lit = picture(renderer, scene_of([(floor, GREY)], [lamps[kind]]), camera)
    covered = scene_of([(floor, GREY), (card, BLACK)], [lamps[kind]])
    share = gathered(renderer, covered, camera, 16)[..., 1] / lit[..., 1]
    # From x = 0 half of each lamp is seen, whatever its shape.
    assert abs(share[:, 47:49].mean() - 0.5) < 0.01
    steps = share.mean(axis=0)
    assert (np.diff(steps) < 0.01).all()  # darker towards the cover
    assert share[48].std() >= 0.0
    noise = np.std(share - steps, axis=0).max()
    assert noise < 0.05


def test_a_blade_does_not_hide_lamps_from_itself(scenes, traced, renderer):
    """Its facets would cut into their own rounded normals; and one blade alone compiles no ray."""
    ball = scenes.sphere(0.8, rings=12)
    camera = scenes.look_at((0.0, -4.0, 1.5), fov_deg=30.0)
    material = scenes.isotropic_blade(20.0)
    lamp = traced.square_lamp()
    alone = scene_of([(ball, material)], [lamp], mirror_things=True)
    open_light = picture(renderer, alone, camera)
    assert "TG_CASTERS" not in dict(renderer._steels[0].program.defines)
    far = traced.box((0.0, 0.0, -30.0), (1.0, 1.0, -29.0))
    with_other = picture(renderer, scene_of([(ball, material), (far, BLACK)], [lamp]), camera)
    assert "TG_SHADOWS" in dict(renderer._steels[0].program.defines)
    np.testing.assert_allclose(with_other, open_light, rtol=1e-5, atol=1e-6 * open_light.max())


def test_lamps_and_things_that_are_not_to_cast_do_not(scenes, traced, renderer):
    ball = scenes.sphere(0.8, rings=32)
    camera = scenes.look_at((0.0, -4.0, 1.5), fov_deg=30.0)
    material = scenes.isotropic_blade(6.0)
    lamp = traced.square_lamp()
    card = traced.box((-2.0, -2.0, 2.0), (2.0, 2.0, 2.01))
    lit = picture(renderer, scene_of([(ball, material)], [lamp]), camera)
    none = {"casts": False}
    no_caster = scene_of([(ball, material), (card, BLACK, none)], [lamp])
    np.testing.assert_allclose(picture(renderer, no_caster, camera), lit, rtol=1e-5)
    no_shadow = scene_of(
        [(ball, material), (card, BLACK)], [dataclasses.replace(lamp, shadows=False)]
    )
    np.testing.assert_allclose(picture(renderer, no_shadow, camera), lit, rtol=1e-5)
    dark = picture(renderer, scene_of([(ball, material), (card, BLACK)], [lamp]), camera)
    assert dark.max() < 1e-6 * lit.max()


@pytest.mark.parametrize("world", ["black", "uniform"])
def test_a_mirrored_card_has_its_own_radiance_times_the_reflectance(
    scenes, traced, renderer, world
):
    """A white card lit by a sun fills the mirror of a flat blade: albedo E/pi F, and nothing of the world is left."""
    blade = traced.box((-1.0, -1.0, -0.1), (1.0, 1.0, 0.0))
    card = traced.box((-20.0, 2.0, -0.1), (20.0, 2.1, 20.0))
    room = World((0.2, 0.2, 0.2)) if world == "uniform" else World()
    steel = scenes.isotropic_blade(0.3)
    camera = scenes.look_at((0.0, -4.0, 2.0), fov_deg=4.0)
    sun = Light(LightKind.SUN, to_light=(0.0, -1.0, 0.0), power=3.0)
    white = PlainMaterial((0.8, 0.8, 0.8), ior=1.0, gloss_ln_mu_deg=3.0)
    scene = scene_of([(blade, steel), (card, white)], [sun], room, mirror_things=True)
    mirrored = picture(renderer, scene, camera)[48, 48]
    # The reflectance: a room of radiance 1 on the same blade.
    whole = scene_of([(blade, steel)], [], World((1.0, 1.0, 1.0)))
    reflectance = picture(renderer, whole, camera)[48, 48]
    ambient = 0.2 if world == "uniform" else 0.0
    expected = (0.8 * 3.0 / math.pi + 0.8 * ambient) * reflectance
    np.testing.assert_allclose(mirrored, expected, rtol=0.01)
    # Where the mirror shows no card the room is as before.
    away = scenes.look_at((0.0, 1.9, 2.0), fov_deg=4.0)
    beside = picture(renderer, scene, away)
    alone = picture(renderer, scene_of([(blade, steel)], [], room), away)
    np.testing.assert_allclose(beside, alone, rtol=1e-4, atol=1e-7)


def test_a_mirrored_thing_stands_in_shadow_too(scenes, traced, renderer):
    blade = traced.box((-1.0, -1.0, -0.1), (1.0, 1.0, 0.0))
    card = traced.box((-20.0, 2.0, -0.1), (20.0, 2.1, 20.0))
    cover = traced.box((-20.0, -9.0, -0.1), (20.0, -8.9, 30.0))
    camera = scenes.look_at((0.0, -4.0, 2.0), fov_deg=4.0)
    sun = Light(LightKind.SUN, to_light=(0.0, -1.0, 0.0), power=3.0, shadows=True)
    steel = scenes.isotropic_blade(0.3)
    things = [(blade, steel), (card, GREY), (cover, BLACK)]
    dark = picture(renderer, scene_of(things, [sun], mirror_things=True), camera)
    lit = picture(renderer, scene_of(things[:2], [sun], mirror_things=True), camera)
    assert lit.max() > 0.05
    assert dark.max() == 0.0


def test_more_things_than_rays_search(scenes, traced, renderer):
    """The largest cast, and the user is told of the rest."""
    ball = scenes.sphere(0.8, rings=24)
    cards = [
        traced.box((x, -0.2, 2.0), (x + 0.01 + 0.001 * k, 0.2, 2.01))
        for k, x in enumerate(np.linspace(-1.0, 1.0, 40))
    ]
    things = [(ball, scenes.isotropic_blade(6.0)), *((card, BLACK) for card in cards)]
    camera = scenes.look_at((0.0, -4.0, 1.5), fov_deg=30.0)
    picture(renderer, scene_of(things, [traced.square_lamp()], mirror_things=True), camera)
    assert any("41 objects" in note for note in renderer.problems)


def test_extreme_things(scenes, traced, renderer):
    """No NaN and no firefly: a cover that touches the lamp, a thing around the viewer, one that holds the blade, a card of no
    thickness through the blade, things far away and tiny."""
    ball = scenes.sphere(0.8, rings=24)
    camera = scenes.look_at((0.0, -4.0, 1.5), fov_deg=30.0)
    lamp = traced.square_lamp()
    point = Light(LightKind.POINT, position=(0.0, -2.0, 2.0), power=100.0, shadows=True)
    whole = picture(
        renderer, scene_of([(ball, scenes.isotropic_blade(3.0))], [lamp, point]), camera
    )
    for low, high in (
        ((-0.5, -0.5, 3.0), (0.5, 0.5, 3.0)),
        ((-9.0, -9.0, -9.0), (9.0, 9.0, 9.0)),
        ((-0.9, -0.9, -0.9), (0.9, 0.9, 0.9)),
        ((-1.0, 0.0, -1.0), (1.0, 0.0, 1.0)),
        ((1.0e6, 1.0e6, 1.0e6), (1.1e6, 1.1e6, 1.1e6)),
        ((0.0, -1.0, 0.0), (1e-7, -1.0, 1e-7)),
    ):
        things = [(ball, scenes.isotropic_blade(3.0)), (traced.box(low, high), GREY)]
        scene = scene_of(things, [lamp, point], World((0.1, 0.1, 0.1)), mirror_things=True)
        # The thing itself is drawn too, so only what is too bright is asked for.
        assert picture(renderer, scene, camera).max() < 3.0 * whole.max()


@pytest.mark.parametrize("mu_deg", [1.0, 8.0])
def test_a_thing_in_the_mirror_is_as_blurred_as_the_lobe(scenes, traced, renderer, mu_deg):
    """The edge of a white card over a flat blade: with many samples the mean over the lobe's facets, as a lamp of that shape
    in its place is mirrored."""
    blade = traced.box((-1.0, -1.0, -0.1), (1.0, 1.0, 0.0))
    card = traced.box((-20.0, 2.0, -0.1), (0.0, 2.1, 20.0))
    camera = scenes.look_at((0.0, -4.0, 2.0), fov_deg=12.0)
    sun = Light(LightKind.SUN, to_light=(0.0, -1.0, 0.0), power=3.0)
    steel = scenes.isotropic_blade(mu_deg)
    white = PlainMaterial((0.8, 0.8, 0.8), ior=1.0, gloss_ln_mu_deg=3.0)
    scene = scene_of([(blade, steel), (card, white)], [sun], mirror_things=True)
    mirrored = gathered(renderer, scene, camera, 32)[40:56, :, 1]
    # The same radiance to the same place: 0.8 3/pi over 20 x 20.1.
    lamp = Light(
        LightKind.RECTANGLE, position=(-10.0, 2.0, 9.95), power=0.8 * 3.0 * 20.0 * 20.1,
        x_axis=(1.0, 0.0, 0.0), y_axis=(0.0, 0.0, -1.0), z_axis=(0.0, 1.0, 0.0),
        half_u=10.0, half_v=10.05,
    )  # fmt: skip
    lit = picture(renderer, scene_of([(blade, steel)], [lamp]), camera)[40:56, :, 1]
    error = np.abs(mirrored - lit) / lit.max()
    assert lit.min() < 0.1 * lit.max()
    assert error.max() < 0.05
    assert error.mean() < 0.02
