"""The power scale: a grey card under one lamp has the value that Cycles gives it, within 2 %."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest

pytestmark = pytest.mark.gpu


def point(light, obj):
    light.energy, light.shadow_soft_size = 100.0, 0.05
    obj.location = (0.0, 0.0, 2.0)


def coloured_point(light, obj):
    light.energy, light.shadow_soft_size = 37.0, 0.0
    light.color = (1.0, 0.5, 0.2)
    obj.location = (0.7, 0.2, 1.3)


def sun(light, obj):
    light.energy = 3.0
    obj.rotation_euler = (math.radians(40.0), 0.0, 0.0)


def spot(light, obj):
    light.energy, light.shadow_soft_size = 100.0, 0.0
    light.spot_size, light.spot_blend = math.radians(60.0), 0.5
    obj.location = (0.0, 0.0, 2.0)


def spot_edge(light, obj):
    spot(light, obj)
    obj.location = (0.9, 0.0, 2.0)


def spot_turned(light, obj):
    spot(light, obj)
    obj.location = (1.2, -0.4, 1.5)
    obj.rotation_euler = (0.25, 0.5, 0.3)
    light.spot_blend = 1.0


def spot_scaled(light, obj):
    spot(light, obj)
    light.spot_blend = 0.7
    obj.location, obj.scale = (0.9, 0.2, 2.0), (1.5, 0.8, 1.0)


def exposure(light, obj):
    point(light, obj)
    if not hasattr(light, "exposure"):
        pytest.skip("this Blender has no light exposure")
    light.exposure = 1.5


def not_normalised(light, obj):
    point(light, obj)
    light.shadow_soft_size = 0.1
    if not hasattr(light, "normalize"):
        pytest.skip("this Blender always normalises")
    light.normalize = False


def sun_not_normalised(light, obj):
    sun(light, obj)
    light.angle = 0.2
    if not hasattr(light, "normalize"):
        pytest.skip("this Blender always normalises")
    light.normalize = False


def temperature(light, obj):
    point(light, obj)
    if not hasattr(light, "use_temperature"):
        pytest.skip("this Blender has no light temperature")
    light.use_temperature, light.temperature = True, 3200.0


def area(shape, size, size_y=0.25, **more):
    def setup(light, obj):
        light.energy, light.shape, light.size, light.size_y = 100.0, shape, size, size_y
        obj.location = more.get("location", (0.0, 0.0, 2.0))
        obj.rotation_euler = more.get("rotation", (0.0, 0.0, 0.0))
        obj.scale = more.get("scale", (1.0, 1.0, 1.0))
        light.spread = more.get("spread", math.pi)

    setup.__name__ = f"area_{shape}_{'_'.join(more) or 'plain'}".lower()
    return setup


def area_not_normalised(light, obj):
    area("RECTANGLE", 0.5, 0.25, scale=(2.0, 1.5, 1.0))(light, obj)
    if not hasattr(light, "normalize"):
        pytest.skip("this Blender always normalises")
    light.normalize = False


def sphere(light, obj):
    light.energy, light.shadow_soft_size = 100.0, 0.5
    obj.location = (0.4, 0.0, 1.2)


def sphere_across_the_horizon(light, obj):
    light.energy, light.shadow_soft_size = 100.0, 0.5
    obj.location = (1.0, 0.3, 0.2)


def sphere_scaled(light, obj):
    sphere_across_the_horizon(light, obj)
    obj.scale = (1.5, 1.5, 1.5)


def spot_with_radius(light, obj):
    spot(light, obj)
    light.shadow_soft_size = 0.2
    obj.location = (0.5, 0.0, 2.0)


def wide_sun(light, obj):
    light.energy, light.angle = 3.0, 1.2
    obj.rotation_euler = (math.radians(70.0), 0.0, 0.0)


def high_sun(light, obj):
    light.energy, light.angle = 3.0, 0.5
    obj.rotation_euler = (math.radians(25.0), math.radians(20.0), 0.0)


TURNED = {"location": (1.2, -0.4, 1.0), "rotation": (0.25, 0.9, 0.3)}
LOW = {"location": (1.0, 0.2, 0.1), "rotation": (0.0, 1.4, 0.5)}

CASES = [
    ("POINT", point),
    ("POINT", coloured_point),
    ("POINT", exposure),
    ("POINT", not_normalised),
    ("SUN", sun),
    ("SUN", sun_not_normalised),
    ("SPOT", spot),
    ("SPOT", spot_edge),
    ("SPOT", spot_turned),
    ("SPOT", spot_scaled),
]
SIZED = [
    ("POINT", sphere),
    ("POINT", sphere_across_the_horizon),
    ("POINT", sphere_scaled),
    ("SPOT", spot_with_radius),
    ("SUN", wide_sun),
    ("AREA", area("SQUARE", 0.5)),
    ("AREA", area("RECTANGLE", 2.0, 0.5, **TURNED)),
    ("AREA", area("RECTANGLE", 2.0, 0.5, scale=(0.5, 3.0, 2.0))),
    ("AREA", area("RECTANGLE", 0.5, 0.25, scale=(-2.0, 1.5, 1.0), **TURNED)),
    ("AREA", area("SQUARE", 1.0, **LOW)),
    ("AREA", area("DISK", 1.0)),
    ("AREA", area("ELLIPSE", 2.0, 1.0, **TURNED)),
    ("AREA", area("ELLIPSE", 0.5, 1.0, scale=(2.0, 0.5, 1.0), **TURNED)),
    ("AREA", area("DISK", 0.2, location=(0.5, 0.0, 1.5), spread=1.5)),
    ("AREA", area_not_normalised),
]


def rendered(
    scene: bpy.types.Scene,
    engine: str,
    size: tuple[int, int],
    samples: int,
    path: str,
    bounces: int = 0,
) -> np.ndarray:
    """(H, W, 3) linear pixels of a final render; samples, bounces: of Cycles."""
    render = scene.render
    render.resolution_x, render.resolution_y = size
    render.engine = engine
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = path
    if engine == "CYCLES":
        scene.cycles.samples = samples
        scene.cycles.use_denoising = False
        scene.cycles.max_bounces = bounces
        scene.cycles.sample_clamp_direct = 0.0
    bpy.ops.render.render(write_still=True)
    pixels = np.array(bpy.data.images.load(path).pixels[:])
    return pixels.reshape(size[1], size[0], 4)[..., :3]


def matt(colour: tuple[float, float, float]) -> bpy.types.Material:
    """A diffuse material."""
    material = bpy.data.materials.new("matt")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*colour, 1.0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def look_down(scene: bpy.types.Scene) -> None:
    """A camera that looks at the origin from the front and above."""
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.0, -2.2, 1.4), (math.radians(60.0), 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera


def card_value(
    engine: str, albedo: float, kind: str, setup: Callable[[object, object], None], path: str
) -> np.ndarray:
    """Mean linear RGB of a small diffuse card at the origin, looking up."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("card")
    corners = [(-0.05, -0.05, 0.0), (0.05, -0.05, 0.0), (0.05, 0.05, 0.0), (-0.05, 0.05, 0.0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    scene.collection.objects.link(bpy.data.objects.new("card", mesh))
    material = matt((albedo, albedo, albedo))
    mesh.materials.append(material)
    light = bpy.data.lights.new("lamp", kind)
    lamp = bpy.data.objects.new("lamp", light)
    scene.collection.objects.link(lamp)
    setup(light, lamp)
    data = bpy.data.cameras.new("camera")
    data.type, data.ortho_scale = "ORTHO", 0.09
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0.0, 0.0, 0.3)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return rendered(scene, engine, (8, 8), 32, path).mean(axis=(0, 1))


@pytest.mark.parametrize(
    ("kind", "setup"), SIZED, ids=lambda value: getattr(value, "__name__", value)
)
def test_grey_card_under_a_lamp_of_a_size_as_in_cycles(addon, tmp_path, kind, setup):
    test_grey_card_as_in_cycles(addon, tmp_path, kind, setup, 0.8)


@pytest.mark.parametrize("albedo", [0.18, 0.8])
@pytest.mark.parametrize(
    ("kind", "setup"), CASES, ids=lambda value: getattr(value, "__name__", value)
)
def test_grey_card_as_in_cycles(addon, tmp_path, kind, setup, albedo):
    ours = card_value("TOGISHI", albedo, kind, setup, str(tmp_path / "ours.exr"))
    cycles = card_value("CYCLES", albedo, kind, setup, str(tmp_path / "cycles.exr"))
    assert cycles.min() > 1e-4
    np.testing.assert_allclose(ours, cycles, rtol=0.02)


def test_temperature_keeps_the_luminance(addon, tmp_path):
    """A temperature becomes a spectrum here and a tint in Cycles: same luminance, nearly the same colour."""
    ours = card_value("TOGISHI", 0.8, "POINT", temperature, str(tmp_path / "ours.exr"))
    cycles = card_value("CYCLES", 0.8, "POINT", temperature, str(tmp_path / "cycles.exr"))
    luminance = np.asarray((0.2126, 0.7152, 0.0722))
    assert ours @ luminance == pytest.approx(cycles @ luminance, rel=0.02)
    np.testing.assert_allclose(ours, cycles, rtol=0.05)


def hdri_picture(engine: str, kind: str, sun: float, path: str) -> np.ndarray:
    """(24, 32, 3) linear RGB: a grey card in the left half of a view into an HDRI that is turned about all axes."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("card")
    mesh.from_pydata([(0, -9, -9), (9, -9, -9), (9, -9, 9), (0, -9, 9)], [], [(0, 1, 2, 3)])
    scene.collection.objects.link(bpy.data.objects.new("card", mesh))
    material = matt((0.8, 0.8, 0.8))
    mesh.materials.append(material)
    u, v = np.meshgrid((np.arange(128) + 0.5) / 128, (np.arange(64) + 0.5) / 64)
    pixels = np.ones((64, 128, 4), np.float32)
    for channel in range(3):
        wave = np.cos(2.0 * math.pi * (u * (channel + 1) + 0.2 * channel)) * np.sin(math.pi * v)
        pixels[..., channel] = 1.0 + 0.6 * wave + 0.3 * np.cos(math.pi * v)
    if sun:
        pixels[30, 30, :3] = sun
    image = bpy.data.images.new("hdri", 128, 64, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    scene.world = bpy.data.worlds.new("room")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    texture, mapping, coordinate = (
        tree.nodes.new(f"ShaderNode{name}") for name in ("TexEnvironment", "Mapping", "TexCoord")
    )
    texture.image = image
    mapping.vector_type = kind
    mapping.inputs["Rotation"].default_value = (0.3, -0.5, 0.9)
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 0.7
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], background.inputs["Color"])
    data = bpy.data.cameras.new("camera")
    data.lens = 18.0
    camera = bpy.data.objects.new("camera", data)
    # Along -y, the card facing it.
    camera.rotation_euler = (math.radians(90.0), 0.0, math.radians(180.0))
    scene.collection.objects.link(camera)
    scene.camera = camera
    return rendered(scene, engine, (32, 24), 128, path)


@pytest.mark.parametrize(("kind", "sun"), [("POINT", 0.0), ("TEXTURE", 3.0e3)])
def test_hdri_as_in_cycles(addon, tmp_path, kind, sun):
    """Which way it lies, its strength, the light that it throws on a card; with a sun in it."""
    ours = hdri_picture("TOGISHI", kind, sun, str(tmp_path / "ours.exr"))
    cycles = hdri_picture("CYCLES", kind, sun, str(tmp_path / "cycles.exr"))
    # The camera looks along -y: x grows to the left.
    halves = {"ground": slice(18, 32), "card": slice(0, 14)}
    assert ours[:, halves["card"]].std(axis=(0, 1)).max() < 0.01, "the card is evenly lit"
    ground = ours[:, halves["ground"]], cycles[:, halves["ground"]]
    usual = ground[1].max(axis=-1) < 3.0
    np.testing.assert_allclose(ground[0][usual], ground[1][usual], rtol=0.03)
    mine, theirs = (picture[:, halves["card"]].mean(axis=(0, 1)) for picture in (ours, cycles))
    print(mine, theirs)
    np.testing.assert_allclose(mine, theirs, rtol=0.02)


def shadow_picture(
    engine: str,
    kind: str,
    setup: Callable[[object, object], None],
    path: str,
    *,
    shadows: bool,
) -> np.ndarray:
    """(36, 48, 3) linear RGB: a post with a board on it over a grey floor."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    material = matt((0.5, 0.5, 0.5))
    for place, size in (
        ((0.0, 0.0, -0.05), (8.0, 8.0, 0.1)),
        ((0.0, 0.0, 0.2), (0.06, 0.06, 0.4)),
        ((0.1, 0.0, 0.45), (0.6, 0.3, 0.02)),
    ):
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=place)
        bpy.context.object.scale = size
        bpy.context.object.data.materials.append(material)
    light = bpy.data.lights.new("lamp", kind)
    lamp = bpy.data.objects.new("lamp", light)
    scene.collection.objects.link(lamp)
    setup(light, lamp)
    light.use_shadow = shadows
    look_down(scene)
    scene.togishi.samples = 64
    return rendered(scene, engine, (48, 36), 512, path)


