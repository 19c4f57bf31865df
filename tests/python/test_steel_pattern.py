"""The steel pattern through the module: shapes, parameters, refusals, progress."""

import json
import math

import numpy as np
import pytest
import togishi_core as core

SHORT = {
    "nagasa_mm": 220,
    "sori_mm": 4,
    "kissaki_mm": 28,
    "nakago_mm": 95,
    "mekugi_ana_from_machi_mm": 45,
}


def pattern(chosen=None, width=96, height=32, **keywords):
    return core.steel_pattern(
        SHORT, core.default_material(), chosen or {}, width, height, **keywords
    )


def test_maps_have_the_channels_shapes_and_ranges():
    maps = pattern()
    assert list(maps) == core.MAP_CHANNELS
    for name, values in maps.items():
        assert values.dtype == np.float32
        assert values.shape in ((32, 96), (1, 1)), name
        assert np.isfinite(values).all(), name
    assert maps["w"].shape == (32, 96)
    assert maps["w"].min() >= 0 and 0.6 < maps["w"].max() <= 1
    assert maps["h"].min() >= 0 and maps["h"].max() <= 1
    assert set(np.unique(maps["part"])) <= set(range(len(core.PART_NAMES)))


def test_same_seed_same_bits_other_seed_other_blade():
    first, again, other = pattern({"seed": 4}), pattern({"seed": 4}), pattern({"seed": 5})
    for name in first:
        assert np.array_equal(first[name], again[name]), name
    assert not np.array_equal(first["w"], other["w"])


def test_defaults_are_accepted_and_lie_in_their_ranges():
    defaults = core.steel_defaults()
    ranges, choices = core.steel_ranges(), core.steel_choices()
    assert set(defaults) == set(ranges) | set(choices) | {"seed"}
    for name, (low, high) in ranges.items():
        assert low <= defaults[name] <= high, name
    for name, names in choices.items():
        assert defaults[name] in names
    given, omitted = pattern(defaults), pattern()
    for name in given:
        assert np.array_equal(given[name], omitted[name]), name


@pytest.mark.parametrize("hamon", core.steel_choices()["hamon"])
def test_every_style_hardens_an_edge_of_the_height_asked_for(hamon):
    def hardened(height_mm):
        maps = pattern({"hamon": hamon, "hamon_height_mm": height_mm}, 256, 64)
        # Beside the outline (part 0) the edge's values go on.
        return maps["w"][maps["part"] != 0].sum()

    # Area of the ha grows with its height, hardly with its waves.
    assert 1.4 < hardened(10) / hardened(5) < 2.2


@pytest.mark.parametrize(
    ("chosen", "named"),
    [
        ({"hamon": "sudareba"}, "suguha"),
        ({"nie": 1.5}, "nie"),
        ({"nie": math.nan}, "nie"),
        ({"nie": "much"}, "nie"),
        ({"nie": True}, "nie"),
        ({"nioi": 0.5}, "nioiguchi_mm"),
        ({"seed": -1}, "seed"),
        ({"seed": 0.5}, "seed"),
        ({"hamon_height_mm": 0}, "hamon_height_mm"),
    ],
)
def test_refusals_name_field_and_what_is_allowed(chosen, named):
    with pytest.raises(core.InputError, match=named):
        pattern(chosen)


@pytest.mark.parametrize("size", [(0, 8), (8, 0), (-3, 8), (8, 65537)])
def test_sizes_out_of_range_are_refused(size):
    with pytest.raises(core.InputError, match="texels"):
        pattern({}, *size)


def test_progress_rises_to_one_and_cancels():
    told = []
    pattern(progress=told.append)
    assert told == sorted(told) and told[-1] == 1.0
    with pytest.raises(InterruptedError):
        pattern(progress=lambda done: done < 0.5)
    with pytest.raises(ZeroDivisionError):
        pattern(progress=lambda done: 1 / 0)


def test_a_pattern_over_a_chart_is_that_over_the_blade_it_belongs_to():
    frame = core.katana(SHORT, 0.02).frame
    kept = json.loads(json.dumps(frame))
    over = core.steel_pattern(kept, core.default_material(), {}, 96, 32)
    direct = pattern()
    for name in direct:
        # The kept curves are rounded to 1e-6 mm.
        np.testing.assert_allclose(over[name], direct[name], atol=1e-3, err_msg=name)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"edge_mm": [1.0]}, "edge_mm"),
        ({"skew": [0.0, 0.0]}, "skew"),
        ({"lift_mm": "none"}, "lift_mm"),
        ({"nagasa_mm": -1.0}, "nagasa_mm"),
        ({"nagasa_mm": math.nan}, "nagasa_mm"),
        ({"yokote_s_mm": None}, "yokote_s_mm"),
    ],
)
def test_a_chart_that_no_blade_has_is_refused(change, named):
    kept = core.katana(SHORT, 0.02).frame
    kept["frame"] |= change
    with pytest.raises(core.InputError, match=named):
        core.steel_pattern(kept, core.default_material(), {}, 96, 32)


@pytest.mark.parametrize("frame", [None, 3, [], {}])
def test_a_chart_without_curves_is_refused(frame):
    with pytest.raises(core.InputError, match=r"frame|nakago_mm"):
        core.steel_pattern({"frame": frame}, core.default_material(), {}, 96, 32)
