"""Lamps of a size in the picture: against the reference with thousands of points on the lamp, and extreme ones."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import togishi_core
from togishi.core import packing
from togishi.core.scene_data import LampPicture, Light, LightKind, PlainMaterial, World

pytestmark = pytest.mark.gpu

SIZE = (96, 96)
HALF_LIMIT = 65504.0
DOWN = {"x_axis": (1.0, 0.0, 0.0), "y_axis": (0.0, 1.0, 0.0), "z_axis": (0.0, 0.0, 1.0)}
RECTANGLE = Light(
    LightKind.RECTANGLE, position=(0.0, -1.0, 3.0), power=100.0, half_u=1.0, half_v=0.3, **DOWN
)
LAMPS = {
    "rectangle": RECTANGLE,
    "ellipse": dataclasses.replace(RECTANGLE, kind=LightKind.ELLIPSE),
    "ball": Light(
        LightKind.POINT, position=(0.5, -2.0, 3.0), power=100.0, radius=0.4, soft_falloff=False
    ),
    "sun": Light(LightKind.SUN, to_light=(0.3, -0.6, 0.8), power=3.0, half_angle_rad=0.1),
    "spot": Light(
        LightKind.SPOT, position=(0.0, -1.0, 3.0), power=100.0, radius=0.3, cone_rad=0.9, blend=0.6,
        soft_falloff=False, **DOWN,
    ),
}  # fmt: skip


@pytest.fixture
def scenes(gpu_context):
    import engine_scenes

    return engine_scenes


@pytest.fixture(scope="module")
def renderer(gpu_context):
    """One for all: the programs of lamps of a size take a second each to compile in software."""
    from togishi.engine.renderer import Renderer

    return Renderer()


def materials(scenes, name: str):
    if name == "isotropic":
        return scenes.isotropic_blade(2.0)
    if name == "anisotropic":
        return scenes.blade(ji={"mu_t_deg": 6.0, "mu_b_deg": 1.5, "rho_deg": 30.0})
    if name == "rough":
        return scenes.isotropic_blade(8.0)
    rng = np.random.default_rng(7)
    lobes = np.empty((32, 64, 4), np.float32)
    lobes[..., 0], lobes[..., 1] = math.log(2.0), math.log(8.0)
    lobes[..., 2], lobes[..., 3] = rng.random((32, 64)), 0.4
    shape = np.full((32, 64, 4), (0.3, 0.2, -0.1, 0.25), np.float32)
    return scenes.blade(
        scenes.maps_of(lobes, shape), hadori={"mu_t_deg": 9.0, "mu_b_deg": 3.0, "rho_deg": 30.0}
    )


def grey_of(picture: LampPicture, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The first channel at places of the lamp, between texels."""
    height, width = picture.pixels.shape[:2]
    at = np.stack([x, y, np.ones_like(x)])
    column = np.clip(np.asarray(picture.to_u) @ at * width - 0.5, 0.0, width - 1.0)
    row = np.clip(np.asarray(picture.to_v) @ at * height - 0.5, 0.0, height - 1.0)
    left, low = np.minimum(column.astype(int), width - 2), np.minimum(row.astype(int), height - 2)
    a, b = column - left, row - low
    grey = picture.pixels[..., 0]
    return (1.0 - b) * ((1.0 - a) * grey[low, left] + a * grey[low, left + 1]) + b * (
        (1.0 - a) * grey[low + 1, left] + a * grey[low + 1, left + 1]
    )


