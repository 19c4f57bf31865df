"""togishi spectrum and togishi info, as a shell sees them."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import togishi_core

DATA = Path(__file__).parents[2] / "data"


def run(togishi: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(togishi), *arguments], capture_output=True, text=True, timeout=60, check=False
    )


def run_json(togishi: Path, *arguments: str) -> dict:
    done = run(togishi, *arguments, "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    path = tmp_path / "lamp.csv"
    path.write_text("# title: Case lamp\nnm,power\n420,1\n500,2\n680,3\n")
    return path


def test_metal(togishi_cli: Path) -> None:
    found = run_json(togishi_cli, "spectrum", "iron_johnson_christy")
    assert found["kind"] == "metal"
    assert "Johnson" in found["source"]
    assert found["licence"] == "CC0-1.0"
    assert found["columns"] == ["wavelength_nm", "n", "k", "F_0deg"]
    assert [549, 2.95, 2.93] in [row[:3] for row in found["rows"]]
    text = run(togishi_cli, "spectrum", "iron_johnson_christy").stdout
    assert "Johnson" in text
    assert "2.95" in text


def test_metal_under_a_light(togishi_cli: Path, lamp: Path) -> None:
    for light in ("HPS", "daylight:5000", f"csv:{lamp}"):
        found = run_json(
            togishi_cli, "spectrum", "gold_johnson_christy", "--light", light, "--size", "16",
            "--space", "rec2020",
        )  # fmt: skip
        table = togishi_core.fresnel_table("gold_johnson_christy", light, space="rec2020", size=16)
        rows = np.array(found["rows"])
        np.testing.assert_array_equal(rows[:, 2:].astype(np.float32), table)
        np.testing.assert_allclose(np.cos(np.deg2rad(rows[:, 1])), rows[:, 0], atol=1e-12)


def test_light(togishi_cli: Path, lamp: Path) -> None:
    found = run_json(togishi_cli, "spectrum", "D65")
    np.testing.assert_allclose(found["white_rgb"], togishi_core.light_rgb("D65"), rtol=1e-12)
    assert found["white_xy"] == pytest.approx([0.3127, 0.3290], abs=1e-4)
    assert len(found["rows"]) == 97
    assert len(run_json(togishi_cli, "spectrum", "D65", "--samples")["rows"]) == 61
    assert len(run_json(togishi_cli, "spectrum", "blackbody:3200")["rows"]) == 61
    users = run_json(togishi_cli, "spectrum", str(lamp))
    assert users["title"] == "Case lamp"
    assert any("380 to 420 nm" in note for note in users["notes"])


def test_observer(togishi_cli: Path) -> None:
    found = run_json(togishi_cli, "spectrum", "cie1931_2")
    assert len(found["rows"]) == 471


def test_info(togishi_cli: Path, lamp: Path) -> None:
    about = run_json(togishi_cli, "info")
    assert [m["name"] for m in about["metals"]] == [m["name"] for m in togishi_core.metals()]
    assert [m["name"] for m in about["lights"]] == [m["name"] for m in togishi_core.lights()]
    assert about["version"] == togishi_core.__version__
    assert run(togishi_cli, "--version").stdout == f"togishi {togishi_core.__version__}\n"
    assert "Redistribution" in run(togishi_cli, "info", "--licences").stdout
    for path in sorted(
        [*DATA.glob("metals/*.csv"), *DATA.glob("lights/*.csv"), *DATA.glob("observers/*.csv")]
    ):
        assert run_json(togishi_cli, "info", str(path))["checks"] == "passed"
    users = run_json(togishi_cli, "info", str(lamp))
    assert users["kind"] == "table of a light"
    assert users["notes"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"400,1\n390,1\n", ["bad.csv", "line 2", "increasing"]),
        (b"400,1\n500,one\n", ["bad.csv", "line 2", "one", "finite number"]),
        (b"800,1\n900,1\n", ["bad.csv", "400 to 700 nm"]),
        (b"", ["bad.csv", "without a row"]),
        (b"\x00\x01\x02", ["bad.csv", "binary"]),
    ],
)
def test_bad_files_end_with_2_and_a_sentence(
    togishi_cli: Path, tmp_path: Path, content: bytes, words: list[str]
) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    for command in ("spectrum", "info"):
        done = run(togishi_cli, command, str(path))
        assert done.returncode == 2
        assert done.stdout == ""
        assert done.stderr.count("\n") == 1
        assert all(word in done.stderr for word in words), done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["spectrum"],
        ["spectrum", "D64"],
        ["spectrum", "D65", "--light", "A"],
        ["spectrum", "iron_querry", "--light", "D64"],
        ["spectrum", "iron_querry", "--light", "D65", "--size", "1"],
        ["spectrum", "iron_querry", "--light", "D65", "--size", "-3"],
        ["spectrum", "D65", "--space", "srgb"],
        ["spectrum", "line:300"],
        ["info", "/no/such/file"],
        ["info", "/dev/zero"],
        ["nonsense"],
        [],
    ],
)
def test_wrong_arguments_end_with_2(togishi_cli: Path, arguments: list[str]) -> None:
    done = run(togishi_cli, *arguments)
    assert done.returncode == 2
    assert done.stderr


def test_a_full_disk_is_a_failure(togishi_cli: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [str(togishi_cli), "spectrum", "D65"], stdout=full, stderr=subprocess.PIPE, text=True,
            check=False,
        )  # fmt: skip
    assert done.returncode == 2
    assert "disk full" in done.stderr


def test_info_of_a_material(togishi_cli: Path, tmp_path: Path) -> None:
    for path in sorted(DATA.glob("materials/*.toml")):
        found = run_json(togishi_cli, "info", str(path))
        assert found["kind"] == "material"
        assert found["metal"] in [metal["name"] for metal in togishi_core.metals()]
    path = tmp_path / "bad.toml"
    path.write_text("format = 1\nshine = 3\n")
    done = run(togishi_cli, "info", str(path))
    assert done.returncode == 2
    assert "bad.toml" in done.stderr


def test_info_of_a_foreign_exr(togishi_cli: Path, tmp_path: Path) -> None:
    path = tmp_path / "broken.exr"
    path.write_bytes(b"\x76\x2f\x31\x01\x02\x00\x00\x00truncated")
    done = run(togishi_cli, "info", str(path))
    assert done.returncode == 2
    assert "broken.exr" in done.stderr
