"""Highlights narrower than a pixel: the filtered picture of one sample against hundreds of samples without the filter."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from togishi.core import packing
from togishi.core.scene_data import Light, LightKind

pytestmark = pytest.mark.gpu

SIZE = (64, 48)
# Samples of the reference in a pixel, to the right and upwards: the cylinder's highlight runs to the right.
FINE = {"cylinder": (4, 256), "sphere": (40, 60)}
SUN = Light(LightKind.SUN, to_light=(0.1, -0.5, 0.8), power=2.0)
LAMPS = {
    "sun": SUN,
    "near": Light(LightKind.POINT, position=(0.1, -0.8, 0.7), power=1.0),
    "area": Light(
        LightKind.RECTANGLE, position=(0.0, -1.0, 2.0), power=100.0, half_u=0.3, half_v=0.01
    ),
}


@pytest.fixture
def scenes(gpu_context):
    import engine_scenes

    return engine_scenes


@pytest.fixture(scope="module")
def renderer(gpu_context):
    from togishi.engine.renderer import Renderer

    return Renderer()


def cylinder(radius: float = 0.3, length: float = 2.0, sides: int = 256):
    """Along x, without ends."""
    turn = np.linspace(0.0, 2.0 * math.pi, sides + 1)
    x, p = np.meshgrid(np.linspace(-0.5, 0.5, 9) * length, turn, indexing="ij")
    normal = np.stack([np.zeros_like(p), np.cos(p), np.sin(p)], -1).reshape(-1, 3)
    place = radius * normal + np.stack([x, 0 * x, 0 * x], -1).reshape(-1, 3)
    index = np.arange(p.size).reshape(p.shape)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1)
    quads = quads.reshape(-1, 4)
    corners = np.arange(quads.size).reshape(-1, 4)
    return packing.build_mesh(
        place.astype(np.float32),
        quads.reshape(-1).astype(np.int32),
        np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]).astype(np.int32),
        np.tile(np.arange(len(quads)), 2).astype(np.int32),
        normal[quads.reshape(-1)].astype(np.float32),
        np.full(len(quads), 1),
        None,
        None,
        None,
        frozenset({0}),
    )


def green(picture) -> np.ndarray:
    values = picture.read()[..., :3]
    assert np.isfinite(values).all()
    return values[..., 1].astype(np.float64)


def errors(renderer, scene, camera, fine) -> tuple[float, float, float]:
    """Of the filtered picture: energy and brightest pixel, in shares; of the plain one: energy."""
    right, up = fine
    large = green(renderer.draw(scene, camera, (SIZE[0] * right, SIZE[1] * up), float32=True))
    expected = large.reshape(SIZE[1], up, SIZE[0], right).mean((1, 3))
    assert expected.max() > 0.0
    plain = green(renderer.draw(scene, camera, SIZE, float32=True))
    filtered = dataclasses.replace(scene, filtered=True)
    got = green(renderer.draw(filtered, camera, SIZE, float32=True))
    energy = got.sum() / expected.sum() - 1.0
    return energy, got.max() / expected.max() - 1.0, plain.sum() / expected.sum() - 1.0


@pytest.mark.parametrize(
    ("shape", "lamp", "mu_deg", "energy", "peak"),
    [
        ("cylinder", "sun", 0.3, 0.02, 0.05),
        ("cylinder", "sun", 2.0, 0.02, 0.05),
        ("cylinder", "near", 0.3, 0.02, 0.05),
        ("sphere", "sun", 0.5, 0.1, 0.1),
        # By a Gaussian: a straight highlight's light is spread over two pixels.
        ("cylinder", "area", 2.0, 0.03, 0.3),
    ],
)
def test_energy_of_a_small_highlight(scenes, renderer, shape, lamp, mu_deg, energy, peak):
    mesh = cylinder() if shape == "cylinder" else scenes.sphere(0.6)
    scene = scenes.scene_of(mesh, scenes.isotropic_blade(mu_deg), (LAMPS[lamp],))
    camera = scenes.look_at((0.05, -3.0, 0.9), fov_deg=35.0, aspect=SIZE[0] / SIZE[1])
    fine = FINE[shape] if lamp != "area" else (16, 64)
    found = errors(renderer, scene, camera, fine)
    print(
        f"energy {100 * found[0]:.2f} %, peak {100 * found[1]:.2f} %, plain {100 * found[2]:.1f} %"
    )
    assert abs(found[0]) <= energy and abs(found[1]) <= peak
    # The bound would hold nothing if the picture did not need the filter.
    assert mu_deg > 1.0 or abs(found[2]) > 0.2


def test_a_long_lobe_across_the_pixel(scenes, renderer):
    """Full covariance: a lobe of 9:1 at 30 degrees to the curvature."""
    lobe = {"mu_t_deg": 6.0, "mu_b_deg": 0.67, "rho_deg": 30.0}
    scene = scenes.scene_of(cylinder(), scenes.blade(ji=lobe), (SUN,))
    camera = scenes.look_at((0.05, -3.0, 0.9), fov_deg=35.0, aspect=SIZE[0] / SIZE[1])
    energy, peak, _plain = errors(renderer, scene, camera, (8, 128))
    print(f"energy {100 * energy:.2f} %, peak {100 * peak:.2f} %")
    assert abs(energy) <= 0.02 and abs(peak) <= 0.05


def test_what_is_wider_than_a_pixel_stays(scenes, renderer):
    camera = scenes.look_at((0.05, -3.0, 0.9), fov_deg=35.0)
    scene = scenes.scene_of(scenes.sphere(0.6), scenes.isotropic_blade(8.0), (SUN,))
    plain = green(renderer.draw(scene, camera, (256, 256), float32=True))
    filtered = dataclasses.replace(scene, filtered=True)
    got = green(renderer.draw(filtered, camera, (256, 256), float32=True))
    # Elsewhere is the silhouette, where a pixel's facets span the lobe.
    bright = plain > 0.3 * plain.max()
    assert bright.sum() > 100
    assert np.abs(got - plain)[bright].max() <= 0.005 * plain.max()
    # A gathered sample stands for less of the pixel.
    fine = green(renderer.draw(filtered, camera, (256, 256), float32=True, lod_bias=-4.0))
    assert np.abs(fine - plain)[bright].max() < 0.2 * np.abs(got - plain)[bright].max()


@pytest.mark.parametrize("mu_deg", [0.001, 0.05, 80.0])
def test_extremes_are_finite(scenes, renderer, mu_deg):
    """Silhouettes, lamps on the surface, a camera that touches it, an orthographic view, a speck of a blade."""
    mesh = scenes.sphere(1.0, 12)
    cameras = [
        scenes.look_at((0.0, -3.5, 1.2)),
        scenes.look_at((0.0, -1.0005, 0.0), (0.0, 0.0, 0.2), near=1e-4),
        scenes.look_at((0.0, -2000.0, 0.0), near=1.0, far=1e4),
    ]
    flat = np.array(cameras[0].projection)
    flat[3, 2], flat[3, 3] = 0.0, 1.0
    flat[:2] *= 0.3
    cameras.append(dataclasses.replace(cameras[0], projection=flat))
    lamps = (SUN, Light(LightKind.POINT, position=(0.0, -1.00001, 0.0), power=1e6))
    scene = scenes.scene_of(mesh, scenes.isotropic_blade(mu_deg), lamps)
    for camera in cameras:
        values = green(renderer.draw(dataclasses.replace(scene, filtered=True), camera, (40, 40)))
        assert (values >= 0.0).all()


def test_the_filter_is_no_code_where_it_is_off():
    from togishi.core.shader_source import (
        LightVariant,
        SteelVariant,
        steel_light_program,
        steel_surface_program,
    )

    for filtered in (False, True):
        steel = SteelVariant(filtered=filtered)
        program = steel_light_program(LightVariant(rectangles=True), steel)
        assert ("PixelStep pixel_step(" in program.fragment) == filtered
        assert ("bend_buffer" in {name for _kind, name in program.samplers}) == filtered
        outputs = {name for _kind, name in steel_surface_program(steel, ("surface",)).outputs}
        assert outputs == {"out_surface"}
    assert ("RGBA16F", "VEC4", "bend") in SteelVariant(filtered=True).targets
    assert "area_seen" in steel_light_program(LightVariant(rounds=True), SteelVariant()).fragment