def points_on(light: Light, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(P, K, 3) directions to points of the lamp, (P, K) irradiance of each on a surface facing it: Gauss-Legendre."""
    x, wx = np.polynomial.legendre.leggauss(56 if light.picture is None else 160)
    if light.kind in {LightKind.RECTANGLE, LightKind.ELLIPSE}:
        if light.kind is LightKind.RECTANGLE:
            u, v = np.meshgrid(x, x)
            weight = np.outer(wx, wx) * light.half_u * light.half_v
        else:
            turn = np.arange(64) * (2.0 * math.pi / 64)
            radius, angle = np.meshgrid(0.5 * (x + 1.0), turn)
            u, v = radius * np.cos(angle), radius * np.sin(angle)
            weight = (0.5 * wx * radius) * (2.0 * math.pi / 64) * light.half_u * light.half_v
        place = (
            np.asarray(light.position)
            + u.reshape(-1, 1) * light.half_u * np.asarray(light.x_axis)
            + v.reshape(-1, 1) * light.half_v * np.asarray(light.y_axis)
        )
        to = place[None] - points[:, None]
        distance = np.linalg.norm(to, axis=-1)
        direction = to / distance[..., None]
        cosine = np.maximum(direction @ np.asarray(light.z_axis), 0.0)
        radiance = light.power / (math.pi * weight.sum())
        weight = weight.reshape(-1)
        if light.picture is not None:
            weight = weight * grey_of(light.picture, u.reshape(-1), v.reshape(-1))
        return direction, radiance * weight * cosine / distance**2
    if light.kind is LightKind.SUN:
        axis = np.broadcast_to(np.asarray(light.to_light), points.shape)
        axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
        half = np.full(len(points), light.half_angle_rad)
        facing = np.full(len(points), light.power)
    else:
        to = np.asarray(light.position) - points
        distance = np.linalg.norm(to, axis=-1)
        axis, half = to / distance[:, None], np.arcsin(light.radius / distance)
        facing = light.power / (4.0 * math.pi * distance**2)
    turn = np.arange(64) * (2.0 * math.pi / 64)
    share, angle = np.meshgrid(0.5 * (x + 1.0), turn)  # of 1 - cos
    weight = (0.5 * wx * np.ones_like(angle) / 64).reshape(-1)
    one_less = share.reshape(-1) * (1.0 - np.cos(half))[:, None]
    cosine, sine = 1.0 - one_less, np.sqrt(one_less * (2.0 - one_less))
    first = np.cross(axis, (0.31, -0.87, 0.42))
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = np.cross(axis, first)
    around = angle.reshape(-1)
    direction = (
        axis[:, None] * cosine[..., None]
        + first[:, None] * (sine * np.cos(around))[..., None]
        + second[:, None] * (sine * np.sin(around))[..., None]
    )
    radiance = facing / (math.pi * np.sin(half) ** 2)
    solid = 2.0 * math.pi * (1.0 - np.cos(half))
    irradiance = (radiance * solid)[:, None] * weight
    if light.kind is LightKind.SPOT:
        down = direction @ np.asarray(light.z_axis)
        cos_half = math.cos(0.5 * light.cone_rad)
        t = np.clip((down - cos_half) / ((1.0 - cos_half) * light.blend), 0.0, 1.0)
        irradiance = irradiance * t * t * (3.0 - 2.0 * t)
    return direction, irradiance


def reference_rgb(inputs, chosen, camera, material, light):
    """RGB of the chosen pixels, every point of the lamp summed over 61 wavelengths in double precision."""
    turn = camera.view[:3, :3]
    world = (inputs.position[chosen].astype(np.float64) - camera.view[:3, 3]) @ turn
    direction, irradiance = points_on(light, world)
    xyz = togishi_core.reference_xyz(
        material.steel.metal,
        [light.spectrum],
        np.zeros(direction.shape[1], np.int32),
        inputs.normal[chosen].astype(np.float64),
        inputs.tangent[chosen].astype(np.float64),
        inputs.view[chosen].astype(np.float64),
        direction @ turn.T,
        irradiance,
        inputs.lobe_ji[chosen].astype(np.float64),
        inputs.lobe_hadori[chosen].astype(np.float64),
        inputs.lobe_ha[chosen].astype(np.float64),
        inputs.w[chosen].astype(np.float64),
        inputs.h[chosen].astype(np.float64),
    )
    return np.asarray(xyz) @ np.asarray(togishi_core.xyz_to_rgb("rec709")).T


# Largest error against the reference's peak, and its mean, in %: at rest, while something moves.
LIMITS = {False: (3.0, 0.15), True: (15.0, 1.5)}


@pytest.mark.parametrize("kind", ["isotropic", "anisotropic", "maps"])
@pytest.mark.parametrize("lamp", LAMPS)
def test_agrees_with_the_reference(scenes, renderer, lamp, kind):
    """At rest and while something moves, of one reference: it takes most of the time."""
    material = materials(scenes, kind)
    camera = scenes.look_at((0.0, -3.5, 1.2))
    scene = scenes.scene_of(scenes.sphere(), material, (LAMPS[lamp],))
    inputs = renderer.gbuffer(scene, camera, SIZE)
    pictures = {
        moving: renderer.draw(scene, camera, SIZE, float32=True, moving=moving).read()[..., :3]
        for moving in LIMITS
    }
    # Every pixel around the highlight once in a while, and some anywhere.
    bright = pictures[False].max(axis=-1)
    rng = np.random.default_rng(3)
    rows = np.argwhere(inputs.covered & (bright > 1e-4 * bright.max()))
    others = np.argwhere(inputs.covered)
    rows = np.concatenate([rng.permutation(rows)[:48], rng.permutation(others)[:16]])
    chosen = np.zeros(inputs.covered.shape, bool)
    chosen[rows[:, 0], rows[:, 1]] = True
    expected = reference_rgb(inputs, chosen, camera, material, LAMPS[lamp])
    assert expected.max() > 0.1
    for moving, (most, mean) in LIMITS.items():
        error = 100.0 * np.abs(pictures[moving][chosen] - expected) / expected.max()
        print(
            f"{lamp}, {kind}, moving {moving}: max {error.max():.3f} %, mean {error.mean():.4f} %"
        )
        assert error.max() <= most
        assert error.mean() <= mean


def window() -> LampPicture:
    """Bars before a sky that grows brighter upwards and to one side, turned and mirrored on the lamp."""
    v, u = np.meshgrid((np.arange(128) + 0.5) / 128, (np.arange(64) + 0.5) / 64, indexing="ij")
    sky = 0.3 + 0.7 * v + 0.5 * u * (1.0 - v)
    sky[(np.abs(u - 0.5) < 0.05) | (np.abs(v - 0.6) < 0.08)] = 0.0
    pixels = np.repeat(sky[..., None], 3, axis=-1).astype(np.float32)
    return LampPicture(pixels, to_u=(0.0, -0.5, 0.5), to_v=(0.45, 0.0, 0.5))


# As LIMITS. Bars are as wide as half of what a broad lobe's node sees.
PICTURE_LIMITS = {False: (5.5, 0.75), True: (22.0, 3.5)}


@pytest.mark.parametrize("mu_deg", [1.0, 2.0, 8.0])
def test_a_lamp_with_a_picture_agrees_with_the_reference(scenes, renderer, mu_deg):
    lamp = dataclasses.replace(RECTANGLE, half_v=0.6, picture=window())
    material = scenes.isotropic_blade(mu_deg)
    camera = scenes.look_at((0.0, -3.5, 1.2))
    scene = scenes.scene_of(scenes.sphere(), material, (lamp,))
    inputs = renderer.gbuffer(scene, camera, SIZE)
    even = dataclasses.replace(lamp, picture=None)
    lit = renderer.draw(
        scenes.scene_of(scenes.sphere(), material, (even,)), camera, SIZE, float32=True
    ).read()[..., 1]
    rows = np.argwhere(inputs.covered & (lit > 1e-2 * lit.max()))
    rows = np.random.default_rng(3).permutation(rows)[:64]
    chosen = np.zeros(inputs.covered.shape, bool)
    chosen[rows[:, 0], rows[:, 1]] = True
    expected = reference_rgb(inputs, chosen, camera, material, lamp)
    without = reference_rgb(inputs, chosen, camera, material, even)
    # The picture matters.
    assert np.abs(expected / np.maximum(without, 1e-9) - 0.6).max() > 0.15
    for moving, (most, mean) in PICTURE_LIMITS.items():
        picture = renderer.draw(scene, camera, SIZE, float32=True, moving=moving).read()[..., :3]
        error = 100.0 * np.abs(picture[chosen] - expected) / expected.max()
        print(f"{mu_deg}, moving {moving}: max {error.max():.2f} %, mean {error.mean():.3f} %")
        assert error.max() <= most
        assert error.mean() <= mean


def test_a_matt_surface_under_a_lamp_with_a_picture(scenes, renderer):
    """By sixteen points of the picture."""
    lamp = dataclasses.replace(RECTANGLE, half_v=0.6, picture=window())
    matt = PlainMaterial((0.5, 0.5, 0.5), ior=1.0)
    camera = scenes.look_at((0.0, -3.5, 1.2))
    blade = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(), (lamp,))
    inputs = renderer.gbuffer(blade, camera, SIZE)
    scene = scenes.scene_of(scenes.sphere(), matt, (lamp,))
    picture = renderer.draw(scene, camera, SIZE, float32=True).read()[..., :3]
    rows = np.random.default_rng(3).permutation(np.argwhere(inputs.covered))[:200]
    at = (rows[:, 0], rows[:, 1])
    turn = camera.view[:3, :3]
    world = (inputs.position[at].astype(np.float64) - camera.view[:3, 3]) @ turn
    normal = inputs.normal[at].astype(np.float64) @ turn
    direction, irradiance = points_on(lamp, world)
    cosine = np.maximum(np.einsum("pkc,pc->pk", direction, normal), 0.0)
    expected = (irradiance * cosine).sum(axis=1) * 0.5 / math.pi
    error = np.abs(picture[at] - expected[:, None]) / expected.max()
    print(f"{100 * error.max():.2f} %")
    assert error.max() <= 0.05


@pytest.mark.parametrize("lamp", LAMPS)
def test_plain_surface_agrees_with_the_sum_over_the_lamp(scenes, renderer, lamp):
    """Matt: the form factor, clipped at the horizon. A spot's cone is the mean over sixteen points of it."""
    matt = PlainMaterial((0.5, 0.5, 0.5), ior=1.0)
    scene = scenes.scene_of(scenes.sphere(), matt, (LAMPS[lamp],))
    camera = scenes.look_at((0.0, -3.5, 1.2))
    blade = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(), (LAMPS[lamp],))
    inputs = renderer.gbuffer(blade, camera, SIZE)
    picture = renderer.draw(scene, camera, SIZE, float32=True).read()[..., :3]
    rng = np.random.default_rng(3)
    rows = rng.permutation(np.argwhere(inputs.covered))[:200]
    at = (rows[:, 0], rows[:, 1])
    turn = camera.view[:3, :3]
    world = (inputs.position[at].astype(np.float64) - camera.view[:3, 3]) @ turn
    normal = inputs.normal[at].astype(np.float64) @ turn
    direction, irradiance = points_on(LAMPS[lamp], world)
    cosine = np.maximum(np.einsum("pkc,pc->pk", direction, normal), 0.0)
    expected = (irradiance * cosine).sum(axis=1) * 0.5 / math.pi
    error = np.abs(picture[at] - expected[:, None]) / expected.max()
    print(f"{lamp}: {100 * error.max():.3f} %")
    assert error.max() <= (0.04 if lamp == "spot" else 0.004)


