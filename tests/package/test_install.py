"""The extension's zip in Blenders that have never seen it."""

from __future__ import annotations

import pytest
from clean_blender import CleanBlender, make_package, with_other_wheel


def test_install_use_and_uninstall(blender: CleanBlender, package):
    """As a user does it: the module is the extension's own, a picture is rendered, nothing is left behind."""
    answer = blender.run("life", package)
    assert answer["said"] == ""
    assert answer["enabled"]
    assert answer["problem"] == ""
    assert answer["module"].startswith(str(blender.site_packages))
    assert package.name == f"togishi-{answer['version']}-linux_x64.zip"
    assert answer["polygons"] > 100
    assert answer["finite"]
    assert answer["brightest"] > 0.05
    assert answer["disabled"]
    assert answer["enabled_again"]
    assert answer["problem_again"] == ""
    assert answer["polygons_again"] == answer["polygons"]
    assert answer["uninstalled"]
    assert any(name.endswith("blender_manifest.toml") for name in answer["files"])
    assert answer["files_left"] == []
    assert answer.code == 0, answer.output
    assert "Traceback" not in answer.output


def test_a_wheel_for_another_python_is_refused_by_blender(blender: CleanBlender, package):
    """Blender's own sentence, which the guide explains: the files are there, but it does not enable them."""
    other = (3, 12)
    tag = "cp312-cp312-manylinux_2_28_x86_64"
    zip_path = with_other_wheel(package, blender.folder, {"togishi_core.py": b""}, tag)
    answer = blender.run("state", zip_path)
    ours, theirs = (".".join(map(str, version)) for version in (blender.row.python, other))
    assert f"This Python version ({ours}) isn't compatible with ({theirs})" in answer["said"]
    assert not answer["enabled"]
    assert not blender.site_packages.exists()
    assert answer.code == 0, answer.output


def test_the_same_version_installed_again_brings_its_own_module(blender: CleanBlender, package):
    """Blender keeps wheels whose name it knows, so ours are named by what they hold. What is in memory stays there
    until Blender ends, and the extension says so."""
    module = blender.row.module
    assert module is not None
    tag = blender.row.python_label.replace(".", "")
    newer = with_other_wheel(
        package,
        blender.folder,
        {module.name: module.read_bytes(), "togishi_core.pyi": b"# of another build\n"},
        f"cp{tag}-cp{tag}-manylinux_2_35_x86_64",
    )
    answer = blender.run("reinstall", package, newer)
    assert answer["first"] == answer["second"] == answer["first_problem"] == ""
    assert answer["polygons"] > 100
    assert answer["enabled"]
    assert "is still the earlier one" in answer["problem"]
    assert answer["problem"].endswith("Restart Blender.")
    assert answer["panel"]
    assert not answer["can_add"]
    assert (blender.site_packages / "togishi_core.pyi").read_text() == "# of another build\n"
    after = blender.run("state")
    assert after["problem"] == ""
    assert after["can_add"]
    assert answer.code == after.code == 0, answer.output + after.output


def test_with_an_opengl_that_blender_does_not_draw_with(installed: CleanBlender):
    """The extension does not ask the graphics card before something is drawn: it is enabled there too."""
    installed.environment["MESA_GL_VERSION_OVERRIDE"] = "4.1"
    answer = installed.run("state")
    assert answer["enabled"]
    assert answer["problem"] == ""
    assert answer["can_add"]
    assert answer.code == 0, answer.output


# --- modules that do not load -------------------------------------------------------------------


def truncate(library) -> None:
    content = library.read_bytes()[:40]
    library.unlink()
    library.write_bytes(content)


def ask_for_a_missing_library(library) -> None:
    content = library.read_bytes()
    assert content.count(b"\0libm.so.6\0") == 1
    library.unlink()
    library.write_bytes(content.replace(b"\0libm.so.6\0", b"\0libq.so.6\0"))


def remove(library) -> None:
    library.unlink()


def take_an_older_one(library) -> None:
    library.unlink()
    (library.parent / "togishi_core.py").write_text("__version__ = '0.0.1'\n")


@pytest.mark.parametrize(
    ("damage", "reason", "remedy"),
    [
        (truncate, "does not load in Python", "install the package made for this platform"),
        (ask_for_a_missing_library, "libq.so.6: cannot open", "restart Blender"),
        (remove, "is not installed for Python", "install the package made for this platform"),
        (take_an_older_one, "from another version (0.0.1; the add-on is", "then install it again"),
    ],
)
def test_where_the_module_does_not_load_the_panel_says_why(
    installed: CleanBlender, damage, reason, remedy
):
    """The extension is enabled all the same; one sentence says what is wrong, the next what to do."""
    (library,) = installed.site_packages.glob("togishi_core*.so")
    damage(library)
    answer = installed.run("state")
    assert answer["enabled"]
    assert answer["panel"]
    assert not answer["can_add"]
    wrong, _, to_do = answer["problem"].partition(". ")
    assert reason in wrong
    assert remedy in to_do
    assert answer.code == 0, answer.output
    assert "Traceback" not in answer.output


def test_an_add_on_of_another_version_than_its_module_says_so(blender: CleanBlender, tmp_path):
    assert blender.row.module is not None
    answer = blender.run("state", make_package(tmp_path, blender.row.module, version="9.8.7"))
    assert answer["enabled"]
    assert "the add-on is 9.8.7)" in answer["problem"]
    assert answer["panel"]
