"""The engine inside Blender: final renders, and what the scene sync reads."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest

pytestmark = pytest.mark.gpu


def add_card(scene, name="card", blade=False, size=1.0, location=(0.0, 0.0, 0.0)):
    mesh = bpy.data.meshes.new(name)
    s = size / 2.0
    mesh.from_pydata([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="togishi_uv")
    part = mesh.attributes.new("togishi_part", "INT", "FACE")
    part.data[0].value = 3
    material = bpy.data.materials.new(name)
    material.togishi.is_blade = blade
    mesh.materials.append(material)
    obj = bpy.data.objects.new(name, mesh)
    obj.location = location
    scene.collection.objects.link(obj)
    return obj


def add_light(scene, kind="POINT", location=(0.3, 0.2, 3.0), energy=300.0):
    light = bpy.data.lights.new("lamp", kind)
    light.energy = energy
    obj = bpy.data.objects.new("lamp", light)
    obj.location = location
    scene.collection.objects.link(obj)
    return obj


def add_camera(scene, location=(0.0, 0.0, 4.0), ortho=False):
    data = bpy.data.cameras.new("camera")
    if ortho:
        data.type, data.ortho_scale = "ORTHO", 2.0
    obj = bpy.data.objects.new("camera", data)
    obj.location = location
    scene.collection.objects.link(obj)
    scene.camera = obj
    return obj


@pytest.fixture
def scene(empty_file, gpu_context, tmp_path):
    scene = bpy.context.scene
    scene.render.engine = "TOGISHI"
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.render.resolution_percentage = 100
    scene.render.filepath = str(tmp_path / "picture.exr")
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.image_settings.color_depth = "32"
    scene.togishi.samples = 4
    return scene


def render(scene) -> np.ndarray:
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def sync_of(view3d=None):
    from togishi.engine.scene_sync import SceneSync

    sync = SceneSync()
    return sync, sync.update(bpy.context.evaluated_depsgraph_get())


class Updates:
    """Hands every update of the depsgraph to a sync, as a viewport does."""

    def __init__(self) -> None:
        from togishi.engine.scene_sync import SceneSync

        self.sync = SceneSync()
        self.data = self.sync.update(bpy.context.evaluated_depsgraph_get())

    def __enter__(self):
        bpy.app.handlers.depsgraph_update_post.append(self._updated)
        return self

    def __exit__(self, *_):
        bpy.app.handlers.depsgraph_update_post.remove(self._updated)

    def _updated(self, _scene, depsgraph):
        self.data = self.sync.update(depsgraph)


# --- final renders ------------------------------------------------------------------------------


def test_final_render_repeats_bit_for_bit(scene):
    add_card(scene, blade=True)
    add_light(scene)
    add_camera(scene)
    first, second = render(scene), render(scene)
    assert np.isfinite(first).all()
    assert first[..., :3].max() > 0.05
    np.testing.assert_array_equal(first, second)


def test_film_is_transparent_on_request(scene):
    add_card(scene, blade=True).rotation_euler.z = 0.3
    add_light(scene)
    add_camera(scene)
    opaque = render(scene)
    scene.render.film_transparent = True
    clear = render(scene)
    assert (opaque[..., 3] == 1.0).all()
    assert clear[0, 0, 3] == 0.0
    assert clear[24, 32, 3] == 1.0
    # Its edges are partly covered, and the colour is premultiplied: nothing is brighter than its share.
    edge = (clear[..., 3] > 0.0) & (clear[..., 3] < 1.0)
    assert edge.any()
    np.testing.assert_allclose(clear[..., :3], opaque[..., :3], atol=1e-5)


def test_border_is_the_same_part_of_the_whole(scene):
    add_card(scene, blade=True)
    add_light(scene)
    add_camera(scene)
    whole = render(scene)
    scene.render.use_border = scene.render.use_crop_to_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.25, 0.75
    part = render(scene)
    assert part.shape == (24, 32, 4)
    np.testing.assert_allclose(part, whole[12:36, 16:48], rtol=1e-3, atol=1e-4)
    scene.render.use_crop_to_border = False
    placed = render(scene)
    assert placed.shape == whole.shape
    np.testing.assert_allclose(placed[12:36, 16:48], whole[12:36, 16:48], rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("ortho", [False, True])
def test_camera_shift_and_lens_show_what_they_should(scene, ortho):
    """A small card appears where Blender's own projection puts it."""
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    add_card(scene, size=0.1, location=(0.35, 0.2, 0.1))
    add_light(scene, energy=3000.0)
    camera = add_camera(scene, ortho=ortho)
    camera.data.shift_x, camera.data.shift_y = 0.1, -0.05
    camera.rotation_euler = (0.05, -0.02, 0.3)
    picture = render(scene)[..., 0]
    bpy.context.view_layer.update()
    expected = world_to_camera_view(scene, camera, Vector((0.35, 0.2, 0.1)))
    rows, columns = np.indices(picture.shape)
    x = (picture * (columns + 0.5)).sum() / picture.sum() / 64
    y = (picture * (rows + 0.5)).sum() / picture.sum() / 48
    assert x == pytest.approx(expected.x, abs=0.01)
    assert y == pytest.approx(expected.y, abs=0.01)


