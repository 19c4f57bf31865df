"""The headless render: its options, what it writes, and how it fails."""

from __future__ import annotations

import signal
import subprocess
import sys

import bpy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from togishi import cli, map_images, properties
from togishi.core import headless
from togishi.core.headless import UsageError
from ui_fixtures import add_katana, addon, environment  # noqa: F401


@pytest.mark.parametrize(
    ("text", "step", "frames"),
    [
        ("7", 1, (7,)),
        ("1-4", 1, (1, 2, 3, 4)),
        ("1,5,7-9", 1, (1, 5, 7, 8, 9)),
        ("1-9", 4, (1, 5, 9)),
        ("1-9x3", 1, (1, 4, 7)),
        ("3,1,3", 1, (1, 3)),
        ("-2-1", 1, (-2, -1, 0, 1)),
    ],
)
def test_frames(text, step, frames):
    assert headless.parse_frames(text, step) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "5-1", "1-4x0", "1;2", "1.5", "99999999"])
def test_bad_frames(text):
    with pytest.raises(UsageError, match="--frames"):
        headless.parse_frames(text)


@given(st.lists(st.integers(-9999, 9999), min_size=1, max_size=20))
def test_lists_of_frames_come_back_sorted(frames):
    assert headless.parse_frames(",".join(map(str, frames))) == tuple(sorted(set(frames)))


@pytest.mark.parametrize(
    ("output", "several", "expected"),
    [
        ("a/f_####.png", True, "a/f_0012.png"),
        ("a/f.png", False, "a/f.png"),
        ("a/f.png", True, "a/f_0012.png"),
        ("a/f", True, "a/f_0012.exr"),
        ("a/f.v2", False, "a/f.v2.exr"),
        ("a/", True, "a/0012.exr"),
        ("##/f_##", True, "##/f_12.exr"),
    ],
)
def test_frame_names(output, several, expected):
    assert str(headless.frame_path(output, 12, ".exr", several)) == expected


@pytest.mark.parametrize(
    "argv",
    [
        [],
        ["draw"],
        ["render"],
        ["render", "a.blend"],
        ["render", "a.blend", "-o", "x", "--wings"],
        ["render", "a.blend", "-o", "x", "-r", "0x0"],
        ["render", "a.blend", "-o", "x", "-s", "0"],
        ["render", "a.blend", "-o", "x", "-E", "radiance"],
        ["render", "a.blend", "-o", "x.png", "-F", "exr"],
        ["render", "absent.blend", "-o", "x.png"],
    ],
)
def test_bad_command_lines_exit_with_2(argv, capsys):
    assert cli.main(argv) == 2
    assert "togishi:" in capsys.readouterr().err


@pytest.fixture
def blend(addon, tmp_path):  # noqa: F811
    """A blade before a camera, Workbench as its engine: quick and without a light."""
    add_katana()
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0.4, 1.5, 0.0)
    camera.rotation_euler = (np.pi / 2, 0.0, np.pi)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("room")
    scene.world.color = (0.2, 0.2, 0.2)
    scene.render.engine = "TOGISHI"
    scene.togishi.samples = 1
    scene.render.resolution_x, scene.render.resolution_y = 64, 32
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_renders_names_and_skips(blend, tmp_path, capsys):
    out = tmp_path / "frames" / "f_####.png"
    assert (
        cli.main(["render", str(blend), "-o", str(out), "-f", "1-3", "--step", "2", "-r", "48x24"])
        == 0
    )
    text = capsys.readouterr().out
    for frame in ("0001", "0003"):
        assert f"Saved: '{tmp_path}/frames/f_{frame}.png'" in text
    assert sorted(p.name for p in out.parent.iterdir()) == ["f_0001.png", "f_0003.png"]
    image = bpy.data.images.load(str(out.parent / "f_0001.png"))
    assert tuple(image.size) == (48, 24)
    pixels = np.empty(48 * 24 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    assert pixels.reshape(-1, 4)[:, :3].std() > 0.0
    (out.parent / "f_0003.png").unlink()
    stamp = (out.parent / "f_0001.png").stat().st_mtime_ns
    argv = ["render", str(blend), "-o", str(out), "-f", "1,3", "--skip-existing"]
    assert cli.main(argv) == 0
    captured = capsys.readouterr()
    assert "1 of 2 frames are there already" in captured.err
    assert "f_0001" not in captured.out
    assert (out.parent / "f_0001.png").stat().st_mtime_ns == stamp
    assert (out.parent / "f_0003.png").stat().st_size > 0


@pytest.mark.parametrize("name", ["exr", "tiff", "jpeg", "exr-multilayer"])
def test_formats(blend, tmp_path, name):
    out = tmp_path / "picture"
    assert cli.main(["render", str(blend), "-o", str(out), "-F", name]) == 0
    file = tmp_path / ("picture" + headless.FORMATS[name][1])
    magic = {"exr": b"\x76\x2f\x31\x01", "exr-multilayer": b"\x76\x2f\x31\x01", "jpeg": b"\xff\xd8"}
    assert file.read_bytes().startswith(magic.get(name, b"II"))


def test_missing_map_is_refused_before_anything_is_rendered(blend, tmp_path, capsys):
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    material = next(m for m in bpy.data.materials if m.togishi.is_blade)
    flat = np.full((4, 8), 0.5, np.float32)
    map_images.assign(material, {"ji.ln_mu_deg": flat, "ha.ln_mu_deg": flat, "w": flat})
    image = material.togishi.lobes_image
    image.filepath_raw = str(tmp_path / "maps.exr")
    image.file_format = "OPEN_EXR"
    image.save()
    image.unpack(method="REMOVE") if image.packed_file else None
    image.source = "FILE"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    (tmp_path / "maps.exr").unlink()
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "x.png")]) == 2
    error = capsys.readouterr().err
    assert "maps.exr" in error
    assert "no such file" in error
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        (["--camera", "Nikon"], "--camera: 'Nikon' is not a camera of the scene; it has camera"),
        (["--scene", "Stage"], "--scene: 'Stage' is not in the file"),
        (["-s", "65"], "takes 1 to 64"),
    ],
)
def test_names_that_are_not_there(blend, tmp_path, capsys, extra, message):
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "x.png"), *extra]) == 2
    assert message in capsys.readouterr().err


