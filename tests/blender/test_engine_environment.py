"""Surroundings from an HDRI: mirrored by lobes against brute force, lighting matt things, taken apart into bright spots."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import togishi_core
from togishi.core import packing, surroundings
from togishi.core.scene_data import Environment, PlainMaterial, World

pytestmark = pytest.mark.gpu

SIZE = (96, 96)
HALF_LIMIT = 65504.0


@pytest.fixture
def scenes(gpu_context):
    import engine_scenes

    return engine_scenes


@pytest.fixture(scope="module")
def renderer(gpu_context):
    from togishi.engine.renderer import Renderer

    return Renderer()


def room(width: int = 512, height: int = 256) -> np.ndarray:
    """Grey, with three soft boxes in a dim room above a darker floor."""
    towards = surroundings.directions(width, height)
    pixels = np.full((height, width, 3), 0.2, np.float32)
    pixels[towards[..., 2] < 0.0] = 0.08
    for centre, half_rad, radiance in (
        ((0.3, -0.8, 0.6), 0.2, 5.0),
        ((-0.8, -0.2, 0.5), 0.35, 3.0),
        ((0.1, 0.9, 0.3), 0.15, 2.0),
    ):
        axis = np.asarray(centre) / np.linalg.norm(centre)
        # An edge of four degrees, as a soft box has.
        away = np.arccos(np.clip(towards @ axis, -1.0, 1.0))
        share = np.clip((half_rad - away) / 0.07 + 0.5, 0.0, 1.0)[..., None]
        pixels = pixels * (1.0 - share) + np.float32(radiance) * share
    return pixels.astype(np.float32)


def world_of(pixels: np.ndarray, **more: object) -> World:
    return World((1.0, 1.0, 1.0), "D65", surroundings.prepare(pixels), **more)


def radiance(pixels: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Between texels, as a renderer reads it."""
    height, width = pixels.shape[:2]
    bordered = surroundings.with_border(pixels)[..., 1].astype(np.float64)
    longitude = np.arctan2(direction[..., 1], direction[..., 0])
    latitude = np.arcsin(np.clip(direction[..., 2], -1.0, 1.0))
    x = (0.5 - longitude / (2.0 * math.pi)) * width + 0.5
    y = (0.5 + latitude / math.pi) * height + 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    column, row = np.clip(column, 0, width), np.clip(row, 0, height)
    fx, fy = x - column, y - row
    low = bordered[row, column] * (1 - fx) + bordered[row, column + 1] * fx
    high = bordered[row + 1, column] * (1 - fx) + bordered[row + 1, column + 1] * fx
    return low * (1 - fy) + high * fy


def reference_rgb(inputs, chosen, camera, material, pixels, turn=None, nodes: int = 64):
    """RGB of the chosen pixels: nodes^2 facets of the lobe, 61 wavelengths, double precision."""
    normal, tangent, view = (
        values[chosen].astype(np.float64) for values in (inputs.normal, inputs.tangent, inputs.view)
    )
    lobe = inputs.lobe_ji[chosen].astype(np.float64)
    across = np.cross(normal, tangent)
    size = np.hypot(lobe[:, 1], lobe[:, 2])
    rho = 0.5 * np.arctan2(lobe[:, 2], lobe[:, 1])
    sigma = np.radians(np.exp(lobe[:, 0])) / math.sqrt(2.0 * math.log(2.0))
    z = (np.arange(nodes) + 0.5) / nodes * 9.0 - 4.5
    zx, zy = (grid.reshape(-1) for grid in np.meshgrid(z, z))
    long_part = (sigma * np.exp(size))[:, None] * zx
    short_part = (sigma * np.exp(-size))[:, None] * zy
    dx = long_part * np.cos(rho)[:, None] - short_part * np.sin(rho)[:, None]
    dy = long_part * np.sin(rho)[:, None] + short_part * np.cos(rho)[:, None]
    phi = np.maximum(np.hypot(dx, dy), 1e-12)
    # Facets beyond the horizon are none.
    inside = phi < 0.5 * math.pi
    half = (
        normal[:, None] * np.cos(phi)[..., None]
        + tangent[:, None] * (dx * np.sin(phi) / phi)[..., None]
        + across[:, None] * (dy * np.sin(phi) / phi)[..., None]
    )
    cosine = np.einsum("pkc,pc->pk", half, view)
    direction = 2.0 * cosine[..., None] * half - view[:, None]
    measure = (sigma**2)[:, None] * (9.0 / nodes) ** 2 * np.sin(phi) / phi
    measure = np.where(inside & (cosine > 0.0), measure * 4.0 * np.maximum(cosine, 0.0), 0.0)
    in_world = direction @ camera.view[:3, :3]
    in_picture = in_world if turn is None else in_world @ np.asarray(turn).T
    irradiance = radiance(pixels, in_picture) * measure
    xyz = togishi_core.reference_xyz(
        material.steel.metal,
        ["D65"],
        np.zeros(direction.shape[1], np.int32),
        normal,
        tangent,
        view,
        direction,
        irradiance,
        lobe,
        inputs.lobe_hadori[chosen].astype(np.float64),
        inputs.lobe_ha[chosen].astype(np.float64),
        np.zeros(len(lobe)),
        np.zeros(len(lobe)),
    )
    return np.asarray(xyz) @ np.asarray(togishi_core.xyz_to_rgb("rec709")).T


