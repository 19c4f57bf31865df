"""A scanned sword imported: read by Blender, measured, with parts, chart, maps and record; refused where it is none."""

from __future__ import annotations

import json
import resource
import struct
import time
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
import pytest


def write_ply(path: Path, places, triangles, kind: str = "f4", colour=None) -> None:
    """Binary, little-endian; coordinates as floats or doubles (f8); colour: RGB of all vertices."""
    word = {"f4": "float", "f8": "double"}[kind]
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(places)}\nproperty {word} x\nproperty {word} y\nproperty {word} z\n"
        + "".join(f"property uchar {name}\n" for name in ("red", "green", "blue") if colour)
        + f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), [("count", "u1"), ("corner", "<i4", 3)])
    faces["count"] = 3
    faces["corner"] = triangles
    rows = np.empty(len(places), [("at", f"<{kind}", 3), ("colour", "u1", 3 if colour else 0)])
    rows["at"] = places
    if colour:
        rows["colour"] = colour
    path.write_bytes(header.encode() + rows.tobytes() + faces.tobytes())


def wakizashi():
    """Places in mm and triangles of a generated wakizashi with 0.02 mm of noise, in its own axes."""
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
    return places + np.random.default_rng(1).normal(0, 0.02, places.shape), triangles


def cube(centre_mm, size_mm: float):
    """Places and triangles."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [(q[0], q[i], q[i + 1]) for q in sides for i in (1, 2)]
    return centre_mm + 0.5 * size_mm * corners, np.array(triangles)


def both(one, other):
    """Two meshes as one."""
    return np.concatenate([one[0], other[0]]), np.concatenate([one[1], other[1] + len(one[0])])


@pytest.fixture(scope="module")
def scan_file(addon, tmp_path_factory) -> Path:
    """A wakizashi in centimetres, turned, under a name with a quote and Japanese."""
    places, triangles = wakizashi()
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
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


def test_pieces_kept_aside_follow_a_correction(empty_file, tmp_path):
    places, triangles = both(wakizashi(), cube((100.0, 40.0, 60.0), 20.0))
    write_ply(tmp_path / "stand.ply", places / 25.4, triangles)
    obj = imported(tmp_path / "stand.ply", unit="inch")
    (stand,) = obj.children
    assert stand.users_collection[0].hide_render

    def middle(piece):
        return np.mean([v.co for v in piece.data.vertices], axis=0)

    before = middle(stand)
    assert before[0] == pytest.approx(0.1, abs=2e-3)
    assert before[2] == pytest.approx(0.06, abs=4e-3)
    stand.name = "Stand"
    # It was in cm: blade and stand are as much smaller.
    assert bpy.ops.object.togishi_scan_correct(change="unit", unit="cm") == {"FINISHED"}
    (stand,) = obj.children
    assert stand.name == "Stand"
    assert middle(stand) == pytest.approx(before / 2.54, abs=1e-3)
    assert len(bpy.data.collections) == 2


def paint(obj, x_range_m, part: str) -> None:
    """By the operator, the faces whose middle lies between two places along the blade."""
    import bmesh  # there once bpy is

    low, high = x_range_m
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="DESELECT")
    for face in bmesh.from_edit_mesh(obj.data).faces:
        face.select_set(low < face.calc_center_median().x < high)
    assert bpy.ops.mesh.togishi_scan_paint_part(part=part) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")


def painted_share(obj, x_range_m, part: int) -> tuple[float, float]:
    """Of the faces between two places along the blade, and of those elsewhere, which have that part."""
    middle = np.empty(3 * len(obj.data.polygons), np.float32)
    obj.data.polygons.foreach_get("center", middle)
    x = middle.reshape(-1, 3)[:, 0]
    found = np.empty(len(obj.data.polygons), np.int32)
    obj.data.attributes["togishi_part"].data.foreach_get("value", found)
    inside = (x > x_range_m[0]) & (x < x_range_m[1])
    return float((found[inside] == part).mean()), float((found[~inside] == part).mean())


def test_painted_parts_stay_far_from_zero_and_in_another_scene_unit(empty_file, tmp_path):
    places, triangles = wakizashi()
    # 100 km away: a float has steps of 8 mm there.
    write_ply(tmp_path / "far.ply", places + np.array((1e8, -5e7, 2e7)), triangles, "f8")
    obj = imported(tmp_path / "far.ply", unit="mm")
    assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(455, abs=0.5)
    paint(obj, (0.2, 0.25), "0")
    bpy.context.scene.unit_settings.scale_length = 0.01
    assert bpy.ops.object.togishi_scan_correct(change="unit", unit="mm") == {"FINISHED"}
    inside, elsewhere = painted_share(obj, (20.5, 24.5), 0)
    assert inside > 0.98
    assert elsewhere < 0.1


def place(handle, moved_m, degrees: float = 0.0) -> None:
    """From where it is, moved in its parent's axes and turned about its X."""
    handle.location = np.array(handle.location) + moved_m
    handle.rotation_euler[0] += np.radians(degrees)


