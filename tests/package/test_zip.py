"""What is in the extension's zip, and that it depends on its content alone."""

from __future__ import annotations

import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from clean_blender import ROOT
from extension import ExtensionError, blender_validators, manifest_text, validate
from version_table import WHEELS

MAX_MB = 20.0


@pytest.fixture
def archive(package):
    with zipfile.ZipFile(package) as opened:
        yield opened


def test_size(package):
    assert package.stat().st_size < MAX_MB * 1e6


@pytest.mark.parametrize(
    "validator", blender_validators(ROOT), ids=lambda path: path.parents[4].name
)
def test_blender_finds_it_valid(package, validator):
    validate(package, validator)


def test_blender_refuses_a_broken_one(package, tmp_path):
    broken = tmp_path / "broken.zip"
    with zipfile.ZipFile(package) as source, zipfile.ZipFile(broken, "w") as target:
        text = source.read("blender_manifest.toml").decode()
        target.writestr("blender_manifest.toml", text.replace('type = "add-on"', 'type = "sword"'))
        target.writestr("__init__.py", "")
    with pytest.raises(ExtensionError, match="sword"):
        validate(broken, blender_validators(ROOT)[0])


def test_manifest_is_the_sources_with_wheels(archive):
    source = tomllib.loads((ROOT / "addon/togishi/blender_manifest.toml").read_text())
    manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    wheels = manifest.pop("wheels")
    assert source.pop("wheels") == []
    assert manifest == source
    names = sorted(name for name in archive.namelist() if name.startswith("wheels/"))
    assert sorted(wheels) == [f"./{name}" for name in names]
    tags = {name.split("-")[2] for name in names}
    assert tags == {f"cp{row.python_label.replace('.', '')}" for row in WHEELS if row.module}