# Material: largest error and mean, % of the brightest, at rest; the same while something moves.
CASES = {
    "fine": ((1.0, 1.0), (2.0, 0.3), (2.0, 0.3)),
    "3:1": ((3.0, 1.0), (2.0, 0.4), (3.5, 0.4)),
    "10:1": ((12.0, 1.2), (3.0, 0.6), (15.0, 2.0)),
    "rough": ((8.0, 8.0), (4.0, 1.0), (10.0, 1.0)),
}


@pytest.mark.parametrize("case", CASES)
def test_agrees_with_brute_force(scenes, renderer, case):
    (mu_t, mu_b), rest, moving = CASES[case]
    material = scenes.blade(ji={"mu_t_deg": mu_t, "mu_b_deg": mu_b, "rho_deg": 30.0})
    pixels = room()
    turn = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    world = world_of(pixels, turn=turn)
    assert not world.environment.spots
    camera = scenes.look_at((0.3, -3.5, 1.2))
    scene = scenes.scene_of(scenes.sphere(1.2), material, (), world=world)
    inputs = renderer.gbuffer(scene, camera, SIZE)
    facing = np.einsum("hwc,hwc->hw", inputs.normal, inputs.view)
    rows = np.argwhere(inputs.covered & (facing > 0.2))
    rows = np.random.default_rng(5).permutation(rows)[:60]
    chosen = np.zeros(inputs.covered.shape, bool)
    chosen[rows[:, 0], rows[:, 1]] = True
    expected = reference_rgb(inputs, chosen, camera, material, pixels, turn)
    for level, (most, mean) in ((False, rest), (True, moving)):
        picture = renderer.draw(scene, camera, SIZE, float32=True, moving=level).read()[..., :3]
        error = 100.0 * np.abs(picture[chosen] - expected) / expected.max()
        print(
            f"{case}, moving {level}: max {error.max():.2f} %, mean {error.mean():.3f} %, "
            f"worst at N.V {facing[chosen][error.max(axis=1).argmax()]:.2f}"
        )
        assert error.max() <= most
        assert error.mean() <= mean
    for samples, most, mean in ((16, 1.5, 0.2), (64, 1.0, 0.06)):
        total = np.zeros((*SIZE, 3))
        for number in range(samples):
            series = {"series": (number, samples)}
            picture = renderer.draw(scene, camera, SIZE, float32=True, **series)
            total += picture.read()[..., :3] / samples
        error = 100.0 * np.abs(total[chosen] - expected) / expected.max()
        print(f"{case}, {samples} samples: max {error.max():.2f} %, mean {error.mean():.3f} %")
        assert error.max() <= most
        assert error.mean() <= mean


def test_a_white_room_is_a_uniform_room(scenes, renderer):
    """The HDRI of one colour gives what the world's plain colour gives, on steel and on plain things."""
    camera = scenes.look_at((0.0, -3.5, 1.2))
    white = world_of(np.full((64, 128, 3), 0.5, np.float32))
    for material in (scenes.isotropic_blade(2.0), PlainMaterial()):
        scene = scenes.scene_of(scenes.sphere(), material, (), world=white)
        plain = dataclasses.replace(scene, world=World((0.5, 0.5, 0.5)))
        got = renderer.draw(scene, camera, SIZE, float32=True).read()[..., :3]
        expected = renderer.draw(plain, camera, SIZE, float32=True).read()[..., :3]
        # At grazing view the lobe reflects less than the one direction that stands for a uniform room.
        middle = (slice(32, 64), slice(32, 64))
        np.testing.assert_allclose(got[middle], expected[middle], rtol=0.02)
        # The ground behind.
        np.testing.assert_allclose(got[0, 0], expected[0, 0], rtol=1e-3)


