"""What is said where the graphics card's driver is too old for the engine."""

from __future__ import annotations

import bpy
import pytest
from togishi import graphics
from togishi.core.graphics import OPENGL_NEEDED, problem


@pytest.mark.parametrize(
    ("backend", "version"),
    [
        ("OPENGL", "4.3"),
        ("OPENGL", "4.5 (Core Profile) Mesa 22.3.6"),
        ("OPENGL", "4.6.0 NVIDIA 535.183.01"),
        ("OPENGL", "10.0"),
        ("VULKAN", "1.3.255"),
        ("METAL", ""),
        ("OPENGL", "unknown"),
    ],
)
def test_new_enough(backend, version):
    assert problem(backend, version) == ""


@pytest.mark.parametrize(
    "version", ["4.1 (Core Profile) Mesa 22.3.6", "3.3.0 - Build 20.19", "4.2"]
)
def test_too_old(version):
    sentence = problem("OPENGL", version)
    assert f"needs OpenGL {'.'.join(map(str, OPENGL_NEEDED))}" in sentence
    assert f"offers {version[:3]}" in sentence
    assert "Update the graphics driver, then restart Blender" in sentence


@pytest.mark.gpu
def test_the_engine_says_it_instead_of_drawing(gpu_context, empty_file, monkeypatch):
    """As on a driver of OpenGL 4.1: F12 ends with the sentence, and the panel shows it in a window."""
    from togishi.ui import native_panels

    monkeypatch.setattr(gpu_context.platform, "version_get", lambda: "4.1 Mesa")
    monkeypatch.setattr(gpu_context.platform, "backend_type_get", lambda: "OPENGL")
    graphics.problem.cache_clear()
    empty_file.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    empty_file.collection.objects.link(empty_file.camera)
    empty_file.render.engine = "TOGISHI"
    empty_file.render.resolution_x = empty_file.render.resolution_y = 8
    try:
        with pytest.raises(RuntimeError, match=r"needs OpenGL 4\.3, and this driver offers 4\.1"):
            bpy.ops.render.render()
        assert graphics.problem().startswith("Togishi's engine needs")
        # The panel asks only where there is a window, and so a context, for sure.
        assert not native_panels.TOGISHI_PT_problem.poll(bpy.context)
    finally:
        monkeypatch.undo()
        graphics.problem.cache_clear()
    assert graphics.problem() == ""
    bpy.ops.render.render()


@pytest.mark.gpu
@pytest.mark.parametrize("error", [ValueError("bad value"), KeyError("nobody expects this")])
def test_a_failure_of_the_engine_is_no_finished_picture(
    gpu_context, empty_file, monkeypatch, error
):
    """Blender by itself calls the render finished, and a farm would keep a black frame."""
    from togishi.engine import render_engine

    def fail(*_arguments, **_keywords):
        raise error

    monkeypatch.setattr(render_engine, "render_final", fail)
    empty_file.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    empty_file.collection.objects.link(empty_file.camera)
    empty_file.render.engine = "TOGISHI"
    empty_file.render.resolution_x = empty_file.render.resolution_y = 8
    with pytest.raises(RuntimeError, match=str(error.args[0])):
        bpy.ops.render.render()
