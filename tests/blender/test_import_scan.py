"""A scanned sword imported: read by Blender, measured, with parts, chart, maps and record; refused where it is none."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
import pytest


def write_ply(path: Path, places, triangles) -> None:
    """Binary, little-endian."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(places)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), [("count", "u1"), ("corner", "<i4", 3)])
    faces["count"] = 3
    faces["corner"] = triangles
    path.write_bytes(header.encode() + np.asarray(places, "<f4").tobytes() + faces.tobytes())


@pytest.fixture(scope="module")
def scan_file(addon, tmp_path_factory) -> Path:
    """A generated wakizashi in centimetres, turned, 0.02 mm of noise, under a name with a quote and Japanese."""
    from togishi.core import native

    katana = native.core().katana(
        {"nagasa_mm": 455, "nakago_mm": 140, "sori_mm": 9, "motohaba_mm": 28}, detail=0.15
    )
    places = np.array(katana.positions_mm)
    start, corner = np.array(katana.face_start), np.array(katana.corner_vertex)
    triangles = np.array(
        [
            (corner[a], corner[k], corner[k + 1])
            for a, b in pairwise(start)
            for k in range(a + 1, b - 1)
        ]
    )
    random = np.random.default_rng(1)
    places += random.normal(0, 0.02, places.shape)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    path = tmp_path_factory.mktemp("scan") / "脇差 'Nr. 1'.ply"
    write_ply(path, places @ turn.T / 10 + (20, -10, 5), triangles)
    return path


def imported(scan_file: Path, **settings):
    result = bpy.ops.import_scene.togishi_scan(
        filepath=str(scan_file), texture_px=512, replicates=2, object_id="T-1", **settings
    )
    assert result == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def dimension(obj, key: str) -> dict:
    return next(
        d for d in json.loads(obj.togishi.scan.report_json)["dimensions"] if d["key"] == key
    )


def test_a_scan_becomes_a_blade(empty_file, scan_file):
    from togishi import properties

    obj = imported(scan_file)
    assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(455, abs=0.5)
    assert dimension(obj, "motohaba_mm")["value"] == pytest.approx(28, abs=0.15)
    part = np.empty(len(obj.data.polygons), np.int32)
    obj.data.attributes["togishi_part"].data.foreach_get("value", part)
    assert set(part) >= {1, 2, 3, 4, 7}
    uv = np.empty(2 * len(obj.data.loops), np.float32)
    obj.data.uv_layers["togishi_uv"].data.foreach_get("uv", uv)
    assert uv.min() >= -0.01 and uv.max() <= 1.01
    # Blade axes, in metres: the machi in the origin, the tip on +x.
    places = np.array([v.co for v in obj.data.vertices])
    assert places[:, 0].max() == pytest.approx(0.455, abs=1e-3)
    assert abs(places[:, 1]).max() < 0.006
    record = json.loads(obj.togishi.scan.record.as_string())
    assert "T-1" in json.dumps(record) and obj.togishi.scan.sha256 in json.dumps(record)
    # The scan's fine shape is in the material; a pattern can be laid over its chart.
    image = obj.data.materials[0].togishi.normal_image
    assert image is not None and image.size[0] == 512
    recipe = properties.blade_recipe(obj)
    assert recipe is not None and recipe["frame"]["nagasa_mm"] == pytest.approx(456, abs=2)
    # Nothing else of the reading is left.
    assert [o.name for o in bpy.data.objects] == [obj.name]

    # Read again with its unit told: the same.
    nagasa = dimension(obj, "nagasa_mm")["value"]
    assert bpy.ops.object.togishi_scan_correct(change="unit", unit="cm") == {"FINISHED"}
    assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(nagasa, abs=1e-6)


def test_what_is_no_blade_is_refused_and_leaves_nothing(empty_file, tmp_path):
    bpy.ops.mesh.primitive_cube_add(size=300)
    cube = bpy.context.active_object
    places = np.array([v.co for v in cube.data.vertices])
    cube.data.calc_loop_triangles()
    triangles = np.array([t.vertices for t in cube.data.loop_triangles])
    write_ply(tmp_path / "cube.ply", places, triangles)
    before = {o.name for o in bpy.data.objects}, len(bpy.data.meshes), len(bpy.data.images)
    with pytest.raises(RuntimeError, match=r"The scan was not imported: .*[?]"):
        bpy.ops.import_scene.togishi_scan(filepath=str(tmp_path / "cube.ply"))
    with pytest.raises(RuntimeError, match=r"The scan was not imported: .*none.ply"):
        bpy.ops.import_scene.togishi_scan(filepath=str(tmp_path / "none.ply"))
    (tmp_path / "broken.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 9")
    with pytest.raises(RuntimeError, match=r"The scan was not imported: .*broken.ply"):
        bpy.ops.import_scene.togishi_scan(filepath=str(tmp_path / "broken.ply"))
    assert before == (
        {o.name for o in bpy.data.objects},
        len(bpy.data.meshes),
        len(bpy.data.images),
    )
