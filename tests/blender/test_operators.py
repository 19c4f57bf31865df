"""Operators as scripts call them: what they make, what they refuse, undo and redo."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest
from ui_fixtures import DETAIL, add_katana, addon  # noqa: F401

pytestmark = pytest.mark.usefixtures("addon")

from mathutils import Vector  # noqa: E402
from togishi import blade_object, light_rig, map_files, map_images, properties  # noqa: E402
from togishi.core import light_presets, native  # noqa: E402
from togishi.core.katana_presets import PRESETS  # noqa: E402
from togishi.engine import mesh_read  # noqa: E402


def small_pattern(material: bpy.types.Material) -> None:
    material.togishi.pattern.width_px, material.togishi.pattern.height_px = 128, 32


@pytest.mark.parametrize("zukuri", ["shinogi", "hira", "shobu"])
def test_every_zukuri(zukuri):
    bpy.context.scene.cursor.location = (1.0, 2.0, 3.0)
    obj = add_katana(zukuri=zukuri)
    parameters = properties.katana_parameters(obj)
    assert parameters == native.core().katana_defaults(zukuri)
    assert tuple(obj.location) == (1.0, 2.0, 3.0)
    mesh = obj.data
    expected = native.core().katana(parameters, DETAIL)
    coordinates = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", coordinates)
    np.testing.assert_allclose(coordinates.reshape(-1, 3), expected.positions_mm * 1e-3, atol=1e-6)
    assert len(mesh.polygons) == len(expected.face_part)
    part = np.empty(len(mesh.polygons), np.int32)
    mesh.attributes["togishi_part"].data.foreach_get("value", part)
    np.testing.assert_array_equal(part, expected.face_part)
    for name, domain, kind in (
        ("togishi_part", "FACE", "INT"),
        ("togishi_tangent", "CORNER", "FLOAT_VECTOR"),
        ("togishi_s_mm", "POINT", "FLOAT"),
        ("togishi_t_mm", "POINT", "FLOAT"),
    ):
        assert (mesh.attributes[name].domain, mesh.attributes[name].data_type) == (domain, kind)
    assert mesh.uv_layers.active.name == "togishi_uv"
    normals = np.empty(len(mesh.loops) * 3, np.float32)
    mesh.corner_normals.foreach_get("vector", normals)
    if bpy.app.version >= (4, 5, 0):
        np.testing.assert_allclose(normals.reshape(-1, 3), expected.corner_normal, atol=1e-6)


@pytest.mark.parametrize("preset", [row.identifier for row in PRESETS])
def test_every_preset_is_a_blade(preset):
    obj = add_katana(preset=preset)
    assert obj.dimensions.x > 0.25
    assert blade_object.blade_material(obj) is not None


def test_dimensions_are_kept_in_metres_whatever_the_scenes_unit():
    bpy.context.scene.unit_settings.scale_length = 0.001
    obj = add_katana(nagasa_mm=700.0)
    assert 890 < obj.dimensions.x < 930


def test_impossible_dimensions_make_nothing():
    before = len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials)
    with pytest.raises(RuntimeError, match=r"No blade was made: .*kissaki"):
        bpy.ops.mesh.togishi_katana_add(kissaki_mm=390.0, nagasa_mm=500.0, detail=DETAIL)
    assert (len(bpy.data.objects), len(bpy.data.meshes), len(bpy.data.materials)) == before


def test_undo_and_redo():
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="start")
    add_katana()
    # Called from a script, operators leave the undo step to the caller.
    bpy.ops.ed.undo_push(message="katana")
    material = bpy.context.active_object.active_material
    material.togishi.ji.mu_t_deg = 7.0
    bpy.ops.ed.undo_push(message="edit")
    bpy.ops.ed.undo()
    assert bpy.data.materials[0].togishi.ji.mu_t_deg != 7.0
    bpy.ops.ed.undo()
    assert not bpy.data.objects
    bpy.ops.ed.redo()
    assert [obj.name for obj in bpy.data.objects] == ["Katana"]
    assert properties.katana_parameters(bpy.data.objects["Katana"])["nagasa_mm"] == 736.0


def test_edit_keeps_material_and_place():
    obj = add_katana()
    obj.location.x = 4.0
    material = obj.active_material
    assert bpy.ops.object.togishi_katana_edit(nagasa_mm=650.0) == {"FINISHED"}
    assert properties.katana_parameters(obj)["nagasa_mm"] == 650.0
    assert obj.location.x == 4.0
    assert obj.active_material == material
    assert len(obj.data.uv_layers) == 1
    vertices = len(obj.data.vertices)
    with pytest.raises(RuntimeError, match="left as it is"):
        bpy.ops.object.togishi_katana_edit(motohaba_mm=9.0, sakihaba_mm=70.0)
    assert len(obj.data.vertices) == vertices


def test_ridges_are_sharp_edges_and_normals_stay():
    """Cycles blurs custom normals over edges that are not marked."""
    obj = add_katana(detail=0.05)
    mesh = obj.data
    katana = blade_object.make(properties.katana_parameters(obj), 0.05)
    sharp = np.empty(len(mesh.edges), bool)
    mesh.attributes["sharp_edge"].data.foreach_get("value", sharp)
    part = {tuple(sorted(key)): [] for key in mesh.edge_keys}
    for face in mesh.polygons:
        for key in face.edge_keys:
            part[tuple(sorted(key))].append(katana.face_part[face.index])
    marked = {
        tuple(sorted(key)) for key, is_sharp in zip(mesh.edge_keys, sharp, strict=True) if is_sharp
    }
    ji, shinogi_ji, ha = 1, 2, 3
    shinogi = {key for key, parts in part.items() if sorted(parts) == [ji, shinogi_ji]}
    assert len(shinogi) > 50
    assert shinogi <= marked
    # The border of ha and ji is the hamon: no ridge. Within a part nothing is but in the rounded mune and nakago.
    assert not marked & {key for key, parts in part.items() if sorted(parts) == [ji, ha]}
    assert not marked & {
        key for key, parts in part.items() if parts == [ji, ji] and key not in shinogi
    }
    shown = np.empty(3 * len(mesh.loops), np.float32)
    mesh.corner_normals.foreach_get("vector", shown)
    cosine = (shown.reshape(-1, 3) * katana.corner_normal).sum(axis=1)
    assert cosine.min() > (0.999999 if bpy.app.version >= (4, 5, 0) else 0.9999)


def test_assign_to_a_plain_mesh():
    bpy.ops.mesh.primitive_plane_add()
    assert bpy.ops.object.togishi_material_assign() == {"FINISHED"}
    first = bpy.context.active_object.active_material
    assert properties.is_blade(first)
    bpy.ops.object.togishi_material_assign()
    assert bpy.context.active_object.active_material == first


def test_material_file_round_trip(tmp_path):
    obj = add_katana()
    material = obj.active_material
    material.togishi.metal_choice = "iron_querry"
    material.togishi.ha.mu_b_deg = 4.25
    material.togishi.nakago_ior = 1.625
    wanted = properties.material_dict(material)
    path = tmp_path / "steel.toml"
    bpy.ops.material.togishi_save(filepath=str(path))
    properties.set_material_dict(material, native.core().default_material())
    assert properties.material_dict(material) != wanted
    bpy.ops.material.togishi_load(filepath=str(path))
    assert properties.material_dict(material) == wanted


def test_bad_material_file_changes_nothing(tmp_path):
    material = add_katana().active_material
    before = properties.material_dict(material)
    path = tmp_path / "bad.toml"
    path.write_text("format = 1\nname = 'x'\nmetal = 'cheese'\n")
    with pytest.raises(RuntimeError, match=r"left as it was|left as it is"):
        bpy.ops.material.togishi_load(filepath=str(path))
    assert properties.material_dict(material) == before


def test_saving_where_nothing_can_be_written():
    add_katana()
    with pytest.raises(RuntimeError, match="Nothing was saved"):
        bpy.ops.material.togishi_save(filepath="/proc/no/steel.toml")


def test_baking_writes_the_cores_maps():
    obj = add_katana()
    material = obj.active_material
    small_pattern(material)
    assert bpy.ops.material.togishi_pattern_bake() == {"FINISHED"}
    core = native.core()
    expected = core.steel_pattern(
        properties.katana_parameters(obj),
        properties.material_dict(material),
        core.steel_defaults(),
        128,
        32,
    )
    maps = map_images.read(material)
    for name in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h", "ji.e1", "ha.e2"):
        # The material's numbers pass through single precision.
        wanted = np.broadcast_to(expected[name], (32, 128))
        np.testing.assert_allclose(maps[name], wanted, atol=1e-6, err_msg=name)
    lobes, shape = properties.blade_images(material)
    for image in (lobes, shape):
        assert image.is_float
        assert image.colorspace_settings.name == "Non-Color"
        assert image.packed_file is not None
    first = maps["w"]
    material.togishi.pattern.seed = 99
    bpy.ops.material.togishi_pattern_bake()
    assert properties.blade_images(material)[0] == lobes
    assert not np.array_equal(map_images.read(material)["w"], first)


def test_maps_through_a_file(tmp_path):
    material = add_katana().active_material
    rng = np.random.default_rng(0)
    maps = {
        n: rng.random((6, 10), np.float32)
        for n in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h", "ji.e1", "ji.e2", "ha.e1", "ha.e2")
    }
    map_images.assign(material, maps)
    path = tmp_path / "maps.exr"
    bpy.ops.material.togishi_maps_export(filepath=str(path))
    bpy.ops.material.togishi_maps_clear()
    assert map_images.read(material) == {}
    bpy.ops.material.togishi_maps_import(filepath=str(path))
    again = map_images.read(material)
    for name, values in maps.items():
        np.testing.assert_array_equal(again[name], values, err_msg=name)


@pytest.mark.parametrize("turn_deg", [(0.0, 0.0, 90.0), (40.0, -70.0, 20.0), (0.0, 0.0, 0.0)])
def test_strokes_follow_an_applied_rotation(turn_deg):
    """Blender turns positions and normals of a mesh, not its attributes: the engine and, once baked again, the node
    groups have the strokes along the blade all the same."""
    obj = add_katana()

    def stored():
        values = np.empty(len(obj.data.loops) * 3, np.float32)
        obj.data.attributes["togishi_tangent"].data.foreach_get("vector", values)
        return values.reshape(-1, 3)

    before = stored()
    drawn_before = mesh_read.read_mesh(obj.data, frozenset()).tangent
    obj.rotation_euler = [np.radians(angle) for angle in turn_deg]
    turn = np.array(obj.rotation_euler.to_matrix())
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=False)
    drawn = mesh_read.read_mesh(obj.data, frozenset()).tangent
    off = np.linalg.norm(drawn - drawn_before @ turn.T, axis=1)
    assert np.median(off) < 0.002 and np.percentile(off, 99) < 0.02
    bpy.ops.material.togishi_nodes_connect()
    off = np.linalg.norm(stored() - before @ turn.T, axis=1)
    assert np.median(off) < 0.002 and np.percentile(off, 99) < 0.02
    bpy.ops.material.togishi_nodes_connect()
    again = np.linalg.norm(stored() - before @ turn.T, axis=1)
    np.testing.assert_array_equal(off, again)


def test_exported_maps_are_what_the_command_reads(tmp_path):
    """All mip levels, by covariance, in the file that `togishi info` knows."""
    built = Path(__file__).resolve().parents[2] / "build/release/cpp_core/cli/togishi"
    command = os.environ.get("TOGISHI_CLI", built)
    rng = np.random.default_rng(1)
    maps = {n: rng.random((96, 200), np.float32) for n in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w")}
    maps["h"] = np.full((1, 1), 0.25, np.float32)
    (path,) = map_files.save(maps, tmp_path / "maps.exr")
    done = subprocess.run([command, "info", str(path), "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    facts = json.loads(done.stdout)
    assert facts["size"] == [200, 96] and facts["levels"] == 8 and facts["checks"] == "passed"
    assert sorted(facts["channels"]) == ["h (constant)", "ha.ln_mu_deg", "ji.ln_mu_deg", "w"]
    again = map_files.load(path)
    np.testing.assert_array_equal(again["w"], maps["w"])


def test_maps_without_open_image_io(tmp_path, monkeypatch):
    monkeypatch.setattr(map_files, "open_image_io", lambda: None)
    rng = np.random.default_rng(0)
    maps = {
        n: rng.random((5, 7), np.float32)
        for n in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h", "ji.e1", "ji.e2", "ha.e1", "ha.e2")
    }
    written = map_files.save(maps, tmp_path / "maps.exr")
    assert [p.name for p in written] == ["maps.lobes.exr", "maps.shape.exr"]
    again = map_files.load(tmp_path / "maps.exr")
    for name, values in maps.items():
        np.testing.assert_allclose(again[name], values, atol=1e-7, err_msg=name)


def test_foreign_and_truncated_map_files_change_nothing(tmp_path):
    material = add_katana().active_material
    (tmp_path / "not.exr").write_bytes(b"P6 1 1 255 abc")
    maps = {n: np.full((64, 64), 0.5, np.float32) for n in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w")}
    map_files.save(maps, tmp_path / "whole.exr")
    data = (tmp_path / "whole.exr").read_bytes()
    (tmp_path / "half.exr").write_bytes(data[: len(data) // 2])
    map_files.save({**maps, "w": maps["w"]}, tmp_path / "named.exr")
    for name in ("not.exr", "half.exr", "absent.exr"):
        with pytest.raises(RuntimeError, match=r"left as they are: .*" + name.split(".")[0]):
            bpy.ops.material.togishi_maps_import(filepath=str(tmp_path / name))
        assert material.togishi.lobes_image is None


@pytest.mark.parametrize("preset", [row.identifier for row in light_presets.PRESETS])
def test_light_presets_reach_the_blade(preset):
    """Every lamp stands in front of the blade, looks at it, has a spectrum the core knows, and an angle off the
    mirror direction as the preset says."""
    obj = add_katana()
    bpy.context.view_layer.update()
    bpy.ops.object.togishi_light_preset(preset=preset)
    chosen = light_presets.preset(preset)
    lights = [o for o in bpy.data.objects if o.type == "LIGHT"]
    assert len(lights) == len(chosen.lamps)
    frame = light_rig.frame_of(obj)
    bpy.context.view_layer.update()
    for light in lights:
        native.core().light_rgb(properties.light_spectrum(light.data))
        to_light = light.matrix_world.translation - frame.middle
        assert to_light.dot(frame.view) > 0.1 * to_light.length
        beam = light.matrix_world.to_3x3() @ Vector((0.0, 0.0, -1.0))
        assert beam.dot(-to_light) > 0.0
    bpy.ops.object.togishi_light_preset(preset=preset)
    assert len([o for o in bpy.data.objects if o.type == "LIGHT"]) == len(chosen.lamps)


def test_soft_box_lies_along_the_blade():
    obj = add_katana()
    (box,) = light_rig.add(bpy.context.scene, obj, "SOFT_BOX")
    bpy.context.view_layer.update()
    frame = light_rig.frame_of(obj)
    assert box.data.shape == "RECTANGLE"
    assert box.data.size == pytest.approx(2.4 * frame.half_length)
    assert box.data.size_y == pytest.approx(0.4 * frame.half_length)
    turned = box.matrix_world.to_3x3()
    assert abs((turned @ Vector((1.0, 0.0, 0.0))).dot(frame.along)) > 0.99
    # Its face looks at the blade.
    towards = (frame.middle - box.location).normalized()
    assert (turned @ Vector((0.0, 0.0, -1.0))).dot(towards) > 0.99


def test_inspection_lamp_moves_along_the_blade_and_leaves_nothing_behind():
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 10, 50
    scene.frame_set(10)
    obj = add_katana()
    (bulb,) = light_rig.add(scene, obj, "INSPECTION")
    frame = light_rig.frame_of(obj)
    places = []
    for number in (10, 30, 50):
        scene.frame_set(number)
        places.append((bulb.matrix_world.translation - frame.middle).dot(frame.along))
    half = frame.half_length
    assert places == pytest.approx([-0.75 * half, 0.0, 0.75 * half], abs=5e-3)
    light_rig.clear(scene)
    assert not bpy.data.actions


def test_preset_irradiance_does_not_depend_on_the_blades_length():
    sums = []
    for nagasa in (400.0, 800.0):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        obj = add_katana(nagasa_mm=nagasa)
        bpy.context.view_layer.update()
        made = light_rig.add(bpy.context.scene, obj, "TUNGSTEN_CASE")
        frame = light_rig.frame_of(obj)
        sums.append(sum(o.data.energy / (o.location - frame.middle).length_squared for o in made))
    assert sums[0] == pytest.approx(sums[1], rel=0.01)
