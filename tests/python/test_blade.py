"""togishi_core.katana as Python sees it."""

import numpy as np
import pytest
import togishi_core as tc


def triangles(katana):
    start = katana.face_start
    sides = np.diff(start)
    first = start[:-1]
    quads = first[sides == 4]
    corners = np.concatenate(
        [
            np.stack([first, first + 1, first + 2], 1),
            np.stack([quads, quads + 2, quads + 3], 1),
        ]
    )
    face = np.concatenate([np.arange(len(first)), np.nonzero(sides == 4)[0]])
    return corners, face


@pytest.mark.parametrize("zukuri", ["shinogi", "hira", "shobu"])
def test_arrays_fit_together(zukuri):
    parameters = tc.katana_defaults(zukuri)
    assert parameters["zukuri"] == zukuri
    katana = tc.katana(parameters, 0.1)
    corners = len(katana.corner_vertex)
    vertices = len(katana.positions_mm)
    assert katana.positions_mm.shape == (vertices, 3)
    assert katana.positions_mm.dtype == np.float64
    assert katana.corner_normal.shape == katana.corner_tangent.shape == (corners, 3)
    assert katana.corner_uv.shape == (corners, 2)
    assert katana.s_mm.shape == katana.t_mm.shape == (vertices,)
    assert katana.face_start[0] == 0
    assert katana.face_start[-1] == corners
    assert len(katana.face_part) == len(katana.face_start) - 1
    assert set(np.diff(katana.face_start)) <= {3, 4}
    assert katana.corner_vertex.min() == 0
    assert katana.corner_vertex.max() == vertices - 1
    assert not katana.positions_mm.flags.writeable
    assert katana.positions_mm[:, 0].max() == pytest.approx(parameters["nagasa_mm"], abs=1e-6)


def test_arrays_outlive_the_katana():
    positions = tc.katana(tc.katana_defaults(), 0.01).positions_mm
    assert np.isfinite(positions).all()


def test_normals_agree_with_the_faces():
    katana = tc.katana(tc.katana_defaults(), 0.5)
    corners, face = triangles(katana)
    p = katana.positions_mm[katana.corner_vertex[corners]]
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.linalg.norm(n, axis=1)
    assert (area > 0).all()
    cosine = np.einsum("ij,ikj->ik", n / area[:, None], katana.corner_normal[corners])
    polished = katana.face_part[face] != tc.PART_NAMES.index("nakago")
    assert cosine[polished].min() > 0.999
    assert cosine.min() > 0.5


def test_chart_is_isometric_within_two_percent():
    katana = tc.katana(tc.katana_defaults(), 0.5)
    corners, face = triangles(katana)
    p = katana.positions_mm[katana.corner_vertex[corners]]
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    x1 = np.linalg.norm(e1, axis=1)
    along = e1 / x1[:, None]
    x2 = np.einsum("ij,ij->i", e2, along)
    y2 = np.linalg.norm(e2 - x2[:, None] * along, axis=1)
    uv = katana.corner_uv[corners] * np.array(katana.chart_mm)
    u1, u2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    column = u1 / x1[:, None]
    jacobian = np.stack([column, (u2 - column * x2[:, None]) / y2[:, None]], axis=2)
    singular = np.linalg.svd(jacobian, compute_uv=False)
    # Slivers at the tip are smaller than what a single-precision UV resolves.
    judged = (katana.face_part[face] != tc.PART_NAMES.index("nakago")) & (np.minimum(x1, y2) > 0.02)
    assert judged.mean() > 0.7
    assert np.abs(singular[judged] - 1).max() < 0.02


def test_silhouette_of_a_sword():
    measures = tc.katana(tc.katana_defaults(), 0.1).measures
    assert measures["sakihaba_mm"] / measures["motohaba_mm"] == pytest.approx(2 / 3, abs=0.05)


def test_every_part_is_there():
    katana = tc.katana(tc.katana_defaults(), 0.1)
    names = {tc.PART_NAMES[i] for i in np.unique(katana.face_part)}
    assert names == {"ji", "shinogi_ji", "ha", "mune", "kissaki", "boshi", "nakago"}


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("nagasa_mm", 0, "nagasa_mm"),
        ("nagasa_mm", float("nan"), "nan"),
        ("nagasa_mm", None, "None"),
        ("nagasa_mm", True, "True"),
        ("nagasa_mm", "736", "a number"),
        ("zukuri", "moroha", "shobu"),
        ("zukuri", 3, "zukuri"),
        ("length", 700, "nagasa_mm"),
        (3, 700, "a string"),
        ("kissaki_mm", 390, "part of the blade"),
    ],
)
def test_refusals(key, value, said):
    parameters = tc.katana_defaults() | {key: value}
    with pytest.raises(tc.InputError, match=said):
        tc.katana(parameters, 0.01)


def test_parameters_must_be_a_mapping():
    with pytest.raises((TypeError, ValueError)):
        tc.katana(3)


def test_presets_build():
    presets = tc.katana_presets()
    assert {"katana", "wakizashi", "o_kissaki", "tanto"} <= set(presets)
    for preset in presets.values():
        assert preset["title"] and preset["source"] and preset["licence"]
        measures = tc.katana(preset["parameters"], 0.1).measures
        assert measures["nagasa_mm"] == pytest.approx(preset["parameters"]["nagasa_mm"], abs=0.05)
