"""Bad files end with exit code 2 and one sentence naming file, field, value and what is allowed.

What each line of the requirement "Bad input" is held by; tests named alone are in this file.

| line                                | test                                                                        |
|-------------------------------------|-----------------------------------------------------------------------------|
| truncated EXR                       | test_cli_bake:test_info_of_a_truncated_map; blender/test_operators:test_foreign_and_truncated_map_files_change_nothing |
| foreign EXR: not one at all         | test_cli_bake:test_info_of_text_named_exr; test_cli_spectrum:test_info_of_a_foreign_exr |
| foreign EXR: a picture              | test_a_picture_is_no_property_map                                           |
| CSV with text                       | lights: test_cli_spectrum:test_bad_files_end_with_2_and_a_sentence; metals: test_bad_tables_of_a_metal |
| decreasing wavelengths              | the same two; test_spectral:test_bad_input_says_what_is_allowed              |
| no overlap with 400 to 700 nm       | the same two                                                                |
| any other bytes as a CSV            | test_spectral:test_any_bytes_as_a_file_are_read_or_refused                  |
| material with an unknown field      | test_unknown_fields_of_a_material_file; in memory: test_material:test_wrong_fields_are_named |
| a missing map beside a .blend       | blender/test_headless:test_missing_map_is_refused_before_anything_is_rendered; in a window: blender/test_engine_blender:test_a_missing_map_names_its_file_and_the_blade_is_drawn |
| a read-only output folder           | maps: test_cli_bake:test_read_only_folder; tables and meshes: test_read_only_folder_of_tables_and_meshes; pictures: blender/test_headless:test_unwritable_output |
| a full disk                         | test_cli_bake:test_full_disk, test_full_disk_of_a_table, test_full_disk_of_a_mesh; pictures: blender/test_headless:test_a_failed_write_leaves_the_old_picture |
"""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path

import pytest
import togishi_core

OLD = "what stood there before"
METAL = (
    "# format: togishi-table 1\n# kind: metal\n# name: own\n# title: A metal of its own\n"
    "# source: a test\n# licence: CC0-1.0\n# columns: wavelength_nm,n,k\n"
)


def refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    """Exit code 2 and one sentence that says what is allowed."""
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1, done.stderr
    for word in (*words, "allowed:"):
        assert word in done.stderr, done.stderr


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """An output that a refused command must leave as it is."""
    path = tmp_path / "out" / "old.csv"
    path.parent.mkdir()
    path.write_text(OLD)
    yield path
    assert path.read_text() == OLD
    assert [p.name for p in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("300,1,1\n500,2.5,high\n900,1,1\n", ["line 9", "column 3", '"high"', "a finite number"]),
        ("300,1,1\n500,nan,1\n900,1,1\n", ["line 9", "column 2", '"nan"', "a finite number"]),
        ("300,1,1\n900,1,1\n500,1,1\n", ["line 10", "wavelength", '"500"', "increasing"]),
        ("300,1,1\n300,1,1\n900,1,1\n", ["line 9", "wavelength", '"300"', "each wavelength once"]),
        ("800,1,1\n900,1,1\n", ["wavelength range", "800", "900", "400 nm", "700 nm"]),
        ("300,1,1\n600,1,1\n", ["wavelength range", "300", "600", "400 nm", "700 nm"]),
        ("300,1,1\n500,-2,1\n900,1,1\n", ["line 9", "n, k", "-2", "0 to 1000"]),
        ("300,1,1\n500,0,0\n900,1,1\n", ["line 9", "n, k", "0", "not both 0"]),
    ],
    ids=["text", "nan", "decreasing", "twice", "no overlap", "part of the range", "negative", "n = k = 0"],
)  # fmt: skip
def test_bad_tables_of_a_metal(togishi, tmp_path, old, rows, words):
    path = tmp_path / "metal.csv"
    path.write_text(METAL + rows)
    for command in (
        ["info", path],
        ["spectrum", path],
        ["bake", "-o", old, "--table", path, "D65"],
    ):
        refused(togishi(*command), "metal.csv", *words)


@pytest.mark.parametrize(
    ("table", "line", "field"),
    [
        ("", 'shine = "high"', "shine"),
        ("[parts.ji]", "gloss = 3.5", "parts.ji.gloss"),
        ("[parts.nakago]", "rust = 0.7", "parts.nakago.rust"),
        ("[parts.tip]", "mu_t_deg = 1.0", "parts.tip"),
    ],
)
def test_unknown_fields_of_a_material_file(togishi, tmp_path, old, table, line, field):
    """Everything else in the file is right, so that the unknown field is what is refused."""
    text = togishi_core.material_to_toml(togishi_core.default_material())
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    assert togishi("info", path).returncode == 0
    lines = text.splitlines()
    if table in lines:
        lines.insert(lines.index(table) + 1, line)
    elif table:
        lines += [table, line]
    else:
        lines.insert(next(i for i, x in enumerate(lines) if x.startswith("[")), line)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    maps = old.with_suffix(".exr")
    for command in (["info", path], ["bake", "-o", maps, "--material", path, "--width", "8", "--height", "8"]):  # fmt: skip
        refused(togishi(*command), "mine.toml", field)
    with pytest.raises(togishi_core.InputError, match=r"mine\.toml:\d+: .*" + field.split(".")[-1]):
        togishi_core.load_material(str(path))


def picture_exr(channels: str) -> bytes:
    """A whole OpenEXR file of 2 x 2 pixels, 32-bit floats, uncompressed. Layout: openexr.com, "OpenEXR File Layout"."""

    def attribute(name: str, kind: str, content: bytes) -> bytes:
        return (
            name.encode()
            + b"\0"
            + kind.encode()
            + b"\0"
            + struct.pack("<i", len(content))
            + content
        )

    names = sorted(channels)
    listed = (
        b"".join(c.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for c in names) + b"\0"
    )
    window = struct.pack("<4i", 0, 0, 1, 1)
    header = b"\x76\x2f\x31\x01\x02\0\0\0" + b"".join(
        [
            attribute("channels", "chlist", listed),
            attribute("compression", "compression", b"\0"),
            attribute("dataWindow", "box2i", window),
            attribute("displayWindow", "box2i", window),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
            b"\0",
        ]
    )
    row = struct.pack(f"<{2 * len(names)}f", *([0.5] * 2 * len(names)))
    lines = [struct.pack("<2i", y, len(row)) + row for y in (0, 1)]
    start = len(header) + 16
    return header + struct.pack("<2Q", start, start + len(lines[0])) + b"".join(lines)


def test_a_picture_is_no_property_map(togishi, tmp_path):
    """A sound EXR of colours: the sentence names the attribute that a property map has."""
    path = tmp_path / "photo.exr"
    path.write_bytes(picture_exr("RGB"))
    refused(togishi("info", path), "photo.exr", "togishi:format is missing")


def test_read_only_folder_of_tables_and_meshes(togishi, old, as_user):
    folder = old.parent
    mesh = ["katana", "--detail", "0.01", "-o"]
    table = ["bake", "--table", "copper_johnson_christy", "D65", "-o"]
    folder.chmod(0o555)
    try:
        for command, name in ((mesh, "new.ply"), (mesh, "new.obj"), (table, "old.csv"), (table, "new.csv")):  # fmt: skip
            done = togishi(*command, folder / name, before=as_user)
            refused(done, name, "output folder", "read-only")
    finally:
        folder.chmod(0o755)
