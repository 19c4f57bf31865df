"""What a review found in the engine: borders, doubled curves, lamps without Normalize, links through Reroutes."""

from __future__ import annotations

import math
import signal
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from test_engine_blender import add_camera, add_light, scene  # noqa: F401
from togishi import blender_versions, cli
from togishi.engine.camera_read import border_region, whole_size
from togishi.engine.light_read import read_light
from togishi.engine.material_read import read_plain
from togishi.engine.render_engine import TogishiRenderEngine, _Viewport
from togishi.engine.scene_sync import SceneSync

pytestmark = pytest.mark.gpu


def test_border_has_blenders_size(scene):  # noqa: F811
    """Blender multiplies in single precision: its result refuses a picture that is a pixel larger."""
    add_camera(scene)
    render = scene.render
    render.resolution_x = render.resolution_y = 100
    render.use_border = render.use_crop_to_border = True
    scene.togishi.samples = 1
    for low, high in ((0.7, 1.0), (0.29, 0.58), (0.01, 0.57)):
        render.border_min_x = render.border_min_y = low
        render.border_max_x = render.border_max_y = high
        first, last = (int(np.float32(v) * np.float32(100)) for v in (low, high))
        region = border_region(render, (100, 100))
        assert (region.x, region.width, region.height) == (first, last - first, last - first)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath, check_existing=False)
        assert tuple(image.size) == (last - first, last - first)


def test_percentage_in_whole_numbers(empty_file):
    render = empty_file.render
    for pixels, percentage in ((1000, 29), (100, 57), (1920, 33), (4, 10)):
        render.resolution_x, render.resolution_y = pixels, pixels
        render.resolution_percentage = percentage
        expected = max(pixels * percentage // 100, 1)
        assert whole_size(render) == (expected, expected)


@pytest.mark.parametrize("kind", ["text", "metaball", "surface", "curve"])
def test_surfaces_are_drawn_once(empty_file, kind):
    if kind == "text":
        bpy.ops.object.text_add()
    elif kind == "metaball":
        bpy.ops.object.metaball_add()
    elif kind == "surface":
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    else:
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
    sync = SceneSync()
    assert len(sync.update(bpy.context.evaluated_depsgraph_get()).instances) == 1


@pytest.mark.parametrize("subdivided", [False, True])
def test_mesh_in_edit_mode_is_drawn(empty_file, subdivided):
    bpy.ops.mesh.primitive_cube_add()
    if subdivided:
        bpy.context.object.modifiers.new("subdivision", "SUBSURF")
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        data = SceneSync().update(bpy.context.evaluated_depsgraph_get())
        assert len(data.instances) == 1
        assert data.meshes[data.instances[0].mesh].groups
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize(
    ("shape", "area"),
    [("SQUARE", 4.0), ("RECTANGLE", 6.0), ("DISK", math.pi), ("ELLIPSE", 1.5 * math.pi)],
)
def test_area_lamp_without_normalize(empty_file, shape, area):
    lamp = bpy.data.lights.new("lamp", "AREA")
    if not hasattr(lamp, "normalize"):
        pytest.skip("this version's lamps are always normalised")
    lamp.shape, lamp.size, lamp.size_y, lamp.energy = shape, 2.0, 3.0, 5.0
    lamp.normalize = False
    assert not blender_versions.light_is_normalised(lamp)
    assert read_light(lamp, np.eye(4)).power == pytest.approx(5.0 * area)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal_inside_an_engine_stops_the_command(empty_file, monkeypatch, tmp_path, number):
    """Blender swallows the exception; nothing may be saved afterwards."""

    def render(**_options):
        try:
            signal.raise_signal(number)
        except KeyboardInterrupt:
            return {"FINISHED"}
        raise AssertionError("no signal came")

    monkeypatch.setattr(
        cli, "bpy", SimpleNamespace(ops=SimpleNamespace(render=SimpleNamespace(render=render)))
    )
    path = tmp_path / "picture.png"
    with pytest.raises(KeyboardInterrupt), cli._terminable():
        cli._render_frame(empty_file, 1, path)
    assert not path.exists()


def test_viewport_says_what_failed(monkeypatch, capsys):
    """An error while reading is shown, and printed with its place."""

    def fail(*_arguments):
        raise RuntimeError("no memory")

    monkeypatch.setattr(SceneSync, "update", fail)
    shown = []
    engine = SimpleNamespace(_viewport=_Viewport(), update_stats=lambda *texts: shown.append(texts))
    engine._show = lambda error: TogishiRenderEngine._show(engine, error)
    TogishiRenderEngine.view_update(engine, SimpleNamespace(space_data=None), None)
    assert "The engine Togishi failed" in shown[0][1]
    assert "no memory" in capsys.readouterr().err
    assert engine._viewport is None


def test_principled_behind_a_reroute_and_muted(empty_file):
    material = bpy.data.materials.new("wood")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    reroute = tree.nodes.new("NodeReroute")
    shader.inputs["Base Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    tree.links.new(shader.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], output.inputs["Surface"])
    assert read_plain(material).albedo == pytest.approx((0.1, 0.2, 0.3))
    shader.mute = True
    assert read_plain(material).albedo == pytest.approx(tuple(material.diffuse_color[:3]))


def test_lamp_that_appears_without_an_update_is_read(empty_file):
    """A driver on "disable in viewports" tells nothing but an update of the lamps."""
    lamp = add_light(empty_file)
    lamp.hide_viewport = True
    sync = SceneSync()
    assert len(sync.update(bpy.context.evaluated_depsgraph_get()).lights) == 0
    sync._forget_changed = lambda _depsgraph: True
    lamp.hide_viewport = False
    assert len(sync.update(bpy.context.evaluated_depsgraph_get()).lights) == 1


def test_stereoscopy_is_refused(scene):  # noqa: F811
    add_camera(scene)
    scene.render.use_multiview = True
    with pytest.raises(RuntimeError, match="stereoscopy"):
        bpy.ops.render.render()