def test_a_pose_handle_moves_the_machi(empty_file, scan_file):
    from togishi import properties

    obj = imported(scan_file)
    obj.matrix_world = ((0, -2, 0, 3), (2, 0, 0, 0), (0, 0, 2, 1), (0, 0, 0, 1))
    nagasa = dimension(obj, "nagasa_mm")["value"]
    nakago = dimension(obj, "nakago_mm")["value"]
    assert bpy.ops.object.togishi_scan_handle() == {"FINISHED"}
    handle = bpy.context.view_layer.objects.active
    assert handle.parent == obj and handle.type == "EMPTY"
    bpy.context.view_layer.update()
    assert np.array(handle.matrix_world) == pytest.approx(np.array(obj.matrix_world))
    # There is one only; a blade whose handle is active is the one that is corrected.
    assert bpy.ops.object.togishi_scan_handle() == {"FINISHED"}
    assert len(bpy.data.objects) == 2
    # Not moved: nothing is done.
    with pytest.raises(RuntimeError, match="neither moved nor turned"):
        bpy.ops.object.togishi_scan_correct(change="handle")
    # 6 mm towards the tip, off the surface and askew: where it stands along the blade counts.
    place(handle, (0.006, 0.015, 0.0), 20)
    assert bpy.ops.object.togishi_scan_correct(change="handle") == {"FINISHED"}
    assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(nagasa - 6, abs=0.3)
    assert dimension(obj, "nakago_mm")["value"] == pytest.approx(nakago + 6, abs=0.3)
    assert "given" in dimension(obj, "nagasa_mm")["note"]
    places = np.array([v.co for v in obj.data.vertices])
    assert places[:, 0].max() == pytest.approx((nagasa - 6) / 1000, abs=1e-3)
    frame = properties.blade_recipe(obj)["frame"]
    assert frame["nagasa_mm"] == pytest.approx(nagasa - 6, abs=2)
    assert "given machi x" in obj.togishi.scan.record.as_string()
    # The handle is at the new machi; from there it goes on.
    assert handle.matrix_basis == handle.matrix_basis.Identity(4)
    place(handle, (-0.002, 0.0, 0.0))
    assert bpy.ops.object.togishi_scan_correct(change="handle") == {"FINISHED"}
    assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(nagasa - 4, abs=0.3)
    assert bpy.ops.object.togishi_scan_correct(change="as_found") == {"FINISHED"}
    assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(nagasa, abs=1e-6)


def test_a_handle_turned_about_that_finds_no_blade_changes_nothing(empty_file, scan_file):
    obj = imported(scan_file)
    before = obj.togishi.scan.report_json, obj.togishi.scan.options_json
    with pytest.raises(RuntimeError, match="There is no pose handle"):
        bpy.ops.object.togishi_scan_correct(change="handle")
    assert bpy.ops.object.togishi_scan_handle() == {"FINISHED"}
    handle = bpy.context.view_layer.objects.active
    place(handle, (0.0, 0.0, 0.0), 175)
    with pytest.raises(RuntimeError, match="The scan was not imported"):
        bpy.ops.object.togishi_scan_correct(change="handle")
    # Beyond the tip there is no machi.
    place(handle, (0.6, 0.0, 0.0), -175)
    with pytest.raises(RuntimeError, match=r"machi is .* a place on the blade"):
        bpy.ops.object.togishi_scan_correct(change="handle")
    assert before == (obj.togishi.scan.report_json, obj.togishi.scan.options_json)
    assert handle.location.x == pytest.approx(0.6)


