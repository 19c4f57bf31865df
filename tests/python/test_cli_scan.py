"""togishi scan, run as people run it."""

import json

import pytest

CUBE = """v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1
f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"""


def test_a_blade_is_measured_written_and_recorded(togishi, tmp_path):
    scan = tmp_path / "日本 'a'.ply"
    done = togishi("katana", "-o", scan, "--preset", "tanto", "--detail", "0.1")
    assert done.returncode == 0, done.stderr
    out = tmp_path / "out"
    quick = ("--replicates", "0", "--levels", "1", "--width", "256", "--error", "0.3")
    line = ("--json", "scan", scan, "--out", out, *quick, "--object", "F-1")
    done = togishi(*line)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["verdict"] == "blade"
    assert report["unit"]["mm_per_unit"] == 1
    truth = json.loads(
        togishi("--json", "katana", "-o", tmp_path / "b.ply", "--preset", "tanto").stdout
    )["measures"]
    found = report["dimensions"]
    assert found["nagasa_mm"]["value"] == pytest.approx(truth["nagasa_mm"], abs=0.3)
    assert found["motohaba_mm"]["value"] == pytest.approx(truth["motohaba_mm"], abs=0.15)
    for file in report["files"].values():
        assert (tmp_path / file).stat().st_size > 0
    info = togishi("info", report["files"]["record"])
    assert info.returncode == 0, info.stderr
    assert "F-1" in info.stdout
    assert scan.name + " (scan)" in info.stdout
    # Nothing is replaced unasked, the scan itself never.
    again = togishi(*line)
    assert again.returncode == 2
    assert "--force to replace it" in again.stderr
    itself = togishi("scan", scan, "--out", tmp_path, "--force", *quick)
    assert itself.returncode == 2
    assert "the scan itself" in itself.stderr


def test_what_is_no_blade_is_said_and_nothing_written(togishi, tmp_path):
    cube = tmp_path / "cube.obj"
    cube.write_text(CUBE)
    done = togishi("scan", cube, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert done.stdout.strip()
    assert "nothing was written" in done.stderr
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--unit", "sun"), "auto, mm, cm, m, inch"),
        (("--correct", "left"), "ends, edge"),
        (("--format", "fbx"), "ply, obj"),
        (("--error", "nan"), "0 (by the noise) to 100 mm"),
    ],
)
def test_bad_options_are_refused(togishi, tmp_path, options, said):
    cube = tmp_path / "cube.obj"
    cube.write_text(CUBE)
    done = togishi("scan", cube, *options)
    assert done.returncode == 2
    assert said in done.stderr
