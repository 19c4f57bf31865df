"""Enabling, disabling, and what the extension says where its native module cannot be used."""

from __future__ import annotations

import builtins
import sys
from pathlib import Path

import bpy
import pytest
from togishi.core import native
from ui_fixtures import ROOT, add_katana, addon, togishi  # noqa: F401

POINTERS = (bpy.types.Material, bpy.types.Light, bpy.types.World, bpy.types.Scene, bpy.types.Object)


def test_registers_twice_and_leaves_nothing_behind():
    before = {cls.__name__ for cls in bpy.types.Panel.__subclasses__() if cls.is_registered}
    for _ in range(2):
        togishi.register()
        assert (
            hasattr(bpy.types, "TOGISHI_OT_katana_add")
            or bpy.ops.mesh.togishi_katana_add.poll() is not None
        )
        assert all(hasattr(owner, "togishi") for owner in POINTERS)
        togishi.unregister()
        assert not any(hasattr(owner, "togishi") for owner in POINTERS)
    after = {cls.__name__ for cls in bpy.types.Panel.__subclasses__() if cls.is_registered}
    assert after == before
    engines = [
        cls
        for cls in bpy.types.Panel.__subclasses__()
        if "TOGISHI" in getattr(cls, "COMPAT_ENGINES", ())
    ]
    assert all("togishi" in cls.__module__ for cls in engines)


class BrokenModule:
    """An import finder that does what the loader does when a library is missing."""

    @staticmethod
    def find_spec(name, _path=None, _target=None):
        if name == "togishi_core":
            raise ImportError("libfoo.so: cannot open shared object file")


@pytest.fixture
def without_core(monkeypatch):
    """A machine on which the native module's library does not load."""
    monkeypatch.delitem(sys.modules, "togishi_core", raising=False)
    monkeypatch.setattr(sys, "meta_path", [BrokenModule, *sys.meta_path])
    native.forget()
    yield
    native.forget()


def test_without_its_module_it_enables_and_says_why(without_core):
    from togishi.ui.native_panels import TOGISHI_PT_problem
    from togishi.ui.view_panels import TOGISHI_PT_view_blade

    togishi.register()
    try:
        assert TOGISHI_PT_problem.poll(bpy.context)
        assert not TOGISHI_PT_view_blade.poll(bpy.context)
        sentence = native.problem()
        assert "libfoo.so" in sentence
        assert "restart Blender" in sentence
        assert not bpy.ops.mesh.togishi_katana_add.poll()
        with pytest.raises(native.CoreMissingError, match=r"libfoo\.so"):
            native.core()
        light = bpy.data.lights.new("lamp", "POINT")
        light.togishi.choice = "blackbody"
        assert light.togishi.kind == "blackbody"
    finally:
        togishi.unregister()


def test_an_older_module_is_named(monkeypatch):
    class Old:
        __version__ = "0.0.1"
        InputError = ValueError

    monkeypatch.setitem(sys.modules, "togishi_core", Old)
    native.forget()
    assert "another version (0.0.1" in native.problem()
    monkeypatch.undo()
    native.forget()
    assert native.problem() == ""


def test_blenders_own_panels_show_for_our_engine(addon):  # noqa: F811
    names = {
        cls.__name__
        for cls in bpy.types.Panel.__subclasses__()
        if "TOGISHI" in getattr(cls, "COMPAT_ENGINES", ()) and "togishi" not in cls.__module__
    }
    from togishi.ui.shared_panels import EXCLUDED

    assert not names & EXCLUDED
    assert {
        "DATA_PT_EEVEE_light",
        "DATA_PT_camera",
        "EEVEE_WORLD_PT_surface",
        "RENDER_PT_output",
    } & names >= {
        "DATA_PT_EEVEE_light",
        "DATA_PT_camera",
        "EEVEE_WORLD_PT_surface",
    }


def test_drawing_a_panel_does_no_work(addon, monkeypatch):  # noqa: F811
    """Panels read settings. A recording layout stands in for Blender's."""
    from togishi.ui import material_panels

    obj = add_katana()
    material = obj.active_material
    bpy.ops.material.togishi_nodes_connect(spectrum="A")

    class Layout:
        texts: list[str] = []

        def __getattr__(self, _name):
            def call(*_args, **settings):
                if "text" in settings:
                    Layout.texts.append(settings["text"])
                return self

            return call

    def refuse(*_args, **_settings):
        raise AssertionError("draw() called the core or a file")

    core = native.core()
    for name in ("fresnel_table", "delta_e00", "steel_pattern", "katana", "load_material"):
        monkeypatch.setattr(core, name, refuse)
    monkeypatch.setattr(builtins, "open", refuse)
    for draw in (material_panels.draw_steel, material_panels.draw_maps, material_panels.draw_nodes):
        draw(Layout(), material)
    assert any(text.startswith("D65: 1.0") for text in Layout.texts), Layout.texts


def test_manifest_is_complete():
    import tomllib

    manifest = tomllib.loads((ROOT / "addon/togishi/blender_manifest.toml").read_text())
    assert manifest["id"] == "togishi"
    assert manifest["blender_version_min"] == "4.2.0"
    assert all(
        len(text) <= 64 and not text.endswith(".") for text in manifest["permissions"].values()
    )
    assert Path(ROOT / "addon/togishi/__init__.py").is_file()
