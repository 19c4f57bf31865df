"""The add-on's knowledge of versions, held to the table for the Blender that runs."""

from __future__ import annotations

import ast
import sys

import bpy
import numpy as np
import pytest
from togishi import blender_versions
from version_table import ROOT, row_of

ROW = row_of(bpy.app.version)


def test_python_is_the_tables():
    assert sys.version_info[:2] == ROW.python


def test_engine_of_eevee(empty_file):
    assert blender_versions.eevee_engine() == ROW.eevee
    empty_file.render.engine = blender_versions.eevee_engine()
    assert empty_file.render.engine == ROW.eevee


def test_lights_own_temperature_exposure_and_normalisation(empty_file):
    light = bpy.data.lights.new("lamp", "POINT")
    assert hasattr(light, "use_temperature") == ROW.light_temperature
    assert blender_versions.light_temperature_k(light) is None
    assert blender_versions.light_exposure_stops(light) == 0.0
    assert blender_versions.light_is_normalised(light)
    if ROW.light_temperature:
        light.use_temperature, light.temperature, light.exposure = True, 3200.0, 2.0
        light.normalize = False
        assert blender_versions.light_temperature_k(light) == 3200.0
        assert blender_versions.light_exposure_stops(light) == 2.0
        assert not blender_versions.light_is_normalised(light)


def test_custom_normals_come_back(empty_file):
    """Exactly where floats are kept, within the older versions' 16 bits elsewhere."""
    mesh = bpy.data.meshes.new("triangle")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.shade_smooth()
    normals = np.asarray([(0.1, 0.0, 1.0), (0.0, 0.2, 1.0), (-0.1, -0.1, 1.0)], np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    blender_versions.set_corner_normals(mesh, normals)
    assert (
        "custom_normal" in mesh.attributes
        and mesh.attributes["custom_normal"].data_type == "FLOAT_VECTOR"
    ) == (ROW.custom_normals)
    got = np.asarray([tuple(corner.vector) for corner in mesh.corner_normals], np.float32)
    np.testing.assert_allclose(got, normals, atol=1e-6 if ROW.custom_normals else 2e-4)


def test_paths_relative_to_the_file():
    expected = {"PATH_SUPPORTS_BLEND_RELATIVE"} if ROW.relative_path_option else set()
    assert expected == blender_versions.RELATIVE_PATH


def test_working_space(empty_file):
    assert hasattr(bpy.data, "colorspace") == ROW.working_spaces
    assert blender_versions.working_space() == "rec709"
    if ROW.working_spaces:
        bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=False)
        assert blender_versions.working_space() == "acescg_d65"


@pytest.mark.parametrize("identifier", ["PNG", "OPEN_EXR", "OPEN_EXR_MULTILAYER", "TIFF"])
def test_file_formats(empty_file, identifier):
    settings = empty_file.render.image_settings
    assert hasattr(settings, "media_type") == ROW.media_type
    blender_versions.set_file_format(settings, identifier)
    assert settings.file_format == identifier


def test_curves_of_an_action(empty_file):
    owner = bpy.data.objects.new("pivot", None)
    empty_file.collection.objects.link(owner)
    assert blender_versions.action_curves(owner) == []
    owner.rotation_euler.z = 1.0
    owner.keyframe_insert("rotation_euler", index=2, frame=1)
    assert ("fcurves" in bpy.types.Action.bl_rna.properties) == ROW.action_curves
    (curve,) = blender_versions.action_curves(owner)
    assert (curve.data_path, curve.array_index) == ("rotation_euler", 2)


def test_node_trees(empty_file):
    for owner in (bpy.data.materials.new("steel"), bpy.data.worlds.new("room")):
        blender_versions.use_nodes(owner)
        assert owner.node_tree is not None


def test_no_other_module_asks_for_the_version():
    """`bpy.app.version`, and asking what `bpy` has, belong into blender_versions.py."""
    for path in sorted((ROOT / "addon/togishi").rglob("*.py")):
        if path.name == "blender_versions.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr in ("version", "version_string"):
                assert ast.unparse(node.value) != "bpy.app", f"{path}:{node.lineno}"
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "hasattr":
                assert "bpy" not in ast.unparse(node.args[0]), f"{path}:{node.lineno}"
