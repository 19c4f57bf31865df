"""Every function of shaders/shared on the GPU, in C++ float and in C++ double, held to its own tolerance.

The tolerances and what they mean are the table CASES of formula_cases.py; `pytest -s` prints the errors found.
"""

from __future__ import annotations

import re

import formula_cases
import numpy as np
import pytest
import togishi_core
from formula_cases import CASES, DEGENERATE, Case, Tolerance
from gpu_context import ensure_gpu_context
from gpu_formulas import GpuFormulas, SharedText, scalars
from togishi.core import shader_source

ROWS = 40_000

pytestmark = pytest.mark.gpu


def case_name(case: Case) -> str:
    return f"{case.function} ({case.why.split(':')[0].split(';')[0]})"


@pytest.fixture(scope="module")
def shared() -> SharedText:
    return SharedText(shader_source.resolve("shared/model.glsl"))


@pytest.fixture(scope="module")
def gpu_formulas(shared) -> GpuFormulas:
    ensure_gpu_context()
    return GpuFormulas(shared)


def test_every_shared_function_is_held_to_a_tolerance(shared):
    in_files = {
        name
        for path in (shader_source.shader_root() / "shared").glob("*.glsl")
        for name in re.findall(r"\bTG_FN\s+\w+\s+(\w+)\s*\(", path.read_text())
    }
    assert in_files == set(shared.functions), "model.glsl includes every file"
    assert {case.function for case in CASES} == in_files
    assert set(togishi_core.formula_names()) == in_files


@pytest.mark.parametrize("case", CASES, ids=case_name)
def test_float_and_gpu_agree_with_double(case, shared, gpu_formulas):
    rng = np.random.default_rng([7, CASES.index(case)])
    inputs = case.inputs(rng, ROWS).astype(np.float32)
    assert inputs.shape == (
        ROWS,
        len(scalars(shared.input_leaves(shared.functions[case.function]))),
    )
    assert np.isfinite(inputs).all()
    exact = inputs.astype(np.float64)
    expected = togishi_core.formulas(case.function, "f64", exact)
    outputs = {
        "core float": (togishi_core.formulas(case.function, "f32", exact), case.core_float),
        "GPU": (gpu_formulas(case.function, inputs).astype(np.float64), case.gpu),
    }
    condition = np.broadcast_to(
        np.abs(expected) if case.condition is None else case.condition(exact, expected),
        expected.shape,
    )
    rows = np.ones(ROWS, bool) if case.comparable is None else case.comparable(exact, expected)
    assert rows.sum() > ROWS // 4, "most rows are compared"
    assert np.isfinite(expected).all()
    for side, (got, tolerance) in outputs.items():
        assert np.isfinite(got).all(), f"{side}: NaN or infinity leaves {case.function}"
        excess = used(got, expected, condition, tolerance)[rows]
        worst = np.unravel_index(np.argmax(excess), excess.shape)
        print(f"{case.function:24s} {side:10s} uses {excess[worst]:6.1%} of its tolerance")
        assert excess[worst] <= 1, (
            f"{side}, {scalars(shared.output_leaves(shared.functions[case.function]))[worst[1]]}: "
            f"{got[rows][worst]!r} instead of {expected[rows][worst]!r} "
            f"({excess[worst]:.3g} times its tolerance) at {exact[rows][worst[0]]!r}"
        )


def used(
    got: np.ndarray, expected: np.ndarray, condition: np.ndarray, allowed: Tolerance
) -> np.ndarray:
    """Error as a share of the tolerance; two equal values use none of it, whatever it is."""
    error = np.abs(got - expected)
    limit = allowed.absolute + allowed.relative * condition
    return np.where(error == 0, 0.0, error / np.maximum(limit, np.finfo(float).tiny))


