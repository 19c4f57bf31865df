"""Settings: they say what the core understands, they survive a file, and menus keep names."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from ui_fixtures import add_katana, addon  # noqa: F401

pytestmark = pytest.mark.usefixtures("addon")

from togishi import blade_object, map_images, properties  # noqa: E402
from togishi.core import native, spectrum_spec  # noqa: E402
from togishi.engine.scene_sync import SceneSync  # noqa: E402
from togishi.operators.add_katana import DIMENSIONS  # noqa: E402


def test_pattern_settings_are_those_of_the_core():
    core = native.core()
    material = bpy.data.materials.new("m")
    from togishi import pattern_baking

    assert pattern_baking.pattern_dict(material) == pytest.approx(core.steel_defaults())
    group = material.togishi.pattern.bl_rna.properties
    for name, names in core.steel_choices().items():
        assert [item.identifier for item in group[name].enum_items] == list(names)
    for name, (low, high) in core.steel_ranges().items():
        assert (group[name].hard_min, group[name].hard_max) == pytest.approx((low, high)), name


def test_katana_dimensions_default_to_the_cores():
    defaults = native.core().katana_defaults("shinogi")
    assert {row[0]: row[3] for row in DIMENSIONS} == {
        row[0]: defaults[row[0]] for row in DIMENSIONS
    }


def test_a_new_blade_material_is_the_default_material():
    core = native.core()
    material = blade_object.new_material()
    assert properties.is_blade(material)
    assert properties.material_dict(material) == core.default_material()
    assert core.material_to_toml(properties.material_dict(material)) == core.material_to_toml(
        core.default_material()
    )


def test_a_lobe_entered_the_other_way_round_is_turned():
    material = bpy.data.materials.new("m")
    lobe = material.togishi.ji
    lobe.mu_t_deg, lobe.mu_b_deg, lobe.rho_deg = 0.5, 3.0, 120.0
    assert properties.material_dict(material)["parts"]["ji"] == {
        "mu_t_deg": 3.0,
        "mu_b_deg": 0.5,
        "rho_deg": 30.0,
    }


def test_measured_weights_appear_only_when_asked_for():
    material = blade_object.new_material()
    material.togishi.ji.weight = 12.5
    assert "chi" not in properties.material_dict(material)["parts"]["ji"]
    material.togishi.weights = "measured"
    parts = properties.material_dict(material)["parts"]
    assert parts["ji"]["chi"] == 12.5
    assert parts["ha"]["beta"] == 1.0
    assert "chi" not in parts["nakago"]
    native.core().material_to_toml(properties.material_dict(material))


@pytest.mark.parametrize(
    ("kind", "field", "value", "expected"),
    [
        ("automatic", None, None, "D65"),
        ("LPS", None, None, "LPS"),
        ("blackbody", "blackbody_k", 3200.0, "blackbody:3200"),
        ("daylight", "daylight_k", 5003.0, "daylight:5003"),
        ("line", "line_nm", 589.3, "line:589.3"),
    ],
)
def test_spectrum_strings(kind, field, value, expected):
    for owner, read in (
        (bpy.data.lights.new("l", "SPOT"), properties.light_spectrum),
        (bpy.data.worlds.new("w"), properties.world_spectrum),
    ):
        owner.togishi.choice = kind
        if field:
            setattr(owner.togishi, field, value)
        assert read(owner) == expected
        native.core().light_rgb(read(owner))


def test_automatic_follows_the_lights_own_temperature():
    light = bpy.data.lights.new("l", "POINT")
    if not hasattr(light, "use_temperature"):
        pytest.skip("this Blender's lights have no temperature")
    light.use_temperature, light.temperature = True, 3100.0
    assert properties.light_spectrum(light) == "blackbody:3100"
    light.togishi.choice = "D50"
    assert properties.light_spectrum(light) == "D50"


def test_the_white_that_a_visitor_is_adapted_to():
    scene = bpy.context.scene
    settings = scene.togishi
    settings.white.kind = "A"
    assert properties.adapted_white(scene) == ""
    settings.adapted_to = "room"
    assert properties.adapted_white(scene) == "", "no adaptation is chosen"
    settings.adaptation = "cat16"
    assert properties.adapted_white(scene) == "A"
    read = SceneSync().update(bpy.context.evaluated_depsgraph_get())
    assert (read.colour.adaptation, read.colour.white) == ("cat16", "A")


def test_csv_path_is_made_absolute(tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    light = bpy.data.lights.new("l", "POINT")
    light.togishi.kind = spectrum_spec.CSV
    assert properties.light_spectrum(light) == "D65"
    light.togishi.csv_path = "//lamp.csv"
    assert properties.light_spectrum(light) == f"csv:{tmp_path / 'lamp.csv'}"


def test_a_name_from_another_version_is_kept():
    light = bpy.data.lights.new("l", "POINT")
    light.togishi.kind = "LED-FUTURE"
    assert light.togishi.choice == "LED-FUTURE"
    light.togishi.choice = "A"
    assert light.togishi.kind == "A"


def test_everything_survives_save_and_reopen(tmp_path):
    obj = add_katana(preset="WAKIZASHI")
    name = obj.name
    material = obj.active_material
    material.togishi.metal_choice = "copper_johnson_christy"
    material.togishi.kissaki.rho_deg = 77.0
    material.togishi.pattern.hamon = "choji"
    rng = np.random.default_rng(3)
    maps = {
        c: rng.normal(size=(8, 32)).astype(np.float32) * 3.3
        for c in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h", "ji.e1", "ji.e2", "ha.e1", "ha.e2")
    }
    map_images.assign(material, maps)
    light = bpy.data.lights.new("lamp", "SPOT")
    light.use_fake_user = True
    light.togishi.choice = "line"
    light.togishi.line_nm = 546.1
    bpy.context.scene.togishi.samples = 33
    before = properties.material_dict(material)
    parameters = properties.katana_parameters(obj)
    path = str(tmp_path / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects[name]
    material = obj.active_material
    assert properties.material_dict(material) == before
    assert properties.katana_parameters(obj) == parameters
    assert material.togishi.pattern.hamon == "choji"
    assert properties.light_spectrum(bpy.data.lights["lamp"]) == "line:546.1"
    assert bpy.context.scene.togishi.samples == 33
    again = map_images.read(material)
    for channel, values in maps.items():
        np.testing.assert_array_equal(again[channel], values, err_msg=channel)