def test_unwritable_output(blend, capsys):
    assert cli.main(["render", str(blend), "-o", "/proc/nowhere/x.png"]) == 2
    assert "--output: cannot write in /proc/nowhere" in capsys.readouterr().err


def test_a_foreign_file_is_refused(addon, tmp_path, capsys):  # noqa: F811
    (tmp_path / "no.blend").write_bytes(b"not a blend file")
    assert cli.main(["render", str(tmp_path / "no.blend"), "-o", str(tmp_path / "x.png")]) == 2
    assert "no.blend" in capsys.readouterr().err


def test_missing_spectrum_file(blend, tmp_path, capsys):
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    light = bpy.data.lights.new("lamp", "POINT")
    light.togishi.kind = "csv"
    light.togishi.csv_path = str(tmp_path / "gone.csv")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("lamp", light))
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "x.png")]) == 2
    assert "gone.csv" in capsys.readouterr().err


def test_missing_files_of_instanced_lamps_and_of_metals(blend, tmp_path, capsys):
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    light = bpy.data.lights.new("lamp", "POINT")
    light.togishi.kind = "csv"
    light.togishi.csv_path = str(tmp_path / "gone.csv")
    rig = bpy.data.collections.new("rig")
    rig.objects.link(bpy.data.objects.new("lamp", light))
    stand_in = bpy.data.objects.new("rig", None)
    stand_in.instance_type, stand_in.instance_collection = "COLLECTION", rig
    bpy.context.scene.collection.objects.link(stand_in)
    material = next(m for m in bpy.data.materials if m.togishi.is_blade)
    name = material.name
    material.togishi.metal = properties.FILE_CHOICE
    material.togishi.metal_path = str(tmp_path / "no metal.csv")
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "x.png")]) == 2
    error = capsys.readouterr().err
    assert "light 'lamp'" in error and "gone.csv" in error
    assert f"material {name!r}" in error and "no metal.csv" in error


def test_materials_that_nothing_wears_are_not_checked(blend, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    kept = bpy.data.materials.new("kept for later")
    kept.use_fake_user = True
    kept.togishi.is_blade = True
    kept.togishi.metal = properties.FILE_CHOICE
    kept.togishi.metal_path = str(tmp_path / "no metal.csv")
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert cli.main(["render", str(blend), "-o", str(tmp_path / "x.png")]) == 0


def test_a_failed_write_leaves_the_old_picture(blend, tmp_path, monkeypatch, capsys):
    out = tmp_path / "keep.png"
    out.write_bytes(b"previous")

    def full_disk(self, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(type(out), "replace", full_disk)
    assert cli.main(["render", str(blend), "-o", str(out)]) == 2
    assert out.read_bytes() == b"previous"
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".keep")] == []
    assert "No space left" in capsys.readouterr().err


def test_as_a_process(blend, tmp_path):
    """python -m togishi: exit codes, streams, and that the process ends."""
    out = tmp_path / "one.png"
    command = [sys.executable, "-m", "togishi", "render", str(blend), "-o", str(out)]
    result = subprocess.run(
        command, env=environment(), capture_output=True, text=True, timeout=90, check=False
    )
    assert result.returncode == 0, result.stderr
    assert f"Saved: '{out}'" in result.stdout
    assert out.read_bytes().startswith(b"\x89PNG")
    bad = subprocess.run(
        [*command, "--wings"],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )
    assert bad.returncode == 2
    assert "--wings" in bad.stderr


def test_a_stopped_process_says_so_and_leaves_whole_pictures(blend, tmp_path):
    """SIGTERM, as farms send it, in the middle of a frame."""
    out = tmp_path / "frames" / "f_####.png"
    command = [sys.executable, "-m", "togishi", "render", str(blend), "-o", str(out)]
    command += ["-f", "1-5000", "-s", "64"]
    with subprocess.Popen(
        command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        for line in process.stdout:
            if line.startswith("Saved:"):
                break
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=90)
    assert process.returncode == 130, errors
    assert errors.rstrip().endswith("togishi: stopped")
    written = sorted(out.parent.iterdir())
    assert written and all(path.name.startswith("f_") for path in written)
    assert all(path.read_bytes().endswith(b"IEND\xaeB`\x82") for path in written)