def test_one_version_everywhere():
    """The manifest's, the module's and CMake's: the add-on refuses a module of another version."""
    manifest = tomllib.loads((ROOT / "addon/togishi/blender_manifest.toml").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    cmake = re.search(r"project\(togishi VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())
    assert cmake is not None
    assert manifest["version"] == project["version"] == cmake[1]


def test_manifest_without_its_line_is_refused():
    with pytest.raises(ExtensionError, match="'wheels = \\[\\]' is there 0 times"):
        manifest_text('id = "togishi"\n', ["./wheels/a.whl"])


def test_files_are_those_of_the_source(archive):
    names = archive.namelist()
    for folder in ("addon/togishi", "shaders"):
        prefix = "" if folder == "addon/togishi" else "shaders/"
        for path in (ROOT / folder).rglob("*"):
            inner = path.relative_to(ROOT / folder).as_posix()
            if not path.is_file() or "__pycache__" in inner or inner.startswith("shaders/"):
                continue
            assert prefix + inner in names, inner
            if path.name != "blender_manifest.toml":
                assert archive.read(prefix + inner) == path.read_bytes(), inner
    assert not any("__pycache__" in name or name.endswith((".pyc", "/")) for name in names)


def test_entries_are_plain_files_of_one_date_in_order(archive):
    entries = archive.infolist()
    assert [entry.filename for entry in entries] == sorted(entry.filename for entry in entries)
    assert {entry.external_attr >> 16 for entry in entries} == {0o100644}
    assert len({entry.date_time for entry in entries}) == 1


def test_wheels_hold_what_their_record_says(archive):
    for name in archive.namelist():
        if not name.endswith(".whl"):
            continue
        with zipfile.ZipFile(io.BytesIO(archive.read(name))) as wheel:
            info = next(n for n in wheel.namelist() if n.endswith("/RECORD"))
            rows = [line.split(",") for line in wheel.read(info).decode().splitlines()]
            assert sorted(row[0] for row in rows) == sorted(wheel.namelist())
            for path, _, size in rows:
                assert path == info or len(wheel.read(path)) == int(size)


# Libraries by what their headers are included as, and the text that goes with them.
LICENCES = {
    "glm": "glm.txt",
    "toml++": "tomlplusplus.txt",
    "pybind11": "pybind11.txt",
    "Eigen": "eigen.txt",
    "meshoptimizer": "meshoptimizer.txt",
    "nlohmann": "nlohmann-json.txt",
}


def test_licence_texts_of_all_that_is_compiled_in(archive):
    """A library that is included without a text here fails this test."""
    module_parts = [
        path
        for suffix in ("*.cpp", "*.hpp")
        for path in (ROOT / "cpp_core").rglob(suffix)
        if path.relative_to(ROOT / "cpp_core").parts[0] not in ("cli", "image", "mesh_file")
    ]
    included = set()
    for path in module_parts:
        found = re.findall(r"^#include <([^/>]+)/", path.read_text(), flags=re.MULTILINE)
        included |= {name for name in found if name not in ("sys",)}
    assert {"glm", "toml++", "pybind11"} <= included
    assert included <= LICENCES.keys()
    names = set(archive.namelist())
    texts = {f"licenses/{text}" for text in (*LICENCES.values(), "llvm.txt", "zig.txt")}
    texts |= {"LICENSE", "licenses/README.md", "licenses/CC0-1.0.txt"}
    texts.add("licenses/colour-science-BSD3.txt")
    assert texts <= names
    listed = archive.read("licenses/README.md").decode()
    for text in texts - {"LICENSE", "licenses/README.md"}:
        assert f"`{Path(text).name}`" in listed, text
        assert len(archive.read(text)) > 900, text


def test_licences_of_the_data_files_are_in_the_list(archive):
    used = set()
    for path in (ROOT / "data").rglob("*.*"):
        if path.suffix in (".csv", ".toml"):
            found = re.search(r"^(?:# )?licence[:=\s]+\"?([\w.-]+)", path.read_text(), re.MULTILINE)
            assert found is not None, f"{path} names no licence"
            used.add(found[1])
    listed = archive.read("licenses/README.md").decode()
    assert used
    assert all(name in listed for name in used), used


def copied(source: Path, target: Path) -> Path:
    """What the package is made of, as a checkout of its own."""
    for folder in ("addon", "shaders", "licenses", "tools", "data", "cpp_core/python"):
        shutil.copytree(source / folder, target / folder, symlinks=True, copy_function=shutil.copy)
    for name in ("LICENSE", ".gitignore"):
        shutil.copy(source / name, target / name)
    for environment in {row.environment for row in WHEELS if row.module}:
        (target / environment).symlink_to(ROOT / environment)
    subprocess.run(["git", "init", "-q"], cwd=target, check=True)
    return target


def test_another_folder_other_dates_and_modes_make_the_same_bytes(tmp_path):
    here = copied(ROOT, tmp_path / "here")
    there = copied(here, tmp_path / "a" / "longer" / "path")
    modules = [row.module for row in WHEELS if row.module]
    for path in (there / "addon").rglob("*.py"):
        path.chmod(0o600)
        os.utime(path, (1e9, 1e9))
    digests = []
    for checkout, order in ((here, modules), (there, modules[::-1])):
        command = [sys.executable, checkout / "tools/package/make_package.py"]
        command += ["--out", checkout / "dist"]
        for module in order:
            command += ["--module", module]
        done = subprocess.run(
            [str(part) for part in command],
            env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        digests.append(hashlib.sha256(Path(done.stdout.strip()).read_bytes()).hexdigest())
    assert digests[0] == digests[1]


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        ([], 2, "one of the arguments --python --module --installed is required"),
        (["--python", "3.11"], 2, "it must be VERSION=PATH"),
        (["--module", "togishi_core.so"], 1, "not named togishi_core.cpython-"),
        (["--module", "togishi_core.cpython-311-x86_64-linux-gnu.so"], 1, "is no shared library"),
    ],
)
def test_what_is_wrong_is_said(arguments, code, sentence, tmp_path):
    script = ROOT / "tools/package/make_package.py"
    done = subprocess.run(
        [sys.executable, str(script), *arguments, "--out", str(tmp_path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code
    assert sentence in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_date_that_is_none_is_refused(tmp_path):
    done = subprocess.run(
        [
            sys.executable,
            str(ROOT / "tools/package/make_package.py"),
            "--installed",
            "--out",
            str(tmp_path),
        ],
        env={**os.environ, "SOURCE_DATE_EPOCH": "yesterday"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "SOURCE_DATE_EPOCH='yesterday'" in done.stderr
    assert list(tmp_path.iterdir()) == []