def test_a_yokote_is_given_or_denied(empty_file, scan_file):
    obj = imported(scan_file)
    kissaki = dimension(obj, "kissaki_mm")["value"]
    assert bpy.ops.object.togishi_scan_correct(change="yokote", kissaki_mm=40) == {"FINISHED"}
    assert dimension(obj, "kissaki_mm")["value"] == pytest.approx(40, abs=1e-3)
    assert bpy.ops.object.togishi_scan_correct(change="yokote", kissaki_mm=0) == {"FINISHED"}
    report = json.loads(obj.togishi.scan.report_json)
    assert report["zukuri"] == "shobu"
    assert not [d for d in report["dimensions"] if d["key"].startswith(("saki", "kissaki"))]
    assert bpy.ops.object.togishi_scan_correct(change="as_found") == {"FINISHED"}
    assert dimension(obj, "kissaki_mm")["value"] == pytest.approx(kissaki, abs=1e-6)


def test_no_painting_needs_a_selection(empty_file, scan_file):
    imported(scan_file)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="No faces are selected"):
        bpy.ops.mesh.togishi_scan_paint_part(part="1")
    bpy.ops.object.mode_set(mode="OBJECT")


def glb(path: Path, document: dict, binary: bytes, length: int | None = None) -> None:
    """length: what the binary chunk says of itself, where that is a lie."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary) if length is None else length, b"BIN\0") + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def triangle_glb(path: Path, length: int | None = None, **changes: dict) -> None:
    """One triangle; changes: of the first accessor, bufferView or buffer."""
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
    }
    for part, values in changes.items():
        document[part][0].update(values)
    document["accessors"][0].update({"min": [0, 0, 0], "max": [1, 1, 0]})
    glb(path, document, np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "<f4").tobytes(), length)


PLY_FACES = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    b"property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n"
)
# What is wrong with a file: its name, its bytes, what the sentence has to name.
BROKEN_BYTES = {
    "many.ply": (PLY_FACES % 10**12 + b"\0" * 100, r"element .face. is 1000000000000 rows"),
    "cut.ply": (PLY_FACES % 1 + b"\0" * 40, r"rows.*is it cut off"),
    "nan.ply": (
        PLY_FACES % 1 + b"\xff" * 12 + b"\0" * 24 + b"\3" + struct.pack("<3i", 0, 1, 2),
        r"vertex 1.*finite",
    ),
    "index.ply": (
        PLY_FACES % 1 + np.eye(3, dtype="<f4").tobytes() + b"\3" + struct.pack("<3i", 0, 1, 9),
        r"face 1: vertex index is 9",
    ),
    "many.stl": (b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 500, r"size.*4294967295 tri"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", r"triangle 1: vertex index is 6"),
    "words.gltf": (b"{", r"JSON.*well formed"),
    "beside.gltf": (
        b'{"buffers": [{"byteLength": 1000000000000, "uri": "../many.bin"}]}',
        r"uri.*folder",
    ),
    "inline.gltf": (
        b'{"buffers": [{"byteLength": 1000000000000, '
        b'"uri": "data:application/octet-stream;base64,AAAA"}]}',
        r"byteLength is 1000000000000.*data: URI",
    ),
}
BROKEN_GLB = {
    "chunk.glb": ({"length": 2**32 - 8}, r"chunk is 4294967288"),
    "buffer.glb": ({"buffers": {"byteLength": 10**12}}, r"byteLength is 1000000000000.*chunk"),
    "view.glb": (
        {"bufferViews": {"byteLength": 10**12}},
        r"buffer view 0: byteLength is 10{12} from 0",
    ),
    "accessor.glb": ({"accessors": {"count": 10**7}}, r"accessor 0: count is 10000000.*36 bytes"),
    "zeros.glb": ({"accessors": {"count": 10**12}}, r"accessor 0: count is 10{12}.*at most"),
}


@pytest.mark.parametrize("name", [*BROKEN_BYTES, *BROKEN_GLB])
def test_files_that_lie_are_refused_before_blender_reads_them(
    empty_file, tmp_path, monkeypatch, name
):
    from togishi import scan_read

    path = tmp_path / name
    if name in BROKEN_GLB:
        changes, sentence = BROKEN_GLB[name]
        triangle_glb(path, **changes)
    else:
        content, sentence = BROKEN_BYTES[name]
        path.write_bytes(content)
    monkeypatch.setattr(scan_read, "_gather", None)  # not reached
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + 2**29, hard))  # half a GiB more, as ulimit -v
    started = time.monotonic()
    try:
        with pytest.raises(RuntimeError, match=rf"not imported: .*{name}.*{sentence}") as refused:
            bpy.ops.import_scene.togishi_scan(filepath=str(path))
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    assert time.monotonic() - started < 2
    assert "Traceback" not in str(refused.value) and "allowed" in str(refused.value)
    assert not bpy.data.objects and not bpy.data.meshes


def test_what_blender_cannot_read_is_told_in_one_line(empty_file, tmp_path):
    triangle_glb(tmp_path / "lost.glb", meshes={"primitives": [{"attributes": {"POSITION": 7}}]})
    with pytest.raises(
        RuntimeError, match=r"lost\.glb: file: Blender could not read it: "
    ) as found:
        bpy.ops.import_scene.togishi_scan(filepath=str(tmp_path / "lost.glb"))
    assert "Traceback" not in str(found.value)
    assert not bpy.data.objects and not bpy.data.meshes


def test_a_format_that_is_none_is_refused(empty_file, tmp_path):
    (tmp_path / "scan.xyz").write_text("0 0 0\n")
    with pytest.raises(RuntimeError, match=r"scan\.xyz: file = '\.xyz'; allowed: \.ply, \.obj"):
        bpy.ops.import_scene.togishi_scan(filepath=str(tmp_path / "scan.xyz"))


def test_obj_stl_and_glb_are_the_same_blade(empty_file, tmp_path):
    places, triangles = wakizashi()
    mesh = bpy.data.meshes.new("scan")
    mesh.from_pydata(places / 1000, [], triangles)
    colours = mesh.color_attributes.new("Color", "BYTE_COLOR", "CORNER")
    red = np.tile(np.array([1.0, 0.0, 0.0, 1.0], np.float32), len(mesh.loops))
    colours.data.foreach_set("color_srgb", red)
    scan = bpy.data.objects.new("scan", mesh)
    bpy.context.scene.collection.objects.link(scan)
    scan.select_set(True)
    bpy.context.view_layer.objects.active = scan
    files = [tmp_path / f"scan '{kind}' 刀.{kind}" for kind in ("obj", "stl", "glb")]
    bpy.ops.wm.obj_export(filepath=str(files[0]), export_materials=False)
    bpy.ops.wm.stl_export(filepath=str(files[1]))
    bpy.ops.export_scene.gltf(
        filepath=str(files[2]), export_vertex_color="ACTIVE", export_all_vertex_colors=False
    )
    for file in files:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        obj = imported(file, unit="m")
        assert dimension(obj, "nagasa_mm")["value"] == pytest.approx(455, abs=0.5), file
        assert [o.name for o in bpy.data.objects] == [obj.name]
        image = obj.togishi.scan.colour_image
        assert (image is not None) == (file.suffix == ".glb")
        if image is not None:
            pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
            image.pixels.foreach_get(pixels)
            pixels = pixels.reshape(-1, 4)
            assert pixels[pixels[:, 3] > 0, :3].max(axis=0) == pytest.approx((1, 0, 0), abs=0.01)


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
@pytest.mark.parametrize("kind", ["BYTE_COLOR", "FLOAT_COLOR"])
def test_colours_of_either_kind_are_read_at_vertices_and_corners(empty_file, kind, domain):
    from togishi import scan_read

    mesh = bpy.data.meshes.new("two triangles")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [], [(0, 1, 2), (1, 3, 2)])
    colours = mesh.color_attributes.new("Color", kind, domain)
    for item in colours.data:
        item.color_srgb = (0.2, 0.5, 1.0, 1.0)
    assert scan_read._colours(mesh) == pytest.approx(np.tile([51, 128, 255, 255], (4, 1)), abs=1)
    # A stand without colours leaves the blade its own.
    plain = bpy.data.meshes.new("plain")
    plain.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    both_colours = scan_read._all_colours([plain, mesh])
    assert both_colours.shape == (7, 4) and (both_colours[:3] == 255).all()
    assert scan_read._all_colours([plain]) is None


def test_an_import_is_one_step_of_undo(empty_file, scan_file):
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    name = imported(scan_file).name
    bpy.ops.ed.undo_push(message="imported")
    images = len(bpy.data.images)
    assert name in bpy.data.objects and images
    bpy.ops.ed.undo()
    assert not bpy.data.objects and not bpy.data.meshes
    bpy.ops.ed.redo()
    obj = bpy.data.objects[name]
    assert obj.togishi.scan.record is not None and len(bpy.data.images) == images
    assert obj.togishi.scan.normal_image.has_data or obj.togishi.scan.normal_image.packed_file


def test_the_record_is_saved_where_told(empty_file, scan_file, tmp_path):
    obj = imported(scan_file)
    path = tmp_path / "記録 'of' the \"blade\".jsonld"
    assert bpy.ops.export_scene.togishi_scan_record(filepath=str(path)) == {"FINISHED"}
    assert json.loads(path.read_text(encoding="utf-8")) == json.loads(
        obj.togishi.scan.record.as_string()
    )
    with pytest.raises(RuntimeError, match=r"The record was not saved: .*no folder"):
        bpy.ops.export_scene.togishi_scan_record(filepath=str(tmp_path / "no folder" / "r.jsonld"))


def test_colours_and_relief_lie_ready_in_the_material(empty_file, tmp_path):
    from togishi.nodes import scan_images, steel_group

    places, triangles = wakizashi()
    write_ply(tmp_path / "red.ply", places, triangles, colour=(200, 30, 20))
    bpy.context.scene.unit_settings.scale_length = 0.01
    obj = imported(tmp_path / "red.ply", unit="mm")
    scan, tree = obj.togishi.scan, obj.data.materials[0].node_tree
    picture = tree.nodes.active
    assert picture.name == scan_images.COLOUR and picture.image == scan.colour_image
    assert picture.inputs["Vector"].links[0].from_node.uv_map == "togishi_uv"
    height = tree.nodes[scan_images.DISPLACEMENT]
    assert height.image == scan.displacement_image
    relief = tree.nodes[scan_images.RELIEF]
    assert relief.inputs["Height"].links[0].from_node == height
    assert relief.inputs["Scale"].default_value == pytest.approx(0.1)  # mm in units of 1 cm
    assert relief.inputs["Midlevel"].default_value == 0
    # The user's connections stay, and so does the steel.
    output = tree.nodes[f"{steel_group.GROUP_NAME} output CYCLES"]
    tree.links.new(relief.outputs[0], output.inputs["Displacement"])
    surface = output.inputs["Surface"].links[0].from_node.name
    count = len(tree.nodes)
    assert bpy.ops.object.togishi_scan_correct(change="unit", unit="mm") == {"FINISHED"}
    assert len(tree.nodes) == count
    assert tree.nodes[scan_images.DISPLACEMENT].image == scan.displacement_image
    assert tree.nodes[scan_images.COLOUR].image == scan.colour_image
    assert output.inputs["Displacement"].links[0].from_node.name == scan_images.RELIEF
    assert output.inputs["Surface"].links[0].from_node.name == surface
    # Of each channel one image: those before are gone.
    assert len([i for i in bpy.data.images if i.name.startswith("red ")]) == 3
