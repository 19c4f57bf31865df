"""Operators on blades that are linked, shared, copied, or not where a fresh file has them."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from ui_fixtures import DETAIL, add_katana, addon  # noqa: F401

pytestmark = pytest.mark.usefixtures("addon")

from togishi import blade_object, light_rig, map_images, measurement, properties  # noqa: E402
from togishi.core import native  # noqa: E402
from togishi.nodes import steel_group  # noqa: E402
from togishi.operators.add_katana import DIMENSIONS, preset_parameters  # noqa: E402


@pytest.fixture
def linked_blade(tmp_path) -> bpy.types.Object:
    """A blade linked from another file, active."""
    obj = add_katana()
    path = tmp_path / "library.blend"
    bpy.data.libraries.write(str(path), {obj})
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(path), link=True) as (_source, target):
        target.objects = ["Katana"]
    obj = bpy.data.objects["Katana"]
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def test_a_linked_blade_is_not_edited(linked_blade):
    with pytest.raises(RuntimeError, match="linked from another file"):
        bpy.ops.object.togishi_katana_edit(nagasa_mm=650.0)
    assert len(linked_blade.data.polygons)


def test_a_blade_with_shape_keys_is_not_edited():
    add_katana().shape_key_add(name="Basis")
    with pytest.raises(RuntimeError, match="shape keys"):
        bpy.ops.object.togishi_katana_edit(nagasa_mm=650.0)


def test_an_edit_keeps_the_slots_of_the_parts():
    obj = add_katana()
    obj.data.materials.append(bpy.data.materials.new("Nakago"))
    part, count = 7, len(obj.data.polygons)
    parts = np.empty(count, np.int32)
    obj.data.attributes["togishi_part"].data.foreach_get("value", parts)
    obj.data.polygons.foreach_set("material_index", (parts == part).astype(np.int32))
    assert bpy.ops.object.togishi_katana_edit(nagasa_mm=650.0, detail=0.05) == {"FINISHED"}
    parts = np.empty(len(obj.data.polygons), np.int32)
    assert len(parts) != count
    slots = np.empty_like(parts)
    obj.data.attributes["togishi_part"].data.foreach_get("value", parts)
    obj.data.polygons.foreach_get("material_index", slots)
    np.testing.assert_array_equal(slots, parts == part)


def test_an_edit_is_remembered_by_linked_duplicates():
    obj = add_katana()
    twin = bpy.data.objects.new("Twin", obj.data)
    blade_object.remember(twin, properties.katana_parameters(obj), DETAIL)
    bpy.context.collection.objects.link(twin)
    bpy.ops.object.togishi_katana_edit(nagasa_mm=650.0)
    assert properties.katana_parameters(twin) == properties.katana_parameters(obj)


def test_a_preset_chosen_in_the_dialog_brings_its_hidden_dimensions():
    obj = add_katana()
    wanted = preset_parameters("TANTO")
    # As the dialog has them: every field set, by the preset.
    shown = {
        key: wanted[key] for key in ("zukuri", "sori_type", "mune", *(r[0] for r in DIMENSIONS))
    }
    assert bpy.ops.object.togishi_katana_edit(preset="TANTO", **shown) == {"FINISHED"}
    assert properties.katana_parameters(obj) == pytest.approx(wanted)


def test_another_zukuri_brings_its_hidden_dimensions_and_keeps_the_shown():
    obj = add_katana(nagasa_mm=650.0)
    bpy.ops.object.togishi_katana_edit(zukuri="hira")
    values = properties.katana_parameters(obj)
    shown = {"sori_type", "mune", *(row[0] for row in DIMENSIONS)}
    defaults = native.core().katana_defaults("hira")
    assert values["nagasa_mm"] == 650.0
    hidden = set(defaults) - shown
    assert {key: values[key] for key in hidden} == {key: defaults[key] for key in hidden}


def test_another_zukuri_keeps_hidden_dimensions_where_its_own_make_no_blade():
    obj = add_katana()
    assert bpy.ops.object.togishi_katana_edit(zukuri="shobu") == {"FINISHED"}
    wanted = {**native.core().katana_defaults("shinogi"), "zukuri": "shobu"}
    assert properties.katana_parameters(obj) == pytest.approx(wanted)


def test_lights_for_a_mesh_beside_a_text_of_blade_steel():
    obj = add_katana()
    text = bpy.data.objects.new("Mei", bpy.data.curves.new("Mei", "FONT"))
    text.data.materials.append(obj.active_material)
    bpy.context.collection.objects.link(text)
    bpy.context.view_layer.objects.active = text
    assert blade_object.find_blade(bpy.context) == obj
    assert bpy.ops.object.togishi_light_preset() == {"FINISHED"}


@pytest.mark.parametrize(
    "operator",
    ["pattern_bake", "nodes_connect", "nodes_bake_for_scene", "load", "maps_import", "make_steel"],
)
def test_a_linked_material_is_not_changed(linked_blade, operator):
    bpy.context.collection.objects.link(bpy.data.objects.new("L", bpy.data.lights.new("L", "SUN")))
    with pytest.raises(RuntimeError, match="linked from another file"):
        getattr(bpy.ops.material, f"togishi_{operator}")()


def test_no_fit_goes_into_a_linked_material(linked_blade):
    bpy.context.scene.togishi_measurement.fits.add()
    with pytest.raises(RuntimeError, match="linked from another file"):
        bpy.ops.scene.togishi_measurement_apply()


def test_a_plain_linked_mesh_gets_no_material(linked_blade):
    with pytest.raises(RuntimeError, match="linked from another file"):
        bpy.ops.object.togishi_material_assign()


def test_the_active_slots_material_is_baked():
    obj = add_katana()
    first = obj.active_material
    second = blade_object.new_material("Second")
    obj.data.materials.append(second)
    obj.active_material_index = 1
    second.togishi.pattern.width_px, second.togishi.pattern.height_px = 128, 32
    assert bpy.ops.material.togishi_pattern_bake() == {"FINISHED"}
    assert (first.togishi.lobes_image, second.togishi.lobes_image.size[0]) == (None, 128)


def test_the_material_that_the_properties_editor_shows_comes_first(tmp_path):
    add_katana()
    pinned = blade_object.new_material("Pinned")
    pinned.togishi.title = "Pinned steel"
    with bpy.context.temp_override(material=pinned):
        bpy.ops.material.togishi_save(filepath=str(tmp_path / "steel.toml"))
    assert native.core().load_material(str(tmp_path / "steel.toml"))["name"] == "Pinned steel"


def _lamp(energy: float, csv_path: str = "") -> bpy.types.Object:
    obj = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    obj.data.energy = energy
    obj.data.togishi.kind = "csv" if csv_path else "A"
    obj.data.togishi.csv_path = csv_path
    bpy.context.collection.objects.link(obj)
    return obj


def test_the_scenes_light_is_one_that_shines():
    material = add_katana().active_material
    _lamp(0.0)
    _lamp(50.0).hide_render = True
    with pytest.raises(RuntimeError, match="no light that shines"):
        bpy.ops.material.togishi_nodes_bake_for_scene()
    _lamp(10.0)
    assert bpy.ops.material.togishi_nodes_bake_for_scene() == {"FINISHED"}
    assert material.togishi.node_spectrum == "A"


def test_an_unreadable_spectrum_is_a_sentence(tmp_path):
    material = add_katana().active_material
    before = material.togishi.node_spectrum
    (tmp_path / "lamp.csv").write_text("no numbers")
    _lamp(10.0, str(tmp_path / "lamp.csv"))
    with pytest.raises(RuntimeError, match=r"^Error: The node groups were left as they are.*lamp"):
        bpy.ops.material.togishi_nodes_bake_for_scene()
    assert material.togishi.node_spectrum == before


@pytest.mark.filterwarnings("ignore:.*blend relative")
def test_paths_beside_the_file(tmp_path):
    material = add_katana().active_material
    map_images.assign(
        material,
        {n: np.full((4, 4), 0.5, np.float32) for n in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w")},
    )
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "blade.blend"))
    bpy.ops.material.togishi_save(filepath="//steel.toml")
    bpy.ops.material.togishi_load(filepath="//steel.toml")
    bpy.ops.material.togishi_maps_export(filepath="//maps.exr")
    bpy.ops.material.togishi_maps_import(filepath="//maps.exr")
    assert {p.name for p in tmp_path.iterdir()} >= {"steel.toml", "maps.exr"}


def _tables(material: bpy.types.Material) -> list[bpy.types.Image]:
    trees = [steel_group.group_of(material, target) for target in ("CYCLES", "EEVEE")]
    return [tree.nodes["F(theta)"].image for tree in trees]


def test_a_renamed_materials_table_stays_its_own():
    gold = blade_object.new_material("Katana steel")
    gold.togishi.metal_choice = next(
        m["name"] for m in native.core().metals() if m["name"] != gold.togishi.metal
    )
    before = list(_tables(gold)[0].pixels)
    gold.name = "Gold"
    iron = blade_object.new_material("Katana steel")
    assert list(_tables(gold)[0].pixels) == before
    assert list(_tables(iron)[0].pixels) != before
    copy = gold.copy()
    copy.togishi.metal_choice = iron.togishi.metal
    assert list(_tables(gold)[0].pixels) == before
    assert len({*_tables(gold), *_tables(iron), *_tables(copy)}) == 3


def test_a_long_japanese_name_leaves_no_tables_behind():
    material = blade_object.new_material("備前国住長船七郎衛門尉行包作の刀")
    for weight in (2.0, 3.0, 4.0):
        material.togishi.ji.mu_t_deg = weight
        steel_group.connect(material)
    assert len(set(_tables(material))) == 1
    assert len(bpy.data.images) == 1


def test_a_new_blades_table_is_not_the_librarys(linked_blade):
    material = blade_object.new_material(linked_blade.active_material.name)
    assert all(image.library is None for image in _tables(material))


def test_a_material_made_local_gets_groups_of_its_own(linked_blade):
    linked_blade.make_local()
    linked_blade.data.make_local()
    material = linked_blade.active_material.make_local()
    material.togishi.ji.mu_t_deg = 3.0
    for target in ("CYCLES", "EEVEE"):
        assert steel_group.group_of(material, target).library is None
    assert all(image.library is None for image in _tables(material))


def _lights(scene: bpy.types.Scene) -> set[str]:
    return {obj.name for obj in scene.objects if obj.type == "LIGHT"}


def test_presets_replace_each_other_in_a_second_scene_too():
    first = bpy.context.scene
    obj = add_katana()
    light_rig.add(first, obj, "MUSEUM_SPOT")
    second = bpy.data.scenes.new("Second")
    before = _lights(first)
    for _ in range(2):
        light_rig.clear(second)
        made = light_rig.add(second, obj, "MUSEUM_SPOT")
        assert _lights(second) == {lamp.name for lamp in made}
    assert _lights(first) == before


def test_presets_leave_the_users_objects_alone():
    scene = bpy.context.scene
    obj = add_katana()
    light_rig.add(scene, obj, "MUSEUM_SPOT")
    collection = bpy.data.collections[light_rig.COLLECTION]
    for name, data in (
        ("Eye", bpy.data.cameras.new("Eye")),
        ("Own", bpy.data.lights.new("Own", "SUN")),
    ):
        collection.objects.link(bpy.data.objects.new(name, data))
    light_rig.clear(scene)
    assert {found.name for found in collection.objects} == {"Eye", "Own"}


def test_presets_of_a_linked_copy_leave_the_first_scenes_lights():
    first = bpy.context.scene
    obj = add_katana()
    light_rig.add(first, obj, "MUSEUM_SPOT")
    camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    bpy.data.collections[light_rig.COLLECTION].objects.link(camera)
    before = _lights(first)
    bpy.ops.scene.new(type="LINK_COPY")
    copy = bpy.context.scene
    assert copy != first
    light_rig.clear(copy)
    made = light_rig.add(copy, obj, "TUNGSTEN_CASE")
    assert _lights(first) == before
    assert _lights(copy) == {lamp.name for lamp in made}
    assert "Eye" in copy.objects


def test_the_lights_of_a_blade_whose_rotation_was_applied():
    obj = add_katana()
    bpy.context.view_layer.update()
    before = light_rig.frame_of(obj)
    obj.rotation_euler.z = np.pi / 2
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=False)
    bpy.context.view_layer.update()
    frame = light_rig.frame_of(obj)
    assert frame.half_length == pytest.approx(before.half_length, rel=1e-3)
    assert abs(frame.along.y) == pytest.approx(1.0)


def test_a_pass_that_is_switched_on_gets_its_socket():
    scene = bpy.context.scene
    scene.render.engine = "TOGISHI"
    tree = compositor(scene)
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene = scene

    def sockets() -> set[str]:
        return {socket.name for socket in node.outputs if socket.enabled}

    assert not {"Depth", "Togishi Part"} & sockets()
    scene.togishi.use_pass_depth = True
    scene.togishi.use_pass_part = True
    assert {"Depth", "Togishi Part"} <= sockets()


def compositor(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    if bpy.app.version >= (5, 0, 0):
        scene.compositing_node_group = bpy.data.node_groups.new("Comp", "CompositorNodeTree")
        return scene.compositing_node_group
    scene.use_nodes = True
    return scene.node_tree


def test_maps_of_another_size_replace_the_former_ones():
    material = blade_object.new_material()
    names = ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "ji.e1", "ji.e2", "ha.e1", "ha.e2")
    before = len(bpy.data.images)
    for size in (4, 8, 16):
        map_images.assign(material, {n: np.full((size, size), 0.5, np.float32) for n in names})
        assert len(bpy.data.images) == before + 2
    assert tuple(material.togishi.lobes_image.size) == (16, 16)


def test_a_fit_in_a_copied_scene_leaves_the_firsts_plots():
    class Fit:
        record = {"model": "smooth"}

    def pictures(value: int) -> dict[str, np.ndarray]:
        return {name: np.full((2, 3, 3), value, np.uint8) for name in ("scans", "mu_eff")}

    first = bpy.context.scene
    measurement.keep(first, ["a.csv"], [(Fit, pictures(255))])
    copy = first.copy()
    measurement.keep(copy, ["b.csv"], [(Fit, pictures(0))])
    assert first.togishi_measurement.fits[0].scans_image.pixels[0] == 1.0
    assert copy.togishi_measurement.fits[0].scans_image.pixels[0] == 0.0
    count = len(bpy.data.images)
    measurement.keep(copy, ["c.csv"], [(Fit, pictures(0))])
    assert len(bpy.data.images) == count