def test_depth_and_part_passes(scene):
    from togishi.core.scene_data import Camera
    from togishi.engine.camera_read import Region
    from togishi.engine.final_render import render_final
    from togishi.engine.renderer import FAR_DEPTH, Renderer

    add_card(scene, blade=True, size=1.0)
    add_card(scene, "stand", blade=False, size=0.4, location=(0.0, 0.0, 1.0))
    camera = add_camera(scene)
    _sync, data = sync_of()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = camera.calc_matrix_camera(depsgraph, x=64, y=48)
    view = Camera(np.linalg.inv(np.array(camera.matrix_world)), np.array(projection, np.float64))
    picture = render_final(
        Renderer(), data, view, (64, 48), Region(0, 0, 64, 48), samples=1, depth=True, part=True
    )
    assert picture.depth[24, 32, 0] == pytest.approx(3.0, rel=1e-5)
    assert picture.part[24, 32, 0] == 0.0
    assert picture.depth[0, 0, 0] == pytest.approx(FAR_DEPTH)
    blade = np.isclose(picture.depth[..., 0], 4.0, rtol=1e-5)
    assert blade.sum() > 20
    assert (picture.part[..., 0][blade] == 3.0).all()
    stopped = render_final(
        Renderer(),
        data,
        view,
        (64, 48),
        Region(0, 0, 64, 48),
        samples=8,
        progress=lambda share: share < 0.5,
    )
    assert stopped is None


def test_passes_reach_the_render_result(scene, tmp_path):
    add_card(scene, blade=True)
    add_light(scene)
    add_camera(scene)
    scene.togishi.use_pass_depth = scene.togishi.use_pass_part = True
    bpy.context.view_layer.update_render_passes()
    render(scene)  # a pass of another size or name raises in end_result


# --- the scene sync -----------------------------------------------------------------------------


def test_objects_modifiers_and_instances(scene):
    card = add_card(scene, blade=True)
    card.modifiers.new("more", "SUBSURF").levels = 2
    card.modifiers["more"].subdivision_type = "SIMPLE"
    twin = bpy.data.objects.new("twin", card.data)
    twin.scale = (-1.0, 2.0, 1.0)
    scene.collection.objects.link(twin)
    empty = bpy.data.objects.new("copy", None)
    group = bpy.data.collections.new("group")
    member = bpy.data.objects.new("member", card.data)
    group.objects.link(member)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    empty.location = (5.0, 0.0, 0.0)
    scene.collection.objects.link(empty)
    bpy.context.view_layer.update()
    _sync, data = sync_of()
    triangles = sorted(data.meshes[i.mesh].triangle_count for i in data.instances)
    assert triangles == [2, 2, 32]
    places = {tuple(np.round(i.matrix[:3, 3], 3)) for i in data.instances}
    assert (5.0, 0.0, 0.0) in places
    assert any(np.linalg.det(i.matrix[:3, :3]) < 0.0 for i in data.instances)


