"""Programs and uploads without Blender: what is in the text, what is in the bytes."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import togishi_core

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon"))

from togishi.core import pace, packing, sampling, shader_source, tangents
from togishi.core.scene_data import Camera, Light, LightKind, PlainMaterial, SteelMaterial, World
from togishi.core.shader_source import LightVariant, SteelVariant


def every(variant: type) -> list:
    names = [f.name for f in dataclasses.fields(variant)]
    return [variant(*values) for values in itertools.product((False, True), repeat=len(names))]


def all_programs() -> list[shader_source.ProgramSource]:
    few = [LightVariant(False), LightVariant(*(True,) * len(dataclasses.fields(LightVariant)))]
    programs = [shader_source.copy_program(), shader_source.aux_program()]
    programs += [shader_source.plain_program(lights) for lights in every(LightVariant)]
    for steel in every(SteelVariant):
        programs.append(shader_source.steel_surface_program(steel))
        programs.append(shader_source.steel_inputs_program(steel, many=True))
        programs += [shader_source.steel_light_program(lights, steel) for lights in few]
    return programs


def test_programs_declare_no_interface_and_include_nothing_any_more():
    for program in all_programs():
        for text in (program.vertex, program.fragment):
            code = re.sub(r"//[^\n]*", "", text)
            assert "#include" not in code
            assert not re.search(
                r"^\s*(layout|in|out|uniform|varying|attribute)\b", code, re.MULTILINE
            )
            assert code.count("{") == code.count("}")
            assert len(re.findall(r"\bvoid main\(\)", code)) == 1


def test_each_formula_is_in_a_program_once():
    program = shader_source.steel_light_program(LightVariant(), SteelVariant())
    names = re.findall(r"^TG_FN \w+ (\w+)\(", program.fragment, re.MULTILINE)
    assert "ji_reflection" in names
    assert len(names) == len(set(names))


def test_push_constants_fit_every_gpu():
    size = {"VEC4": 16}
    for program in all_programs():
        assert sum(size[kind] for kind, _name in program.push_constants) <= 128


def test_code_is_left_out_where_a_scene_does_not_need_it():
    program = shader_source.steel_light_program(LightVariant(), SteelVariant())
    flags = {name for name, _value in program.defines}
    assert {"TG_POINTS", "TG_ONE_LOBE"} <= flags
    assert not flags & {"TG_SPOTS", "TG_SUNS", "TG_WORLD", "TG_MAPS", "TG_HADORI", "TG_ANISOTROPIC"}
    assert not {name for _kind, name in program.blocks} & {"spots", "areas", "wavelengths"}
    assert "rectangle_slices" not in program.fragment
    assert program.samplers == (("FLOAT_2D", "surface_buffer"),)


def test_shape_and_hadori_need_maps():
    lonely = SteelVariant(shape=True, hadori=True)
    assert lonely.defines() == {"TG_ONE_LOBE": ""}
    assert [name for _f, _k, name in lonely.targets] == ["surface"]


def test_a_missing_shader_names_its_path():
    with pytest.raises(shader_source.ShaderSourceError, match=r"viewport/nothing\.glsl"):
        shader_source.resolve("viewport/nothing.glsl")


def test_blocks_have_the_size_that_the_interface_states():
    text = shader_source.steel_light_program(LightVariant(), SteelVariant()).typedefs
    sizes = {"mat4": 16, "vec4": 4}
    structs: dict[str, int] = {}
    for name, body in re.findall(r"struct (\w+) \{(.*?)\};", text, re.DOTALL):
        total = 0
        for kind, count in re.findall(r"(\w+) \w+(?:\[([^\]]+)\])?;", body):
            number = math.prod(int(n) for n in count.split("*")) if count else 1
            total += number * (sizes[kind] if kind in sizes else structs[kind])
        structs[name] = total
    one = packing.light_passes((), World())[0]
    space = packing.view_space(Camera(np.eye(4), np.eye(4)), (4, 4))
    steel = SteelMaterial(
        "m", ((0.0, 0.0, 0.0),) * 8, (-1.0,) * 8, (False,) * 8, (0,) * 4, (0,) * 4
    )
    assert packing.frame_block(space, (0, 0, 0), 0, one.counts, 0.0).size == structs["TgFrame"]
    assert packing.lights_block(one, space).size == structs["TgLights"]
    assert packing.spots_block(one, space).size == structs["TgSpots"]
    assert packing.areas_block(one, space).size == structs["TgAreas"]
    assert packing.table_block([]).size == structs["TgTable"]
    assert packing.steel_block(steel).size == structs["TgSteel"]
    assert packing.plain_block(PlainMaterial()).size == structs["TgPlain"]
    # What every GPU that Blender runs on can bind.
    assert all(4 * size <= 65536 for name, size in structs.items() if name != "TgWavelengths")


def test_passes_hold_every_light_once_in_order():
    kinds = list(LightKind)
    lights = [
        Light(
            kinds[i % 5],
            power=float(i),
            spectrum=f"blackbody:{2000 + i % 40}",
            radius=0.1 * (i % 2),
            half_angle_rad=0.1 * (i % 2),
        )
        for i in range(700)
    ]
    passes = packing.light_passes(lights, World((1.0, 1.0, 1.0), "A"))
    powers = sorted(light.power for p in passes for light in (*p.lights, *p.areas))
    assert powers == list(range(1, 700))
    assert passes[0].spectra[0] == "A"
    order = {LightKind.POINT: 0, LightKind.SPOT: 1, LightKind.SUN: 2}
    for light_pass in passes:
        assert len(light_pass.lights) <= shader_source.LIGHT_CAPACITY
        assert len(light_pass.areas) <= shader_source.AREA_CAPACITY
        assert not any(light.sized for light in light_pass.lights)
        assert all(light.sized for light in light_pass.areas)
        assert len(light_pass.spectra) <= shader_source.TABLE_ROWS
        ranks = [order[light.kind] for light in light_pass.lights]
        assert ranks == sorted(ranks)
        counts = light_pass.counts
        assert counts.points + counts.spots + counts.suns == len(light_pass.lights)
        assert counts.areas == len(light_pass.areas)


def test_no_lights_is_one_empty_pass():
    (only,) = packing.light_passes((), World())
    assert only.lights == ()
    assert only.spectra == ()


def test_corners_that_agree_become_one_vertex():
    position = np.asarray([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], np.float32)
    corner_vertex = np.asarray([0, 1, 2, 0, 2, 3], np.int32)
    normal = np.tile(np.asarray((0.0, 0.0, 1.0), np.float32), (6, 1))
    arguments = (position, corner_vertex, np.arange(6).reshape(2, 3), np.arange(2))
    mesh = packing.build_mesh(*arguments, normal, None, None, None, None)
    assert len(mesh.position) == 4
    assert mesh.triangle_count == 2
    # Another part, another normal: the edge between the two triangles is double.
    parts = packing.build_mesh(*arguments, normal, np.asarray([1, 3]), None, None, None)
    assert len(parts.position) == 6
    tilted = normal.copy()
    tilted[3:] = (0.0, 0.1, 0.995)
    assert len(packing.build_mesh(*arguments, tilted, None, None, None, None).position) == 6


def test_a_closed_skin_is_told_from_an_open_an_inverted_and_a_folded_one():
    katana = togishi_core.katana({}, 0.02)
    start = katana.face_start
    corners = np.concatenate(
        [[(a, a + i, a + i + 1) for i in range(1, b - a - 1)] for a, b in itertools.pairwise(start)]
    )
    triangles = katana.corner_vertex[corners].astype(np.int64)
    place = katana.positions_mm.astype(np.float32)
    assert packing.is_closed(place, triangles)
    assert packing.is_closed(place + np.float32(1000.0), triangles)
    assert not packing.is_closed(place, triangles[1:])
    assert not packing.is_closed(place, triangles[:, ::-1])
    turned = triangles.copy()
    turned[0] = turned[0, ::-1]
    assert not packing.is_closed(place, turned)
    assert not packing.is_closed(place, np.concatenate([triangles, triangles]))
    nowhere = place.copy()
    nowhere[triangles[0, 0]] = np.inf
    assert not packing.is_closed(nowhere, triangles)


def test_meshes_with_nan_stay_finite():
    position = np.asarray([(0, 0, 0), (1, 0, np.nan), (1, np.inf, 0)], np.float32)
    normal = np.asarray([(0, 0, 1), (np.nan, 0, 0), (0, 0, 0)], np.float32)
    uv = np.asarray([(0, 0), (np.nan, 0), (0, np.inf)], np.float32)
    triangle = np.arange(3).reshape(1, 3)
    mesh = packing.build_mesh(
        position,
        np.arange(3, dtype=np.int32),
        triangle,
        np.zeros(1, int),
        normal,
        None,
        None,
        uv,
        None,
    )
    for values in (mesh.normal_part, mesh.uv, mesh.tangent):
        assert np.isfinite(values).all()
    np.testing.assert_allclose(np.linalg.norm(mesh.normal_part[:, :3], axis=1), 1.0, rtol=1e-6)


def test_tangents_follow_u():
    position = np.asarray([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], np.float32)
    triangles = np.asarray([(0, 1, 2), (0, 2, 3)])
    uv = np.asarray([(0.5, 0), (0.5, 1), (0, 1), (0, 0)], np.float32)  # u runs along -y
    along = tangents.uv_tangents(position, uv, triangles)
    np.testing.assert_allclose(along, np.tile((0.0, -1.0, 0.0), (4, 1)), atol=1e-6)
    assert (tangents.uv_tangents(position, np.zeros_like(uv), triangles) == 0.0).all()


def test_stored_tangents_turn_with_the_mesh():
    """A rotation or a mirroring that Blender applied to positions alone; a bent mesh is left as it is."""
    rng = np.random.default_rng(3)
    own = rng.normal((1.0, 0.02, 0.1), (0.0, 0.02, 0.1), (500, 3))
    own /= np.linalg.norm(own, axis=1)[:, None]
    chart = own + rng.normal(0.0, 0.01, own.shape)
    chart /= np.linalg.norm(chart, axis=1)[:, None]
    assert tangents.turned_with_mesh(own, chart) is own
    for turn in (np.linalg.qr(rng.normal(size=(3, 3)))[0], np.diag([1.0, 1.0, -1.0])[[2, 0, 1]]):
        turned = tangents.turned_with_mesh(own, chart @ turn.T)
        np.testing.assert_allclose(turned, own @ turn.T, atol=0.01)
    bent = rng.normal(size=own.shape)
    bent /= np.linalg.norm(bent, axis=1)[:, None]
    assert tangents.turned_with_mesh(own, bent) is own
    nothing = np.zeros_like(own)
    assert tangents.turned_with_mesh(nothing, chart) is nothing
    assert tangents.turned_with_mesh(own, nothing) is own


@pytest.mark.parametrize("samples", [1, 2, 4, 16, 64])
def test_samples_are_spread_about_the_centre(samples):
    offsets = sampling.pixel_offsets(samples, 1.5)
    assert offsets.shape == (samples, 2)
    assert np.abs(offsets).max() < 0.75
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=1e-6)
    assert len(np.unique(offsets[:, 0])) == samples
    np.testing.assert_array_equal(offsets, sampling.pixel_offsets(samples, 1.5))


def test_pixels_are_coarse_only_where_the_machine_is_slow():
    assert pace.next_step(1, 0.02) == 1
    assert pace.next_step(1, 0.5) == 2
    assert pace.next_step(2, 0.5) == 4
    assert pace.next_step(4, 5.0) == pace.COARSEST
    # Between the two limits it stays: it must not swing.
    assert pace.next_step(2, 0.05) == 2
    assert pace.next_step(2, 0.01) == 1
    assert pace.next_step(4, 0.01) == 2
    for seconds in (0.001, 0.03, 0.09, 0.3, 2.0):
        step = 1
        for _ in range(8):
            before, step = step, pace.next_step(step, seconds / step**2)
        assert pace.next_step(step, seconds / step**2) == step == before
