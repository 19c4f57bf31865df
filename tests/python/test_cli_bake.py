"""togishi bake, and togishi info over what it writes."""

import csv
import errno
import json
import os
import re
import subprocess

import numpy as np
import pytest
import togishi_core

SMALL = ["--width", "96", "--height", "32"]
OLD = "what stood there before"


def refused(done: subprocess.CompletedProcess[str], *words: str) -> None:
    """Exit code 2, nothing but one sentence, with these words and what is allowed."""
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "allowed:" in done.stderr
    for word in words:
        assert word in done.stderr, done.stderr


@pytest.fixture
def old(tmp_path):
    """A file that a refused command must leave as it is, alone in its folder."""
    path = tmp_path / "blade.exr"
    path.write_text(OLD)
    yield path
    assert path.read_text() == OLD
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_maps_are_written_and_read(togishi, tmp_path):
    out = tmp_path / "blade.exr"
    out.write_text(OLD)
    done = togishi("--json", "bake", "-o", out, "--preset", "tanto", *SMALL)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    report = json.loads(done.stdout)
    assert report["file"] == str(out)
    assert [p.name for p in tmp_path.iterdir()] == ["blade.exr"]

    found = json.loads(togishi("--json", "info", out).stdout)
    assert found["kind"] == "property map"
    assert found["size"] == [96, 32] == [report["width"], report["height"]]
    assert found["levels"] == 7, "96 x 32 halves to 1 x 1 in six steps"
    assert found["chart_mm"] == pytest.approx(report["chart_mm"])
    blade = togishi_core.katana(togishi_core.katana_presets()["tanto"]["parameters"], 0.01)
    assert found["chart_mm"] == pytest.approx(blade.chart_mm, rel=1e-6)
    assert "Tanto" in found["source"]
    assert found["software"] == f"togishi {togishi_core.__version__}"
    assert found["checks"] == "passed"
    assert {c.split()[0] for c in found["channels"]} == set(report["channels"])
    assert {"ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h", "part"} <= set(report["channels"])


def test_options_change_the_blade_and_are_written_down(togishi, tmp_path):
    reports = {}
    for name, options in {
        "default": [],
        "long": ["--nagasa", "800"],
        "hira": ["--zukuri", "hira"],
        "seed": ["--pattern", "seed=18446744073709551615", "--pattern", "hamon=choji"],
        "float": ["--float"],
    }.items():
        out = tmp_path / f"{name}.exr"
        done = togishi("bake", "--json", "-o", out, *SMALL, *options)
        assert done.returncode == 0, done.stderr
        reports[name] = json.loads(done.stdout)
    source = {
        name: json.loads(togishi("info", "--json", tmp_path / f"{name}.exr").stdout)["source"]
        for name in reports
    }
    assert reports["default"]["parameters"] == togishi_core.katana_defaults()
    assert reports["long"]["parameters"]["nagasa_mm"] == 800
    longer = reports["long"]["chart_mm"][0] - reports["default"]["chart_mm"][0]
    assert longer == pytest.approx(800 - 736, abs=1)
    assert reports["hira"]["parameters"] == togishi_core.katana_defaults("hira")
    assert "nagasa_mm=800" in source["long"]
    assert "zukuri=hira" in source["hira"]
    assert "hamon=choji" in source["seed"]
    size = {name: (tmp_path / f"{name}.exr").stat().st_size for name in ("default", "float")}
    assert size["float"] > 1.5 * size["default"]


def test_the_same_request_gives_the_same_file(togishi, tmp_path):
    for name in ("a.exr", "b.exr"):
        assert togishi("bake", "-o", tmp_path / name, *SMALL).returncode == 0
    first, second = (
        re.sub(rb"\d{4}:\d\d:\d\d \d\d:\d\d:\d\d", b"", (tmp_path / name).read_bytes(), count=1)
        for name in ("a.exr", "b.exr")
    )
    assert first == second, "beside the time of writing"


def test_smallest_map(togishi, tmp_path):
    out = tmp_path / "one.exr"
    assert togishi("bake", "-o", out, "--width", 1, "--height", 1).returncode == 0
    assert json.loads(togishi("--json", "info", out).stdout)["size"] == [1, 1]


