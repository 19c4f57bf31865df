"""Property maps on numpy arrays: levels, atlases, what a map must not hold."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import togishi_core as core


def maps(height=16, width=32, seed=1):
    rng = np.random.default_rng(seed)
    return {
        "ji.ln_mu_deg": rng.normal(0, 0.3, (height, width)).astype(np.float32),
        "ha.ln_mu_deg": np.full((1, 1), 1.6, np.float32),
        "w": rng.uniform(0, 1, (height, width)).astype(np.float32),
    }


def test_lobe_round_trip_and_broadcast():
    mu_t, mu_b = np.array([[1.0], [5.0]]), np.array([0.9, 0.5, 0.1])
    lobes = core.encode_lobe(mu_t, mu_b, np.array(30.0))
    assert lobes.shape == (2, 3, 3)
    back = core.decode_lobe(lobes)
    np.testing.assert_allclose(back[..., 0], np.broadcast_to(mu_t, (2, 3)), rtol=1e-6)
    np.testing.assert_allclose(back[..., 1], np.broadcast_to(mu_b, (2, 3)), rtol=1e-6)
    np.testing.assert_allclose(back[..., 2], 30.0, atol=1e-4)


def test_levels_keep_the_hamons_share_and_the_second_moments():
    source = maps()
    levels = core.map_mip_levels(source)
    assert [level["w"].shape for level in levels] == [
        (16, 32), (8, 16), (4, 8), (2, 4), (1, 2), (1, 1),
    ]  # fmt: skip
    share = 1.0 - source["w"].astype(float)
    width2 = np.exp(2.0 * source["ji.ln_mu_deg"].astype(float))
    np.testing.assert_allclose(levels[-1]["w"][0, 0], source["w"].mean(), rtol=1e-5)
    np.testing.assert_allclose(
        np.exp(2.0 * levels[-1]["ji.ln_mu_deg"][0, 0]),
        (share * width2).sum() / share.sum(),
        rtol=1e-5,
    )
    assert all(level["ha.ln_mu_deg"].shape == (1, 1) for level in levels)


def test_nan_is_replaced_and_counted():
    source = maps()
    source["w"][3, 4] = np.nan
    with pytest.warns(RuntimeWarning, match="1 values were NaN"):
        levels = core.map_mip_levels(source)
    assert all(np.isfinite(plane).all() for level in levels for plane in level.values())


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (16, 64), (33, 5)])
def test_atlas_holds_every_level_with_its_frame(size):
    rng = np.random.default_rng(2)
    lobes = rng.uniform(0, 1, (*size, 4)).astype(np.float32)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        atlas, shape, rectangles = core.pack_mip_atlas(lobes, None)
    assert atlas.dtype == np.float16
    assert shape is None
    levels = core.map_mip_levels(
        {
            "ji.ln_mu_deg": lobes[..., 0],
            "ha.ln_mu_deg": lobes[..., 1],
            "w": lobes[..., 2],
            "h": lobes[..., 3],
        }
    )
    assert len(rectangles) == len(levels)
    for (x, y, width, height), level in zip(rectangles, levels, strict=True):
        plane = level["w"].astype(np.float16)
        np.testing.assert_array_equal(atlas[y : y + height, x : x + width, 2], plane)
        framed = atlas[y - 1 : y + height + 1, x - 1 : x + width + 1, 2]
        np.testing.assert_array_equal(framed, np.pad(plane, 1, mode="edge"))


def test_wrong_maps_are_named():
    with pytest.raises(core.InputError, match="roughness"):
        core.map_mip_levels({**maps(), "roughness": np.zeros((16, 32), np.float32)})
    with pytest.raises(core.InputError, match=r"h is 3 x 3"):
        core.map_mip_levels({**maps(), "h": np.zeros((3, 3), np.float32)})
    source = maps()
    del source["w"]
    with pytest.raises(core.InputError, match="w is missing"):
        core.map_mip_levels(source)
    with pytest.raises(core.InputError, match="lobes"):
        core.pack_mip_atlas(np.zeros((4, 4, 3), np.float32), None)
    with pytest.raises(core.InputError, match="shape"):
        core.pack_mip_atlas(np.zeros((4, 4, 4), np.float32), np.zeros((4, 5, 4), np.float32))