# --- extremes -----------------------------------------------------------------------------------


def finite(picture) -> np.ndarray:
    values = picture.read()[..., :3]
    assert np.isfinite(values).all()
    assert np.abs(values).max() < HALF_LIMIT
    return values


def flat(kind: LightKind, place, half: float, **more) -> Light:
    return dataclasses.replace(
        RECTANGLE, kind=kind, position=place, half_u=half, half_v=half, **more
    )


EXTREME = {
    "touching": ((0.0, 0.0, 1.0), 0.2),
    "cutting through": ((0.0, 0.0, 0.7), 2.0),
    "inside the blade": ((0.0, 0.0, 0.2), 0.1),
    "behind": ((0.0, 0.0, -3.0), 0.5),
    "size zero": ((0.0, -1.0, 3.0), 0.0),
    "100 m": ((0.0, -1.0, 3.0), 100.0),
    "100 m, touching": ((0.0, 0.0, 1.0), 100.0),
    "around the camera": ((0.0, -3.5, 1.2), 0.5),
    "1 km away": ((0.0, -1000.0, 1000.0), 0.5),
}


@pytest.mark.parametrize("moving", [False, True], ids=["rest", "moving"])
@pytest.mark.parametrize("mu_deg", [0.05, 15.0])
@pytest.mark.parametrize("what", EXTREME)
def test_extreme_lamps_are_finite_and_without_fireflies(scenes, renderer, what, mu_deg, moving):
    """No pixel is brighter than a perfect mirror of the lamp: its radiance (times G/cos, which grazing bounds)."""
    place, half = EXTREME[what]
    camera = scenes.look_at((0.0, -3.5, 1.2))
    for kind in (LightKind.RECTANGLE, LightKind.ELLIPSE):
        lamp = flat(kind, place, half)
        radiance = lamp.power / (math.pi * max(half, 1e-4) ** 2 * 3.0)
        material = scenes.isotropic_blade(mu_deg)
        scene = scenes.scene_of(scenes.sphere(), material, (lamp,))
        values = finite(renderer.draw(scene, camera, SIZE, float32=half > 0.0, moving=moving))
        assert values.max() <= 3.0 * radiance
        if what in {"behind", "inside the blade"}:
            # It shines downwards: away from the sphere, or against its inner side, which nobody sees.
            assert values.max() < 1e-3 * radiance
        finite(renderer.draw(dataclasses.replace(
            scene, materials={"material": PlainMaterial()}), camera, SIZE, moving=moving))  # fmt: skip
    for lamp in (
        Light(LightKind.POINT, position=place, radius=max(half, 1e-3), soft_falloff=half < 1.0),
        Light(LightKind.SUN, to_light=place, half_angle_rad=min(max(half, 1e-6), 1.5), power=2.0),
    ):
        scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(mu_deg), (lamp,))
        finite(renderer.draw(scene, camera, SIZE, moving=moving))