def test_hidden_lights_are_not_there(scene):
    add_card(scene)
    lamp, other = add_light(scene), add_light(scene)
    other.hide_viewport = True
    bpy.context.view_layer.update()
    _sync, data = sync_of()
    assert len(data.lights) == 1
    lamp.hide_viewport = True
    bpy.context.view_layer.update()
    _sync, data = sync_of()
    assert data.lights == ()


def test_an_area_lamp_is_read_with_its_size_axes_and_scale(scene):
    add_light(scene, "AREA")
    lamp = next(obj for obj in scene.objects if obj.type == "LIGHT")
    lamp.data.shape, lamp.data.size, lamp.data.size_y = "RECTANGLE", 0.5, 0.25
    lamp.rotation_euler, lamp.scale = (0.0, math.radians(90.0), 0.0), (2.0, -1.0, 3.0)
    bpy.context.view_layer.update()
    sync, data = sync_of()
    light = data.lights[0]
    assert light.kind.value == "rectangle"
    assert (light.half_u, light.half_v) == pytest.approx((0.5, 0.125))
    assert sync.messages == []
    axes = np.array([light.x_axis, light.y_axis, light.z_axis])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-6)
    # It shines along -z: x cross y is z, though the scale mirrors.
    np.testing.assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=1e-6)
    np.testing.assert_allclose(axes[2], (1.0, 0.0, 0.0), atol=1e-6)
    lamp.data.shape = "DISK"
    bpy.context.view_layer.update()
    assert sync_of()[1].lights[0].kind.value == "ellipse"


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN"])
def test_lamps_of_no_size_are_points(scene, kind):
    add_light(scene, kind)
    lamp = next(obj for obj in scene.objects if obj.type == "LIGHT").data
    for size in (0.0, 0.1):
        setattr(lamp, "angle" if kind == "SUN" else "shadow_soft_size", size)
        bpy.context.view_layer.update()
        light = sync_of()[1].lights[0]
        assert light.sized == (size > 0.0)
        assert max(light.radius, 2.0 * light.half_angle_rad) == pytest.approx(size)


def test_a_light_update_reads_no_mesh_again(scene):
    """What view_update does after a change: everything but the lamp is the object of the last time."""
    add_card(scene, blade=True)
    lamp = add_light(scene)
    bpy.context.view_layer.update()
    with Updates() as view:
        before = view.data
        lamp.data.energy = 17.0
        lamp.location.x = 2.0
        bpy.context.view_layer.update()
    after = view.data
    assert after is not before
    assert after.lights[0].power == 17.0
    assert after.lights[0].position[0] == 2.0
    assert after.instances is before.instances
    assert all(after.meshes[key] is mesh for key, mesh in before.meshes.items())
    assert all(after.materials[key] is value for key, value in before.materials.items())


def test_a_moved_object_is_not_read_again(scene):
    card = add_card(scene, blade=True)
    bpy.context.view_layer.update()
    with Updates() as view:
        before = view.data
        card.location.z = 2.0
        bpy.context.view_layer.update()
    assert view.data.instances[0].matrix[2, 3] == 2.0
    assert view.data.meshes[view.data.instances[0].mesh] is before.meshes[before.instances[0].mesh]


def test_an_edited_mesh_is_read_again(scene):
    card = add_card(scene, blade=True)
    bpy.context.view_layer.update()
    with Updates() as view:
        before = view.data
        card.data.vertices[0].co.x = -3.0
        card.data.update()
        bpy.context.view_layer.update()
    (key,) = view.data.meshes
    assert view.data.meshes[key].position[:, 0].min() == pytest.approx(-3.0)
    assert before.meshes[key] is not view.data.meshes[key]


