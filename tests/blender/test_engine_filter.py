"""Highlights narrower than a pixel: the filtered picture of one sample against hundreds of samples without the filter."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import togishi_core
from togishi.core import packing
from togishi.core.scene_data import Light, LightKind, NormalMapData, World

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


def card(*, mirrored: bool = False):
    """2 x 2, facing -y, u to +x; v upwards or, on a mirrored chart, downwards."""
    place = np.array([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)], np.float32)
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32)
    if mirrored:
        uv[:, 1] = 1.0 - uv[:, 1]
    return packing.build_mesh(
        place,
        np.arange(4, dtype=np.int32),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        np.zeros(2, np.int32),
        np.tile(np.array([[0, -1, 0]], np.float32), (4, 1)),
        np.array([1]),
        None,
        uv,
        None,
        frozenset({0}),
    )


def with_normal_map(blade, lean_u: np.ndarray, lean_v: np.ndarray):
    """blade with a map of these leans, nx/nz and ny/nz, rows from v = 0."""
    normal = np.stack([lean_u, lean_v, np.ones_like(lean_u)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    maps = NormalMapData(*togishi_core.pack_normal_atlas((0.5 + 0.5 * normal).astype(np.float32)))
    return dataclasses.replace(blade, steel=dataclasses.replace(blade.steel, normal_map=maps))


@pytest.mark.parametrize("anisotropic", [False, True])
def test_normal_map_from_afar_keeps_the_texels_light(scenes, renderer, anisotropic):
    """Scratches across the card, 64 texels to a pixel: one sample against hundreds without any filter."""
    rng = np.random.default_rng(4)
    # Waves of some 5 texels: of white noise, what lies between two texels would be the reference's own choice.
    near = np.exp(-((np.fft.fftfreq(512) / 0.1) ** 2))
    noise = np.fft.ifft2(np.fft.fft2(rng.standard_normal((2, 512, 512))) * np.outer(near, near))
    a, b = noise.real / noise.real.std()
    lean_u, lean_v = 0.06 * a + 0.03, 0.03 * a + 0.02 * b
    lobe = {"mu_t_deg": 3.0, "mu_b_deg": 1.0, "rho_deg": 40.0}
    blade = scenes.blade(ji=lobe) if anisotropic else scenes.isotropic_blade(2.0)
    lamp = Light(LightKind.SUN, to_light=(0.12, -1.0, 0.06), power=2.0)
    scene = scenes.scene_of(card(), with_normal_map(blade, lean_u, lean_v), (lamp,))
    camera = scenes.look_at((0.0, -3.5, 0.0), fov_deg=30.0)
    size, fine = (8, 8), 64
    large = green(
        renderer.draw(scene, camera, (size[0] * fine, size[1] * fine), float32=True, lod_bias=-9.0)
    )
    expected = large.reshape(size[1], fine, size[0], fine).mean((1, 3))[1:-1, 1:-1]
    filtered = dataclasses.replace(scene, filtered=True)
    for drawn in (scene, filtered):
        got = green(renderer.draw(drawn, camera, size, float32=True))[1:-1, 1:-1]
        # The mixture of a pixel's some 150 waves is not quite a Gaussian.
        error = np.sqrt(((got - expected) ** 2).mean()) / expected.mean()
        print(f"mean {got.mean() / expected.mean() - 1.0:+.3f}, pixels {error:.3f}")
        assert got.mean() == pytest.approx(expected.mean(), rel=0.04)
        assert error < 0.2
    # Without the spread the highlight would be narrow and bright.
    flat = scenes.scene_of(card(), blade, scene.lights)
    plain = green(renderer.draw(flat, camera, size, float32=True))[1:-1, 1:-1]
    assert plain.max() > 1.5 * expected.max()


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_normal_map_leans_along_its_chart(scenes, renderer, mirrored):
    """A bump lit from above is bright above its top, whichever way round the chart lies; from behind it is a dent."""
    y, x = np.mgrid[0:128, 0:128] / 128.0 - 0.5
    height = np.exp(-(x**2 + y**2) / 0.02)
    blade = with_normal_map(
        scenes.isotropic_blade(1.0), 2.0 * x * height / 0.02 * 0.05, 2.0 * y * height / 0.02 * 0.05
    )
    lamp = Light(LightKind.SUN, to_light=(0.3, -1.0, 0.5), power=2.0)
    behind = Light(LightKind.SUN, to_light=(0.3, 1.0, 0.5), power=2.0)
    for light, eye, sign in ((lamp, -4.0, 1.0), (behind, 4.0, -1.0)):
        scene = scenes.scene_of(card(mirrored=mirrored), blade, (light,))
        scene = dataclasses.replace(scene, filtered=True)
        camera = scenes.look_at((0.0, eye, 0.0), fov_deg=35.0)
        values = green(renderer.draw(scene, camera, (64, 64), float32=True))
        row, column = np.indices(values.shape) - 31.5
        right = sign if eye < 0.0 else -sign  # seen from behind, +x is to the left
        assert sign * (values * row).sum() > 2.0 * values.sum()
        assert right * (values * column).sum() > 1.0 * values.sum()


def test_a_steep_normal_map_has_no_holes(scenes, renderer):
    """Ridges that lean away from a viewer who looks along the surface mirror the room; nothing is NaN."""
    rng = np.random.default_rng(5)
    lean = np.clip(3.0 * rng.standard_normal((2, 64, 64)), -6.0, 6.0)
    blade = with_normal_map(scenes.isotropic_blade(0.05), *lean)
    room = World(radiance=(1.0, 1.0, 1.0))
    camera = scenes.look_at((0.0, -0.3, -3.5), fov_deg=35.0)
    lamp = Light(LightKind.POINT, position=(0.0, -0.001, 0.5), power=10.0)
    scene = scenes.scene_of(card(), blade, (lamp,), world=room)
    flat = scenes.scene_of(card(), scenes.isotropic_blade(0.05), (), world=room)
    for filtered in (False, True):
        drawn = dataclasses.replace(scene, filtered=filtered)
        values = green(renderer.draw(drawn, camera, (48, 48), float32=True, lod_bias=-4.0))
        surface = green(renderer.draw(flat, camera, (48, 48), float32=True)) < 0.99
        assert surface.sum() > 50
        assert values[surface].min() > 0.4


def test_a_normal_map_is_no_code_where_there_is_none():
    from togishi.core.shader_source import (
        STEEL_TARGETS,
        LightVariant,
        SteelVariant,
        steel_light_program,
        steel_surface_program,
    )

    for used in (False, True):
        steel = SteelVariant(normal_map=used, tangent=used, maps=True, shape=True)
        first = steel_surface_program(steel, STEEL_TARGETS)
        second = steel_light_program(LightVariant(rectangles=True), steel)
        assert ("NormalSample normal_map_sample(" in first.fragment) == used
        assert ("spread_lobe(LobeForm" in second.fragment) == used
        assert ("VEC3", "tangent") not in first.attributes or used
        assert {"leans_atlas", "correlations_atlas"} <= {n for _k, n in first.samplers} or not used
    # Blender binds six targets at most.
    everything = SteelVariant(*[True] * 7)
    assert len(everything.targets) <= 6


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