def test_camera_inside_a_ball_lamp(scenes, renderer):
    camera = scenes.look_at((0.0, -3.5, 1.2))
    lamp = Light(LightKind.POINT, position=(0.0, -3.5, 1.2), radius=1.0, soft_falloff=False)
    scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(2.0), (lamp,))
    inside = finite(renderer.draw(scene, camera, SIZE, float32=True))
    # The blade in front mirrors the lamp around the camera: Fresnel's half of its radiance.
    radiance = lamp.power / (4.0 * math.pi**2 * lamp.radius**2)
    middle = inside[SIZE[1] // 2, SIZE[0] // 2] / radiance
    assert middle.min() > 0.4 and middle.max() < 0.65


@pytest.mark.parametrize("count", [64, 70])
def test_many_area_lamps_add_up(scenes, renderer, count):
    """70: more than one pass holds."""
    camera = scenes.look_at((0.0, -3.5, 1.2))
    one = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(2.0), (RECTANGLE,))
    share = dataclasses.replace(RECTANGLE, power=RECTANGLE.power / count)
    many = dataclasses.replace(one, lights=(share,) * count)
    expected = renderer.draw(one, camera, (48, 48), float32=True).read()
    got = finite(renderer.draw(many, camera, (48, 48), float32=True))
    np.testing.assert_allclose(got, expected[..., :3], rtol=1e-4, atol=1e-6)
    passes = packing.light_passes(many.lights, World())
    assert [p.counts.areas for p in passes] == ([64] if count == 64 else [64, 6])


