"""What a moved handle says of a scan's pose."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from togishi.core import scan_pose


def rotation(axis, degrees: float) -> np.ndarray:
    a = np.radians(degrees)
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(a) * cross + (1 - np.cos(a)) * cross @ cross


HALF_TURNS = {
    (False, False): np.eye(3),
    (True, False): rotation((0, 0, 1), 180),
    (False, True): rotation((1, 0, 0), 180),
    (True, True): rotation((0, 1, 0), 180),
}


@given(
    st.sampled_from(sorted(HALF_TURNS)),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    st.floats(-60, 60),
    st.floats(1e-3, 1e3),
)
def test_the_nearest_half_turn_counts(swaps, axis, degrees, scale):
    assert scan_pose.turned(scale * HALF_TURNS[swaps] @ rotation(axis, degrees)) == swaps


def report(unit: float = 10.0) -> dict:
    return {
        "unit": {"mm_per_unit": unit},
        "pose": {
            "rotation": rotation((1, 2, 3), 77).tolist(),
            "origin_mm": [1e5, -2e5, 3e4],
        },
    }


@given(st.tuples(*[st.floats(-900, 900)] * 3), st.sampled_from([1.0, 10.0, 25.4, 1000.0]))
def test_a_place_in_the_scan_is_where_the_pose_has_it(place_mm, unit):
    pose = report()["pose"]
    found = scan_pose.place_in_scan(pose, unit, place_mm)
    back = np.array(pose["rotation"]) @ (unit * np.array(found) - pose["origin_mm"])
    assert back == pytest.approx(place_mm, abs=1e-6)


def test_options_follow_the_handle():
    options = {"replicates": 2, "swap_ends": True}
    found = scan_pose.corrected(options, report(), HALF_TURNS[True, False], (5.0, 0.0, 0.0))
    assert not found["swap_ends"] and not found["swap_edge_and_back"]
    assert found["replicates"] == 2 and len(found["machi"]) == 3
    # Turned only: the machi stays as found, or as it was given before.
    found = scan_pose.corrected(options, report(), HALF_TURNS[False, True], (0.0, 0.0, 0.001))
    assert found["swap_ends"] and found["swap_edge_and_back"] and "machi" not in found
    with pytest.raises(ValueError, match="neither moved nor turned"):
        scan_pose.corrected(options, report(), rotation((1, 1, 0), 30), (0.0, 0.0, 0.001))
    assert options == {"replicates": 2, "swap_ends": True}
