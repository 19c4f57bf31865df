"""togishi katana, run as people run it."""

import json
import struct
from pathlib import Path

import pytest


def read_ply(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode("ascii").splitlines()
    counts = [int(line.split()[2]) for line in header if line.startswith("element")]
    properties = [line.split()[-1] for line in header if line.startswith("property float")]
    row = struct.Struct(f"<{len(properties)}f")
    vertices = [
        dict(zip(properties, row.unpack_from(data, end + i * row.size), strict=True))
        for i in range(counts[0])
    ]
    at = end + counts[0] * row.size
    faces = []
    for _ in range(counts[1]):
        sides = data[at]
        indices = struct.unpack_from(f"<{sides}i", data, at + 1)
        at += 1 + 4 * sides
        faces.append((indices, data[at]))
        at += 1
    assert at == len(data)
    return vertices, faces


def test_ply_is_well_formed(togishi, tmp_path):
    out = tmp_path / "blade.ply"
    done = togishi("katana", "-o", out, "--detail", "0.02")
    assert done.returncode == 0, done.stderr
    vertices, faces = read_ply(out)
    assert max(v["x"] for v in vertices) == pytest.approx(736, abs=0.01)
    for v in vertices:
        assert v["nx"] ** 2 + v["ny"] ** 2 + v["nz"] ** 2 == pytest.approx(1, abs=1e-4)
        assert -1e-6 <= v["s"] <= 1 + 1e-6
        assert 0 <= v["t"] <= 1
    for indices, part in faces:
        assert len(indices) in (3, 4)
        assert len(set(indices)) == len(indices)
        assert max(indices) < len(vertices)
        assert 1 <= part <= 7
    assert {part for _, part in faces} == set(range(1, 8))


def test_obj_is_watertight(togishi, tmp_path):
    out = tmp_path / "blade.obj"
    assert togishi("katana", "-o", out, "--preset", "tanto", "--detail", "0.02").returncode == 0
    edges = set()
    counts = {"v": 0, "vt": 0, "vn": 0}
    for line in out.read_text().splitlines():
        kind, *rest = line.split()
        if kind in counts:
            counts[kind] += 1
        if kind != "f":
            continue
        corners = [tuple(int(i) for i in corner.split("/")) for corner in rest]
        for v, vt, vn in corners:
            assert 1 <= v <= counts["v"]
            assert 1 <= vt <= counts["vt"]
            assert 1 <= vn <= counts["vn"]
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            edge = (a[0], b[0])
            assert edge not in edges
            edges.add(edge)
    assert edges
    assert all((b, a) in edges for a, b in edges)


def test_json_has_the_measures(togishi, tmp_path):
    out = tmp_path / "blade.ply"
    done = togishi(
        "--json",
        "katana",
        "-o",
        out,
        "--preset",
        "wakizashi",
        "--nagasa",
        "401.5",
        "--detail",
        "0.1",
    )
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["measures"]["nagasa_mm"] == pytest.approx(401.5, abs=0.05)
    assert report["parameters"]["nagasa_mm"] == 401.5
    assert report["parameters"]["motohaba_mm"] == 27
    assert report["file"] == str(out)


def test_preset_from_a_file(togishi, tmp_path):
    preset = tmp_path / "mine.toml"
    preset.write_text(
        'title = "Mine"\nsource = "me"\nlicence = "CC0-1.0"\n[katana]\nzukuri = "hira"\n'
    )
    done = togishi("katana", "-o", tmp_path / "a.ply", "--preset", preset, "--detail", "0.01")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Mine")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--nagasa", "0"], "nagasa_mm"),
        (["--nagasa", "nan"], "nagasa_mm"),
        (["--kissaki", "600"], "kissaki_mm"),
        (["--zukuri", "moroha"], "shinogi, hira, shobu"),
        (["--preset", "excalibur"], "o_kissaki"),
        (["--preset", "missing.toml"], "missing.toml"),
        (["--detail", "1000"], "detail"),
        (["--nagasa", "long"], "nagasa"),
        (["--colour", "red"], "colour"),
    ],
)
def test_bad_input_leaves_the_old_file(togishi, tmp_path, arguments, said):
    out = tmp_path / "blade.ply"
    out.write_text("old")
    done = togishi("katana", "-o", out, *arguments)
    assert done.returncode == 2
    assert said in done.stderr
    assert out.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["blade.ply"]


def test_bad_output(togishi, tmp_path):
    assert togishi("katana", "-o", tmp_path / "blade.stl").returncode == 2
    done = togishi("katana", "-o", tmp_path / "missing" / "blade.ply", "--detail", "0.01")
    assert done.returncode == 2
    assert "output folder" in done.stderr
    assert togishi("katana").returncode == 2


def test_full_standard_output_is_reported(togishi):
    with Path("/dev/full").open("w") as full:
        done = togishi("katana", "--help", stdout=full)
    assert done.returncode == 2
    assert "standard output: output is not written whole" in done.stderr


def test_help_names_units(togishi):
    text = togishi("katana", "--help").stdout
    for option in ("--nagasa", "--sori", "--motohaba", "--mekugi-ana-from-machi", "--preset"):
        assert option in text
    assert "[mm]" in text