@pytest.mark.parametrize(
    "what, function, inputs, stated", DEGENERATE, ids=[d[0] for d in DEGENERATE]
)
def test_degenerate_input_has_its_stated_result(what, function, inputs, stated, gpu_formulas):
    row = np.array([inputs], np.float32)
    results = {
        "double": togishi_core.formulas(function, "f64", row.astype(np.float64))[0],
        "core float": togishi_core.formulas(function, "f32", row.astype(np.float64))[0],
        "GPU": gpu_formulas(function, row)[0],
    }
    for side, got in results.items():
        assert np.isfinite(got).all(), f"{side}: {got}"
        for index, value in stated.items():
            assert got[index] == pytest.approx(value, rel=2e-6, abs=1e-7), f"{side}, output {index}"


@pytest.mark.parametrize(
    "function", ["sanitise_lobe", "lobe_form", "lobe_form_isotropic", "lobe_axes", "lobe_from_mu"]
)
def test_whatever_a_map_holds_the_lobe_is_finite_and_the_same_everywhere(
    function, shared, gpu_formulas
):
    """Any float at all: NaN, infinities, denormals, 1e38."""
    width = len(scalars(shared.input_leaves(shared.functions[function])))
    rng = np.random.default_rng(13)
    bits = rng.integers(0, 2**32, (ROWS, width), dtype=np.uint64).astype(np.uint32)
    wild = np.where(np.isnan(bits.view(np.float32)), np.float32(np.nan), bits.view(np.float32))
    usual = rng.normal(size=(ROWS, width)).astype(np.float32)
    rows = np.where(rng.uniform(size=(ROWS, width)) < 0.5, wild, usual)
    if function == "lobe_from_mu":
        rows[:, 2] = np.where(
            np.abs(rows[:, 2]) < 10, rows[:, 2], np.nan
        )  # an azimuth of 1e30 rad is none
    expected = togishi_core.formulas(function, "f64", rows.astype(np.float64))
    assert np.isfinite(expected).all()
    size = np.abs(expected).max(axis=1, keepdims=True)
    for side, got in {
        "core float": togishi_core.formulas(function, "f32", rows.astype(np.float64)),
        "GPU": gpu_formulas(function, rows),
    }.items():
        assert np.isfinite(got).all(), f"{side}: {rows[~np.isfinite(got).all(axis=1)][0]}"
        error = np.abs(got - expected)
        if function == "lobe_axes":  # rho wraps, and is lost where the lobe is all but round
            error, compared = error[:, :2], expected[:, :2]
        else:
            compared = size
        assert (error <= 2e-5 * compared + 1e-30).all(), (
            f"{side}: {rows[(error > 2e-5 * compared).any(axis=1)][0]}"
        )


def test_any_tangent_gives_a_right_handed_orthonormal_frame(gpu_formulas):
    """Whatever T is: a direction, zero, NaN, infinite, of a length from 1e-11 to 1e11 - near to N or not."""
    rng = np.random.default_rng(11)
    lengths = np.exp(rng.uniform(-25, 25, (2, ROWS, 1)))
    normals = formula_cases.random_directions(rng, ROWS)
    apart = np.exp(rng.uniform(np.log(1e-9), 1, (ROWS, 1)))
    tangents = normals + apart * formula_cases.random_directions(rng, ROWS)
    odd = rng.choice([0.0, np.nan, np.inf, -np.inf], (ROWS, 3))
    strike = rng.uniform(size=(ROWS, 3)) < 0.15
    rows = np.hstack([normals * lengths[0], np.where(strike, odd, tangents * lengths[1])])
    rows = rows.astype(np.float32)
    for side, got in {
        "core float": togishi_core.formulas("tangent_frame", "f32", rows.astype(np.float64)),
        "GPU": gpu_formulas("tangent_frame", rows),
    }.items():
        frame = got.reshape(-1, 3, 3)
        products = frame @ frame.transpose(0, 2, 1)
        cosines = np.abs(products - products * np.eye(3)).max(axis=(1, 2))
        assert cosines.max() <= 2e-6, f"{side}: {rows[cosines.argmax()]}, {got[cosines.argmax()]}"
        lengths2 = np.diagonal(products, axis1=1, axis2=2)
        assert np.abs(lengths2 - 1).max() <= 1e-5, f"{side}: not of unit length"
        assert np.linalg.det(frame).min() > 0.99, f"{side}: not right-handed"
