"""Blade materials: presets, round trip, and every wrong field named with file and line."""

from __future__ import annotations

import copy

import numpy as np
import pytest
import togishi_core as core


def test_presets_read_and_come_back():
    names = core.materials()
    assert names[0] == "polished_katana"
    assert len(names) >= 4
    for name in names:
        material = core.load_material(name)
        assert core.material_to_toml(material)
        assert material["source"]
        assert material["licence"]
    assert core.default_material() == core.load_material(names[0])


def test_round_trip_through_a_file(tmp_path):
    material = core.default_material()
    material["name"] = 'with "quotes", 刃文 and\nlines'
    material["weights"] = "measured"
    for part in ("ji", "shinogi_ji", "mune", "kissaki"):
        material["parts"][part]["chi"] = 12.345678901234567
    for part in ("ha", "hadori"):
        material["parts"][part]["beta"] = 3
    path = tmp_path / "m.toml"
    path.write_text(core.material_to_toml(material), encoding="utf-8")
    assert core.load_material(str(path)) == material


def test_parts_are_ordered_as_the_polish_is():
    parts = core.default_material()["parts"]
    size = {k: np.sqrt(p["mu_t_deg"] * p["mu_b_deg"]) for k, p in parts.items()}
    assert size["shinogi_ji"] < size["ji"] < size["hadori"] < size["ha"] < size["nakago"]


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("format",), 2),
        (("name",), ""),
        (("name",), 7),
        (("metal",), "cheese"),
        (("weights",), "heavy"),
        (("colour",), "red"),
        (("parts", "tip"), {}),
        (("parts", "ji", "mu_t_deg"), 81),
        (("parts", "ji", "mu_t_deg"), float("nan")),
        (("parts", "ji", "mu_t_deg"), "wide"),
        (("parts", "ji", "mu_t_deg"), True),
        (("parts", "ji", "mu_b_deg"), 0.0009),
        (("parts", "ji", "mu_b_deg"), 2.0),
        (("parts", "ji", "rho_deg"), -1),
        (("parts", "ji", "chi"), 1.0),
        (("parts", "ha", "gloss"), 1.0),
        (("parts", "nakago", "albedo_rgb"), [0.1, 0.2]),
        (("parts", "nakago", "albedo_rgb"), [0.1, 0.2, 1.1]),
        (("parts", "nakago", "ior"), 0.5),
    ],
)
def test_wrong_fields_are_named(keys, value):
    material = copy.deepcopy(core.default_material())
    table = material
    for key in keys[:-1]:
        table = table[key]
    table[keys[-1]] = value
    with pytest.raises(core.InputError) as error:
        core.material_to_toml(material)
    assert ".".join(keys) in str(error.value)
    assert "allowed" in str(error.value)


def test_errors_name_file_and_line(tmp_path):
    path = tmp_path / "bad.toml"
    lines = core.material_to_toml(core.default_material()).splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("mu_t_deg"))
    lines[at] = "mu_t_deg = 99"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(core.InputError, match=rf"bad\.toml:{at + 1}: parts\.ji\.mu_t_deg is 99"):
        core.load_material(str(path))
    path.write_text("this is [no toml", encoding="utf-8")
    with pytest.raises(core.InputError, match=r"bad\.toml:1"):
        core.load_material(str(path))
    with pytest.raises(core.InputError, match=r"none\.toml"):
        core.load_material(str(tmp_path / "none.toml"))


def test_missing_fields_are_named():
    material = core.default_material()
    del material["parts"]["mune"]
    with pytest.raises(core.InputError, match=r"parts\.mune is missing"):
        core.material_to_toml(material)