def test_table(togishi, tmp_path):
    out = tmp_path / "table.csv"
    arguments = ["--table", "copper_johnson_christy", "HPS", "--table-size", "16"]
    done = togishi("bake", "--json", "-o", out, *arguments, "--space", "rec2020")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "file": str(out),
        "metal": "copper_johnson_christy",
        "light": "HPS",
        "rows": 16,
    }
    lines = out.read_text().splitlines()
    header = "\n".join(line for line in lines if line.startswith("#"))
    for word in ("rec2020", "copper_johnson_christy", "HPS", "cie1931_2", "togishi"):
        assert word in header
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    assert rows[0] == ["cos_theta", "r", "g", "b"]
    numbers = np.array(rows[1:], dtype=np.float64)
    np.testing.assert_allclose(numbers[:, 0], (np.arange(16) / 15) ** 2, atol=1e-8)
    expected = togishi_core.fresnel_table("copper_johnson_christy", "HPS", space="rec2020", size=16)
    np.testing.assert_array_equal(numbers[:, 1:].astype(np.float32), expected)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--pattern", "hamom=choji"], ["--pattern", "hamom", "hamon, boshi, hada"]),
        (["--pattern", "hamon=zigzag"], ["hamon", "zigzag", "suguha, notare, gunome"]),
        (["--pattern", "nie=9"], ["nie", "9", "0 to 1"]),
        (["--pattern", "nie=nan"], ["nie", "nan"]),
        (["--pattern", "nie=much"], ["nie", "much", "a number"]),
        (["--pattern", "nie"], ["--pattern", "KEY=VALUE"]),
        (["--pattern", "seed=-1"], ["seed", "-1", "0 or more"]),
        (["--pattern", "seed=1.5"], ["seed", "1.5"]),
        (["--preset", "excalibur"], ["--preset", "excalibur", "o_kissaki"]),
        (["--zukuri", "moroha"], ["zukuri", "moroha", "shinogi, hira, shobu"]),
        (["--nagasa", "5"], ["nagasa_mm", "5"]),
        (["--kissaki", "600"], ["kissaki_mm", "600"]),
        (["--material", "rust"], ["rust", "polished_katana"]),
        (["--width", "0"], ["map size", "0 x 512", "32768"]),
        (["--width", "-3"], ["map size", "-3 x 512", "32768"]),
        (["--width", "32768", "--height", "32768"], ["32768 x 32768", "67108864"]),
    ],
)
def test_bad_input_leaves_the_old_file(togishi, old, arguments, words):
    refused(togishi("bake", "-o", old, *arguments), *words)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--table", "copper_johnson_christy"],
        ["--table", "unobtainium", "D65"],
        ["--table", "copper_johnson_christy", "D64"],
        ["--table", "copper_johnson_christy", "D65", "--table-size", "1"],
        ["--table", "copper_johnson_christy", "D65", "--observer", "cie1931"],
        ["--table", "copper_johnson_christy", "D65", "--space", "srgb"],
    ],
)
def test_bad_tables_leave_the_old_file(togishi, tmp_path, arguments):
    out = tmp_path / "table.csv"
    out.write_text(OLD)
    done = togishi("bake", "-o", out, *arguments)
    assert done.returncode == 2
    assert done.stderr
    assert out.read_text() == OLD


def test_material_with_an_unknown_field(togishi, old, tmp_path_factory):
    material = tmp_path_factory.mktemp("material") / "mine.toml"
    material.write_text('format = 1\nname = "Mine"\nshine = 3\n')
    done = togishi("bake", "-o", old, "--material", material, *SMALL)
    refused(done, "mine.toml")


def test_wrong_names_for_the_output(togishi, tmp_path):
    refused(togishi("bake", "-o", tmp_path / "blade.png"), "blade.png", ".exr")
    done = togishi("bake", "-o", tmp_path / "a.exr", "--table", "copper_johnson_christy", "D65")
    refused(done, "a.exr", ".csv")
    assert togishi("bake").returncode == 2
    assert list(tmp_path.iterdir()) == []


def test_missing_folder(togishi, tmp_path):
    for name, more in (("a.exr", []), ("a.csv", ["--table", "copper_johnson_christy", "D65"])):
        out = tmp_path / "no" / name
        refused(togishi("bake", "-o", out, *more), name, "output folder", "missing")
    assert list(tmp_path.iterdir()) == []


def test_output_that_is_a_folder(togishi, tmp_path):
    (tmp_path / "a.exr" / "inside").mkdir(parents=True)
    refused(togishi("bake", "-o", tmp_path / "a.exr", *SMALL), "a.exr", "not to be replaced")
    assert (tmp_path / "a.exr" / "inside").is_dir()
    assert len(list(tmp_path.iterdir())) == 1


def test_read_only_folder(togishi, tmp_path, as_user):
    folder = tmp_path / "shut"
    folder.mkdir()
    (folder / "a.exr").write_text(OLD)
    folder.chmod(0o555)
    try:
        done = togishi("bake", "-o", folder / "a.exr", *SMALL, before=as_user)
    finally:
        folder.chmod(0o755)
    refused(done, "a.exr", "output folder", "read-only")
    assert (folder / "a.exr").read_text() == OLD
    assert [p.name for p in folder.iterdir()] == ["a.exr"]


def test_full_disk(togishi, old, full_disk):
    done = togishi("bake", "-o", old, "--width", 512, "--height", 128, **full_disk)
    refused(done, "blade.exr", "output", "not written whole", os.strerror(errno.EFBIG))


def test_full_disk_of_a_table(togishi, tmp_path, full_disk):
    out = tmp_path / "table.csv"
    out.write_text(OLD)
    table = ["--table", "copper_johnson_christy", "D65", "--table-size", "4096"]
    refused(togishi("bake", "-o", out, *table, **full_disk), "table.csv", "not written whole")
    assert out.read_text() == OLD
    assert len(list(tmp_path.iterdir())) == 1


def test_full_disk_of_a_mesh(togishi, tmp_path, full_disk):
    for name in ("blade.ply", "blade.obj"):
        out = tmp_path / name
        out.write_text(OLD)
        done = togishi("katana", "-o", out, "--detail", "0.1", **full_disk)
        refused(done, name, "not written whole")
        assert out.read_text() == OLD
    assert len(list(tmp_path.iterdir())) == 2


def test_info_of_a_truncated_map(togishi, tmp_path):
    whole = tmp_path / "whole.exr"
    assert togishi("bake", "-o", whole, *SMALL).returncode == 0
    data = whole.read_bytes()
    cut = tmp_path / "cut.exr"
    for part in (0, 0.001, 0.02, 0.5, 0.97):
        cut.write_bytes(data[: int(len(data) * part)])
        refused(togishi("info", cut), "cut.exr")


def test_info_of_text_named_exr(togishi, tmp_path):
    path = tmp_path / "text.exr"
    path.write_text("no picture")
    refused(togishi("info", path), "text.exr", "OpenEXR")