def test_bright_spots_become_lamps():
    pixels = room(256, 128)
    pixels[90, 40] = 1.0e5
    pixels[20:22, 200:202] = (300.0, 200.0, 100.0)
    environment = surroundings.prepare(pixels)
    sun, bulb = environment.spots
    towards = surroundings.directions(256, 128)
    np.testing.assert_allclose(sun.direction, towards[90, 40], atol=1e-9)
    solid = surroundings.solid_angles(256, 128)
    np.testing.assert_allclose(sun.irradiance, 1.0e5 * solid[90, 0], rtol=1e-4)
    np.testing.assert_allclose(
        bulb.irradiance, 2 * solid[20:22, 0].sum() * np.array((300.0, 200.0, 100.0)), rtol=1e-2
    )
    # Of the texel's own solid angle.
    np.testing.assert_allclose(
        2.0 * math.pi * (1.0 - math.cos(sun.half_angle_rad)), solid[90, 0], rtol=1e-3
    )
    assert environment.pixels.max() <= 5.0
    # Turned with the world, in its strength.
    quarter = ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    lamps = packing.spot_lights(World((2.0, 2.0, 2.0), "A", environment, quarter))
    np.testing.assert_allclose(np.asarray(quarter) @ lamps[0].to_light, sun.direction, atol=1e-9)
    np.testing.assert_allclose(lamps[0].power, 2.0 * max(sun.irradiance))
    assert lamps[0].spectrum == "A" and len(lamps) == 2


def test_soft_boxes_and_empty_pictures_keep_their_light():
    assert not surroundings.prepare(room()).spots
    for pixels in (np.zeros((4, 8, 3), np.float32), np.ones((1, 1, 3), np.float32)):
        environment = surroundings.prepare(pixels)
        assert not environment.spots
        np.testing.assert_array_equal(environment.pixels, pixels)
        np.testing.assert_allclose(environment.matt, float(pixels.max()), rtol=1e-6)


@pytest.mark.parametrize("mu_deg", [0.05, 15.0])
def test_extremes_are_finite_and_without_fireflies(scenes, renderer, mu_deg):
    pixels = room(128, 64)
    pixels[45, 20] = 1.0e5
    pixels[3, 5] = np.nan
    pixels[60, 70] = -np.inf
    pixels[61, 70] = np.inf
    pixels[0, :] = -5.0
    world = world_of(pixels)
    assert np.isfinite(world.environment.pixels).all()
    camera = scenes.look_at((0.0, -3.5, 1.2))
    for material in (scenes.isotropic_blade(mu_deg), PlainMaterial()):
        scene = scenes.scene_of(scenes.sphere(), material, (), world=world)
        for filtered in (False, True):
            picture = renderer.draw(dataclasses.replace(scene, filtered=filtered), camera, SIZE)
            values = picture.read()[..., :3]
            assert np.isfinite(values).all() and np.abs(values).max() < HALF_LIMIT
            if mu_deg > 1.0 or isinstance(material, PlainMaterial):
                spots = world.environment.spots
                assert values.max() <= 50.0 * max(max(spot.irradiance) for spot in spots)


def test_no_code_where_no_hdri_is(scenes):
    from togishi.core.shader_source import SteelVariant, plain_program, steel_light_program

    variant = packing.light_variant(packing.light_passes((), World()), World((1.0, 1.0, 1.0)))
    assert variant.world and not variant.environment and not variant.areas
    for source in (steel_light_program(variant, SteelVariant()), plain_program(variant)):
        assert "environment_reflection" not in source.fragment.split("#define TG_REACHED")[1] or (
            "TG_ENVIRONMENT" not in dict(source.defines)
        )
        assert "environment_tap_place" not in source.fragment
        assert "environment_atlas" not in {name for _kind, name in source.samplers}
    environment = Environment(np.ones((8, 16, 3), np.float32), np.ones((16, 32, 3), np.float32), ())
    lit = World((1.0, 1.0, 1.0), "D65", environment)
    variant = packing.light_variant(packing.light_passes((), lit), lit)
    assert variant.environment and not variant.world
    source = steel_light_program(variant, SteelVariant())
    assert "environment_tap_place" in source.fragment