def test_an_edited_material_is_read_again(scene):
    card = add_card(scene, blade=True)
    bpy.context.view_layer.update()
    with Updates() as view:
        before = view.data
        card.active_material.togishi.ha.mu_t_deg = 11.0
        card.active_material.togishi.ha.mu_b_deg = 11.0
        bpy.context.view_layer.update()
    (key,) = view.data.materials
    assert view.data.materials[key].steel.ha[0] == pytest.approx(math.log(11.0))
    assert view.data.meshes[view.data.instances[0].mesh] is before.meshes[before.instances[0].mesh]


def test_a_missing_map_names_its_file_and_the_blade_is_drawn(scene, tmp_path):
    card = add_card(scene, blade=True)
    add_light(scene)
    add_camera(scene)
    image = bpy.data.images.new("lobes", 4, 4, float_buffer=True, is_data=True)
    image.source = "FILE"
    image.filepath = str(tmp_path / "nowhere.exr")
    card.active_material.togishi.lobes_image = image
    bpy.context.view_layer.update()
    sync, data = sync_of()
    (material,) = data.materials.values()
    assert material.steel.maps is None
    assert any("nowhere.exr" in message for message in sync.messages)
    assert render(scene)[..., :3].max() > 0.05


def test_a_normal_map_is_read_once_and_refused_as_a_colour(scene, tmp_path):
    card = add_card(scene, blade=True)
    settings = card.active_material.togishi
    drawn = bpy.data.images.new("fine shape", 8, 4)
    drawn.pixels.foreach_set(np.tile(np.asarray((0.5, 0.7, 0.9, 1.0), np.float32), 32))
    drawn.filepath_raw, drawn.file_format = str(tmp_path / "fine.png"), "PNG"
    drawn.save()
    image = bpy.data.images.load(drawn.filepath_raw)
    assert not image.colorspace_settings.is_data
    settings.normal_image = image
    assert image.colorspace_settings.is_data  # set by choosing it
    bpy.context.view_layer.update()
    sync, data = sync_of()
    (material,) = data.materials.values()
    maps = material.steel.normal_map
    x, y, width, height = maps.levels[0]
    assert (width, height) == (8, 4)
    np.testing.assert_allclose(maps.leans[y, x], (0.0, 0.5, 0.0, 0.0), atol=0.01)
    again = sync.update(bpy.context.evaluated_depsgraph_get())
    assert next(iter(again.materials.values())).steel.normal_map is maps
    image.colorspace_settings.name = "sRGB"
    sync, data = sync_of()
    assert next(iter(data.materials.values())).steel.normal_map is None
    assert any("Set it to Non-Color" in message for message in sync.messages)
    image.colorspace_settings.name = "Non-Color"
    image.filepath = str(tmp_path / "nowhere.exr")
    sync, data = sync_of()
    assert any("nowhere.exr" in message for message in sync.messages)
    from togishi import map_images

    assert any("nowhere.exr" in problem for problem in map_images.missing(card.active_material))


def test_maps_are_read_from_images(scene):
    card = add_card(scene, blade=True)
    image = bpy.data.images.new("lobes", 8, 4, float_buffer=True, is_data=True)
    image.pixels.foreach_set(np.tile(np.asarray((0.5, 1.5, 0.25, 0.125), np.float32), 32))
    card.active_material.togishi.lobes_image = image
    bpy.context.view_layer.update()
    _sync, data = sync_of()
    (material,) = data.materials.values()
    maps = material.steel.maps
    x, y, width, height = maps.levels[0]
    assert (width, height) == (8, 4)
    assert maps.hadori
    np.testing.assert_allclose(maps.lobes[y, x], (0.5, 1.5, 0.25, 0.125), rtol=2e-3)