def test_a_small_lamp_is_a_point_in_the_limit(scenes, renderer):
    camera = scenes.look_at((0.0, -3.5, 1.2))
    pictures = []
    for radius in (0.0, 1e-4):
        lamp = Light(LightKind.POINT, position=(1.0, -2.0, 3.0), radius=radius)
        scene = scenes.scene_of(scenes.sphere(), scenes.isotropic_blade(3.0), (lamp,))
        pictures.append(finite(renderer.draw(scene, camera, SIZE, float32=True)))
    error = np.abs(pictures[1] - pictures[0]).max() / pictures[0].max()
    print(f"against the point: {100 * error:.3f} % of the peak")
    assert error <= 0.01


def test_lamps_of_no_size_cost_nothing(scenes):
    """The programs of a scene of points hold no line of the lamps of a size."""
    from togishi.core.shader_source import SteelVariant, plain_program, steel_light_program

    lamps = (Light(LightKind.POINT), Light(LightKind.SPOT), Light(LightKind.SUN))
    variant = packing.light_variant(packing.light_passes(lamps, World()), World())
    assert not variant.areas and not variant.fine
    for source in (steel_light_program(variant, SteelVariant()), plain_program(variant)):
        assert "TG_AREAS" not in dict(source.defines)
        assert "areas" not in {name for _struct, name in source.blocks}
    moving = packing.light_variant(packing.light_passes((RECTANGLE,), World()), World(), fine=False)
    resting = packing.light_variant(packing.light_passes((RECTANGLE,), World()), World())
    assert moving == resting, "rectangles need one program for both levels"