@pytest.mark.parametrize(
    ("kind", "setup"),
    [
        ("AREA", area("RECTANGLE", 1.0, 0.4, location=(0.5, -0.4, 1.5), rotation=(0.2, 0.3, 0.1))),
        ("AREA", area("DISK", 0.8, location=(-0.4, 0.2, 1.2))),
        ("POINT", sphere),
        ("POINT", coloured_point),
        ("SPOT", spot_with_radius),
        ("SUN", high_sun),
    ],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_shadows_as_in_cycles(addon, tmp_path, kind, setup):
    def lost(engine: str) -> np.ndarray:
        """What is hidden from the picture: outlines, which are filtered differently, are in both and cancel."""
        path = str(tmp_path / f"{engine}.exr")
        pictures = [shadow_picture(engine, kind, setup, path, shadows=on) for on in (False, True)]
        return (pictures[0] - pictures[1]) / pictures[0].max()

    ours, cycles = lost("TOGISHI"), lost("CYCLES")
    assert cycles.max() > 0.1, "something lies in shadow"
    apart = np.abs(ours - cycles)
    print(apart.mean(), np.percentile(apart, 98.0))
    assert apart.mean() < 0.003
    # Sharp ends of shadows are filtered as outlines are.
    assert np.percentile(apart, 98.0) < 0.04


def window_picture(engine: str, turn_deg: float, shader: str, path: str) -> np.ndarray:
    """(36, 48, 3) linear RGB: a rectangle that shines with a picture of four colours, above a grey floor."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=8.0)
    grey = matt((0.5, 0.5, 0.5))
    bpy.context.object.data.materials.append(grey)
    image = bpy.data.images.new("panes", 64, 32, float_buffer=True)
    pixels = np.ones((32, 64, 4), np.float32)
    pixels[:16, :32, :3], pixels[:16, 32:, :3] = (1.0, 0.1, 0.1), (0.1, 1.0, 0.1)
    pixels[16:, :32, :3], pixels[16:, 32:, :3] = (0.1, 0.1, 1.0), (1.0, 1.0, 0.2)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    bpy.ops.mesh.primitive_plane_add(size=1.0, location=(0.2, 0.4, 0.45))
    window = bpy.context.object
    window.scale = (1.6, 0.8, 1.0)
    window.rotation_euler = (math.radians(80.0), 0.0, math.radians(turn_deg))
    shining = bpy.data.materials.new("window")
    shining.use_nodes = True
    tree = shining.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    if shader == "principled":
        node = tree.nodes["Principled BSDF"]
        node.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
        node.inputs["Specular IOR Level"].default_value = 0.0
        node.inputs["Emission Strength"].default_value = 2.0
        tree.links.new(texture.outputs[0], node.inputs["Emission Color"])
    else:
        node = tree.nodes.new("ShaderNodeEmission")
        node.inputs["Strength"].default_value = 2.0
        tree.links.new(texture.outputs[0], node.inputs["Color"])
        end = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        tree.links.new(node.outputs[0], end.inputs["Surface"])
    window.data.materials.append(shining)
    look_down(scene)
    scene.togishi.samples = 16
    return rendered(scene, engine, (48, 36), 512, path)


@pytest.mark.parametrize(
    ("turn_deg", "shader"), [(0.0, "emission"), (180.0, "emission"), (25.0, "principled")]
)
def test_a_rectangle_that_shines_with_a_picture_as_in_cycles(addon, tmp_path, turn_deg, shader):
    """Seen itself, from its front and its back, and by the coloured light that it throws on the floor."""
    ours = window_picture("TOGISHI", turn_deg, shader, str(tmp_path / "ours.exr"))
    cycles = window_picture("CYCLES", turn_deg, shader, str(tmp_path / "cycles.exr"))
    apart = np.abs(ours - cycles) / cycles.max()
    print(apart.mean(), np.percentile(apart, 95.0))
    floor = slice(0, 14)
    assert cycles[floor].std(axis=1).max() > 0.03, "the floor shows its colours"
    np.testing.assert_allclose(
        ours[floor].mean(axis=0), cycles[floor].mean(axis=0), rtol=0.06, atol=0.01 * cycles.max()
    )
    assert apart[floor].mean() < 0.01
    assert np.percentile(apart, 90.0) < 0.02


def test_a_ball_that_shines_is_bright_and_said_to_light_nothing(addon, tmp_path):
    from togishi.engine.scene_sync import SceneSync

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_uv_sphere_add()
    material = bpy.data.materials.new("lamp")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 3.0
    bpy.context.object.data.materials.append(material)
    sync = SceneSync()
    data = sync.update(bpy.context.evaluated_depsgraph_get())
    assert not data.lights
    assert any("is no single rectangle" in message for message in sync.messages)
    assert max(next(iter(data.materials.values())).shine) == pytest.approx(3.0)


def exhibited(engine: str, path: str) -> np.ndarray:
    """(60, 160, 3) linear RGB: a katana on a post, over a cloth, beside a card, under a soft box and a bulb."""
    from mathutils import Vector
    from togishi import blade_object
    from togishi.nodes import steel_group

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.togishi_katana_add()
    blade = bpy.context.object
    if engine == "CYCLES":
        steel_group.connect(blade.data.materials[0])
        blade_object.turn_tangents(blade.data)
    middle = Vector((0.26, 0.0, -0.015))
    for colour, place, size in (
        ((0.25, 0.05, 0.06), (0.0, 0.0, -0.12), (1.5, 0.5, 0.005)),  # cloth
        ((0.12, 0.06, 0.03), (0.1, 0.0, -0.08), (0.02, 0.03, 0.08)),  # post
        ((0.6, 0.6, 0.55), (0.05, -0.25, 0.0), (0.1, 0.004, 0.06)),  # card
    ):
        material = matt(colour)
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=middle + Vector(place))
        bpy.context.object.scale = size
        bpy.context.object.data.materials.append(material)
    for kind, place, energy in (
        ("AREA", (0.1, -0.35, 0.55), 18.0),
        ("POINT", (-0.3, -0.3, 0.35), 4.0),
    ):
        light = bpy.data.lights.new("lamp", kind)
        light.energy = energy
        if kind == "AREA":
            light.shape, light.size, light.size_y = "RECTANGLE", 0.5, 0.25
        else:
            light.shadow_soft_size = 0.02
        lamp = bpy.data.objects.new("lamp", light)
        lamp.location = middle + Vector(place)
        lamp.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = middle + Vector((0.0, -0.75, 0.32))
    camera.rotation_euler = Vector((0.0, 0.75, -0.34)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.togishi.samples = 32
    if engine == "CYCLES":
        scene.cycles.sample_clamp_indirect = 0.0
        scene.cycles.blur_glossy = 0.0
        scene.cycles.diffuse_bounces, scene.cycles.glossy_bounces = 0, 1
    return rendered(scene, engine, (160, 60), 512, path, bounces=1)


def test_an_exhibited_katana_as_in_cycles(addon, tmp_path):
    """The soft box and the bulb on the steel, shadows on the cloth, cloth, card and post in the blade's mirror."""
    ours = exhibited("TOGISHI", str(tmp_path / "ours.exr"))
    cycles = exhibited("CYCLES", str(tmp_path / "cycles.exr"))
    apart = np.abs(ours - cycles) / np.percentile(cycles, 99.0)
    print(apart.mean(), np.percentile(apart, 95.0), ours.mean(), cycles.mean())
    np.testing.assert_allclose(ours.mean(axis=(0, 1)), cycles.mean(axis=(0, 1)), rtol=0.04)
    assert apart.mean() < 0.02
    assert np.percentile(apart, 90.0) < 0.05