def test_world_colour_strength_and_texture_note(scene):
    world = bpy.data.worlds.new("room")
    scene.world = world
    world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    background.inputs["Strength"].default_value = 2.0
    bpy.context.view_layer.update()
    _sync, data = sync_of()
    np.testing.assert_allclose(data.world.radiance, (0.2, 0.4, 0.6), rtol=1e-6)
    sky = world.node_tree.nodes.new("ShaderNodeTexSky")
    world.node_tree.links.new(sky.outputs[0], background.inputs["Color"])
    bpy.context.view_layer.update()
    sync, data = sync_of()
    assert any("no Environment Texture" in message for message in sync.messages)
    np.testing.assert_allclose(data.world.radiance, (0.2, 0.4, 0.6), rtol=1e-6)
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    world.node_tree.links.new(texture.outputs[0], background.inputs["Color"])
    bpy.context.view_layer.update()
    sync, _data = sync_of()
    assert any("has no image" in message for message in sync.messages)


def test_world_hdri(scene):
    """Content, strength, rotation; read again only when the image has changed."""
    world = bpy.data.worlds.new("room")
    scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = next(n for n in nodes if n.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 2.0
    image = bpy.data.images.new("hdri", 16, 8, float_buffer=True)
    pixels = np.full((8, 16, 4), 0.5, np.float32)
    pixels[5, 3, :3] = (1.0, 0.5, 0.25)
    image.pixels.foreach_set(pixels.ravel())
    texture, mapping = (nodes.new(f"ShaderNode{name}") for name in ("TexEnvironment", "Mapping"))
    texture.image = image
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(90.0))
    links.new(texture.outputs[0], background.inputs["Color"])
    links.new(mapping.outputs[0], texture.inputs["Vector"])
    bpy.context.view_layer.update()
    sync, data = sync_of()
    assert not sync.messages
    np.testing.assert_allclose(data.world.radiance, (2.0, 2.0, 2.0))
    np.testing.assert_allclose(data.world.environment.pixels, pixels[..., :3], rtol=1e-3)
    np.testing.assert_allclose(data.world.turn, ((0, -1, 0), (1, 0, 0), (0, 0, 1)), atol=1e-6)
    background.inputs["Strength"].default_value = 3.0
    bpy.context.view_layer.update()
    again = sync.update(bpy.context.evaluated_depsgraph_get())
    assert again.world.environment is data.world.environment
    np.testing.assert_allclose(again.world.radiance, (3.0, 3.0, 3.0))
    mapping.inputs["Scale"].default_value = (2.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    sync, data = sync_of()
    assert data.world.environment is None
    assert any("may only rotate" in message for message in sync.messages)


def test_bake_surroundings(scene):
    """Any nodes as an HDRI that lies the right way, with the strength in it; Cycles' settings are left alone."""
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = next(n for n in nodes if n.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 2.0
    coordinate = nodes.new("ShaderNodeTexCoord")
    links.new(coordinate.outputs["Generated"], background.inputs["Color"])
    bpy.context.view_layer.update()
    before = len(bpy.data.scenes), len(bpy.data.cameras), len(bpy.data.objects)
    assert bpy.ops.world.togishi_bake_surroundings(width=64) == {"FINISHED"}
    assert (len(bpy.data.scenes), len(bpy.data.cameras), len(bpy.data.objects)) == before
    bpy.context.view_layer.update()
    sync, data = sync_of()
    assert not sync.messages
    from togishi.core import surroundings

    towards = surroundings.directions(64, 32)
    # The world's colour is the direction, as far as it is positive; a texel is five degrees.
    got = data.world.environment.pixels * data.world.radiance[0]
    assert np.abs(got - 2.0 * np.maximum(towards, 0.0)).max() < 0.1
    scene.world = None
    with pytest.raises(RuntimeError, match="Needs a world with nodes"):
        bpy.ops.world.togishi_bake_surroundings()


def test_plain_materials(scene):
    card = add_card(scene, blade=False)
    material = card.active_material
    material.use_nodes = True
    principled = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    principled.inputs["Base Color"].default_value = (0.3, 0.1, 0.05, 1.0)
    principled.inputs["Metallic"].default_value = 0.25
    bpy.context.view_layer.update()
    _sync, data = sync_of()
    (plain,) = data.materials.values()
    np.testing.assert_allclose(plain.albedo, (0.3, 0.1, 0.05), rtol=1e-6)
    assert plain.metallic == pytest.approx(0.25)
