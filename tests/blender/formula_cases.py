"""What each function of shaders/shared is fed, and how far float and GPU may be from double.

The tolerance of a case reads: |value - double| <= absolute + relative x condition, where the condition is |value| unless
the case states another. The same inputs, exact in float, go to all three, so what is measured is the
arithmetic. The GPU column allows for the polynomials that drivers use for exp, log, sin and atan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Rows = np.ndarray
MIN_COS = 1.0e-4  # TG_MIN_COS


@dataclass(frozen=True)
class Tolerance:
    absolute: float
    relative: float


@dataclass(frozen=True)
class Case:
    function: str
    inputs: Callable[[np.random.Generator, int], Rows]
    core_float: Tolerance
    gpu: Tolerance
    why: str
    condition: Callable[[Rows, Rows], Rows] | None = None
    """(inputs, double result) -> what `relative` is relative to, broadcast over the outputs."""
    comparable: Callable[[Rows, Rows], Rows] | None = None
    """Rows to compare; the others must only be finite."""


# --- inputs -------------------------------------------------------------------------------------


def log_uniform(rng: np.random.Generator, low: float, high: float, count: int) -> Rows:
    return np.exp(rng.uniform(np.log(low), np.log(high), count))


def columns(*arrays: Rows) -> Rows:
    return np.column_stack(arrays)


def unit(vectors: Rows) -> Rows:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def random_directions(rng: np.random.Generator, count: int) -> Rows:
    return unit(rng.normal(size=(count, 3)))


def cosines(rng: np.random.Generator, count: int) -> Rows:
    """Every third at grazing incidence, down to exactly 0; some exactly 1."""
    c = np.concatenate(
        [
            rng.uniform(0, 1, count - count // 3 - 4),
            log_uniform(rng, 1e-7, 1e-1, count // 3),
            [0.0, 1.0, 1e-30, 0.5],
        ]
    )
    return rng.permutation(c)


def frames(rng: np.random.Generator, count: int) -> tuple[Rows, Rows, Rows]:
    n = random_directions(rng, count)
    t = unit(np.cross(n, random_directions(rng, count)))
    return n, t, np.cross(n, t)


def towards(n: Rows, t: Rows, b: Rows, theta: Rows, azimuth: Rows) -> Rows:
    """Directions at angle theta from n."""
    return (
        n * np.cos(theta)[:, None]
        + t * (np.sin(theta) * np.cos(azimuth))[:, None]
        + b * (np.sin(theta) * np.sin(azimuth))[:, None]
    )


def half_widths(rng: np.random.Generator, count: int) -> tuple[Rows, Rows]:
    """mu_t >= mu_b in rad: 0.001 to 80 degrees, aspect to 100:1, a fifth isotropic."""
    low, high = np.radians(0.001), np.radians(80)
    mu_t = log_uniform(rng, low, high, count)
    aspect = np.where(rng.uniform(size=count) < 0.2, 1.0, log_uniform(rng, 1, 100, count))
    return mu_t, np.maximum(mu_t / aspect, low)


def stored_lobes(rng: np.random.Generator, count: int) -> Rows:
    mu_t, mu_b = half_widths(rng, count)
    rho = rng.uniform(0, np.pi, count)
    r = 0.5 * np.log(mu_t / mu_b)
    size = 0.5 * np.log(mu_t * mu_b) - np.log(np.pi / 180)
    return columns(size, r * np.cos(2 * rho), r * np.sin(2 * rho))


def forms_and_facets(rng: np.random.Generator, count: int) -> tuple[Rows, Rows]:
    """Lobes as quadratic forms, and facets from the middle of the lobe to far out of it, some exactly at 0."""
    mu_t, mu_b = half_widths(rng, count)
    rho = rng.uniform(0, np.pi, count)
    c, s = np.cos(rho), np.sin(rho)
    t, b = np.log(2) / mu_t**2, np.log(2) / mu_b**2
    form = columns(t * c**2 + b * s**2, (t - b) * c * s, t * s**2 + b * c**2, np.sqrt(t * b))
    reach = log_uniform(rng, 1e-3, 10, count)
    azimuth = rng.uniform(0, 2 * np.pi, count)
    along, across = mu_t * reach * np.cos(azimuth), mu_b * reach * np.sin(azimuth)
    facet = columns(along * c - across * s, along * s + across * c)
    facet[:5] = 0
    facet[5:10] = [np.pi, 0]
    return form, facet


def light_geometries(rng: np.random.Generator, facet: Rows) -> Rows:
    """lit, cos_i, cos_h, g_over_cos_r and the given facets."""
    count = len(facet)
    cos_i = np.maximum(cosines(rng, count), MIN_COS)
    return columns(
        (rng.uniform(size=count) < 0.9).astype(float),
        cos_i,
        cosines(rng, count),
        log_uniform(rng, 1e-4, 1e4, count),
        facet,
    )


def half_angles(rng: np.random.Generator, count: int) -> Rows:
    return half_angles_and_axes(rng, count)[:, :5]


def half_angles_and_axes(rng: np.random.Generator, count: int) -> Rows:
    """N x S, N.S, |S| for angles from 1e-6 to 90 degrees, then T and B."""
    n, t, b = frames(rng, count)
    phi = np.concatenate(
        [
            log_uniform(rng, 1e-6, np.pi / 2, count - count // 4 - 2),
            rng.uniform(0, np.pi / 2, count // 4),
            [0.0, np.pi / 2],
        ]
    )
    size = log_uniform(rng, 1e-3, 2, count)
    s = towards(n, t, b, phi, rng.uniform(0, 2 * np.pi, count)) * size[:, None]
    return columns(np.cross(n, s), np.sum(n * s, axis=1), size, t, b)


def tangent_frame_inputs(rng: np.random.Generator, count: int) -> Rows:
    """Any length of both vectors (a scene in km or in mm); T down to 1.5e-4 rad from N, where it still counts."""
    n, t, b = frames(rng, count)
    theta = np.concatenate(
        [
            rng.uniform(0.01, np.pi - 0.01, count - count // 4),
            log_uniform(rng, 1.5e-4, 1e-2, count // 4),
        ]
    )
    tangent = towards(n, t, b, theta, rng.uniform(0, 2 * np.pi, count))
    return columns(
        n * log_uniform(rng, 1e-6, 1e6, count)[:, None],
        tangent * log_uniform(rng, 1e-6, 1e6, count)[:, None],
    )


def light_geometry_inputs(rng: np.random.Generator, count: int) -> Rows:
    n, t, b = frames(rng, count)

    # Most rows from the upper hemisphere, a quarter of them grazing, an eighth below the horizon.
    def angle() -> Rows:
        grazing = np.pi / 2 - log_uniform(rng, 1e-5, 0.3, count)
        below = rng.uniform(np.pi / 2, np.pi, count)
        choice = rng.uniform(size=count)
        theta = np.where(choice < 0.25, grazing, rng.uniform(0, np.pi / 2, count))
        return np.where(choice > 0.875, below, theta)

    azimuth = rng.uniform(0, 2 * np.pi, count)
    theta_v, theta_l = angle(), angle()
    view = towards(n, t, b, theta_v, azimuth)
    light = towards(n, t, b, theta_l, rng.uniform(0, 2 * np.pi, count))
    third = count // 3
    # A third near the mirror direction, where the lobe of polished steel is.
    mirror = unit(2 * np.sum(n * view, axis=1, keepdims=True) * n - view)
    light[:third] = unit(
        mirror[:third] + rng.normal(size=(third, 3)) * log_uniform(rng, 1e-6, 0.1, third)[:, None]
    )
    light[third : third + 50] = view[third : third + 50]  # the light at the eye
    light[third + 50 : third + 100] = -view[third + 50 : third + 100]  # behind the blade: L = -V
    return columns(n, t, b, view, light)


# --- conditions ---------------------------------------------------------------------------------


def exponent_terms(form: Rows, facet: Rows) -> Rows:
    """The terms that the exponent of D is summed from; their cancellation is what a narrow lobe amplifies."""
    dx, dy = facet[:, 0], facet[:, 1]
    return form[:, 0] * dx**2 + 2 * np.abs(form[:, 1] * dx * dy) + form[:, 2] * dy**2


def lobe_condition(form: Rows, facet: Rows) -> Rows:
    dx, dy = facet[:, 0], facet[:, 1]
    exponent = np.maximum(form[:, 0] * dx**2 + 2 * form[:, 1] * dx * dy + form[:, 2] * dy**2, 0.0)
    return np.exp(-exponent) * (1 + exponent_terms(form, facet))


def light_geometry_parts(inputs: Rows) -> tuple[Rows, Rows, Rows]:
    """N.L, N.V and |L + V|."""
    n, view, light = inputs[:, 0:3], inputs[:, 9:12], inputs[:, 12:15]
    return (
        np.sum(n * light, axis=1),
        np.sum(n * view, axis=1),
        np.linalg.norm(light + view, axis=1),
    )


def light_geometry_condition(inputs: Rows, expected: Rows) -> Rows:
    cos_i, cos_v, length = light_geometry_parts(inputs)
    half = 1 / np.maximum(length, 1e-6)
    # N.H and V.H come from a sum that may nearly cancel; G/cos multiplies and divides all four cosines.
    n_dot_h = (cos_i + cos_v) * half
    v_dot_h = np.maximum(expected[:, 2], 1e-7)
    g = np.abs(expected[:, 3]) * (
        1 / np.maximum(cos_i, MIN_COS)
        + 1 / np.maximum(cos_v, MIN_COS)
        + (1 + half) / np.maximum(n_dot_h, MIN_COS)
        + (1 + half) / v_dot_h
    )
    one = np.ones_like(half)
    # The angle of H to N within rounding, and in proportion to itself.
    facet = half + np.hypot(expected[:, 4], expected[:, 5])
    # Not lit: exactly 0.
    return expected[:, :1] * columns(0 * one, one, half + one, g, facet, facet)


def light_geometry_comparable(inputs: Rows, expected: Rows) -> Rows:
    """Not the rows that rounding may put on either side of the horizon."""
    cos_i, cos_v, length = light_geometry_parts(inputs)
    clear = (np.abs(cos_i - MIN_COS) > 1e-6) & (np.abs(cos_v - MIN_COS) > 1e-6)
    return clear & ((length > 1e-5) | (expected[:, 0] == 0))


def lobe_form_condition(inputs: Rows, expected: Rows) -> Rows:
    """The larger axis of the form: at 100:1 the smaller one is the difference of two numbers 10^4 times it."""
    exponent = 5 + np.abs(inputs[:, 0])
    axes = (expected[:, 0] + expected[:, 2]) * exponent
    return columns(axes, axes, axes, expected[:, 3] * exponent)


def aspect_condition(expected: Rows) -> Rows:
    """mu_b^2 is a determinant over mu_t^2: its rounding grows as their ratio."""
    ratio = np.exp(4 * np.hypot(expected[:, 1], expected[:, 2]))
    return (1 + np.abs(expected[:, 0]) + np.minimum(ratio, 1e4))[:, None]


def axes_condition(inputs: Rows, expected: Rows) -> Rows:
    exponent = 8 + np.abs(inputs[:, 0])
    return columns(
        expected[:, 0] * exponent,
        expected[:, 1] * exponent,
        1 + 1 / np.maximum(np.hypot(inputs[:, 1], inputs[:, 2]), 1e-6),
    )


# --- the table ----------------------------------------------------------------------------------

CASES = [
    Case(
        "fresnel_conductor",
        lambda rng, n: columns(rng.uniform(0, 10, n), rng.uniform(0, 15, n), cosines(rng, n)),
        core_float=Tolerance(2.0e-6, 0.0),
        gpu=Tolerance(2.0e-6, 0.0),
        why="any n and k; absolute, since a dielectric's reflectance passes through 0",
    ),
    Case(
        "fresnel_conductor",
        lambda rng, n: columns(rng.uniform(1.5, 3.2, n), rng.uniform(1.8, 4.1, n), cosines(rng, n)),
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 6.0e-7),
        why="iron: the error that fresnel.glsl states",
    ),
    Case(
        "fresnel_conductor",
        lambda rng, n: columns(
            rng.uniform(0.03, 0.2, n), rng.uniform(1.9, 5.0, n), cosines(rng, n)
        ),
        core_float=Tolerance(0.0, 4.0e-6),
        gpu=Tolerance(0.0, 4.0e-6),
        why="silver: the error that fresnel.glsl states",
    ),
    Case(
        "fresnel_table_position",
        lambda rng, n: columns(cosines(rng, n), rng.choice([2, 8, 16, 32, 64, 128, 256], n)),
        core_float=Tolerance(0.0, 2.5e-7),
        gpu=Tolerance(0.0, 5.0e-7),
        why="one square root and one product",
    ),
    Case(
        "fresnel_table_cosine",
        lambda rng, n: columns(rng.uniform(0, 1, n) * 63, np.full(n, 64.0)),
        core_float=Tolerance(0.0, 4.0e-7),
        gpu=Tolerance(0.0, 6.0e-7),
        why="one quotient, squared",
    ),
    Case(
        "lobe_from_mu",
        lambda rng, n: columns(*half_widths(rng, n), rng.uniform(0, np.pi, n)),
        core_float=Tolerance(2.0e-6, 0.0),
        gpu=Tolerance(6.0e-6, 0.0),
        why="logarithms: 2e-6 is 2e-6 of a half width",
    ),
    Case(
        "sanitise_lobe",
        lambda rng, n: stored_lobes(rng, n) * rng.choice([1, 2, 1e3], n)[:, None],
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        why="in range: unchanged; else one product",
        condition=lambda x, y: np.maximum(np.abs(y), np.hypot(y[:, 1], y[:, 2])[:, None]),
    ),
    Case(
        "sanitise_mu_rad",
        lambda rng, n: log_uniform(rng, 1e-9, 1e3, n)[:, None],
        core_float=Tolerance(0.0, 2.0e-7),
        gpu=Tolerance(0.0, 2.0e-7),
        why="in range: unchanged; else the nearer end",
    ),
    Case(
        "lobe_axes",
        stored_lobes,
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 1.0e-5),
        condition=axes_condition,
        # An angle has no distance across 0 = 180 degrees, and none where the lobe is all but round.
        comparable=lambda x, y: (
            (np.hypot(x[:, 1], x[:, 2]) > 0.01) & (y[:, 2] > 1e-3) & (y[:, 2] < np.pi - 1e-3)
        ),
        why="exp, and atan (drivers: 1e-5 rad)",
    ),
    Case(
        "lobe_shape",
        lambda rng, n: stored_lobes(rng, n)[:, 1:],
        core_float=Tolerance(0.0, 1.5e-6),
        gpu=Tolerance(0.0, 3.0e-6),
        why="exp of up to 4.6; the series below r = 0.03 and the quotient above it agree",
    ),
    Case(
        "lobe_moments",
        lambda rng, n: columns(stored_lobes(rng, n), rng.uniform(1, 50, n), rng.uniform(2, 22, n)),
        core_float=Tolerance(0.0, 4.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=lambda x, y: (
            (np.exp(2 * x[:, :1]) * (5 + np.abs(x[:, :1])) * (x[:, 3:4] + 3 * x[:, 4:5]))
            * np.ones((1, 3))
        ),
        why="exp of ln mu times the shape: relative to the shape's terms",
    ),
    Case(
        "lobe_from_moments",
        lambda rng, n: moments(rng, n),
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=lambda x, y: aspect_condition(y),
        why="a determinant and two logarithms: grows as (mu_t/mu_b)^2",
    ),
    Case(
        "sanitise_share",
        lambda rng, n: rng.uniform(-1, 2, n)[:, None],
        core_float=Tolerance(0.0, 0.0),
        gpu=Tolerance(0.0, 0.0),
        why="unchanged, 0 or 1",
    ),
    Case(
        "lobe_form",
        stored_lobes,
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 6.0e-7),
        condition=lobe_form_condition,
        why="exp of ln mu: relative to the form's larger axis and to |ln mu|",
    ),
    Case(
        "lobe_form_isotropic",
        lambda rng, n: stored_lobes(rng, n)[:, :1],
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 6.0e-7),
        condition=lambda x, y: np.abs(y) * (5 + np.abs(x[:, :1])),
        why="exp of ln mu: relative to |ln mu|",
    ),
    Case(
        "atan_over_x",
        lambda rng, n: np.concatenate([rng.uniform(0, 1, n - 2), [0.0, 1.0]])[:, None],
        core_float=Tolerance(0.0, 2.0e-7),
        gpu=Tolerance(0.0, 2.0e-7),
        why="a polynomial of 2e-8 and its rounding",
    ),
    Case(
        "coarse_normal",
        lambda rng, n: random_directions(rng, n),
        core_float=Tolerance(1.3e-4, 0.0),
        gpu=Tolerance(1.3e-4, 0.0),
        why="a grid of 1/4096 in float, a finer one in double",
    ),
    Case(
        "coarse_sum",
        lambda rng, n: random_directions(rng, n) * rng.uniform(0, 2, (n, 1)),
        core_float=Tolerance(5.0e-4, 0.0),
        gpu=Tolerance(5.0e-4, 0.0),
        why="a grid of 1/1024 in float, a finer one in double",
    ),
    Case(
        "plain_cross",
        lambda rng, n: columns(random_directions(rng, n), random_directions(rng, n)),
        core_float=Tolerance(2.0e-7, 0.0),
        gpu=Tolerance(2.0e-7, 0.0),
        why="products of unit vectors",
    ),
    Case(
        "half_angle",
        lambda rng, n: light_geometry_inputs(rng, n)[:, [0, 1, 2, *range(9, 15)]],
        core_float=Tolerance(1.0e-10, 4.0e-7),
        gpu=Tolerance(1.0e-10, 4.0e-7),
        condition=lambda x, y: columns(
            *[np.linalg.norm(y[:, :3], axis=1)] * 3, y[:, 4] + 1e-6, y[:, 4]
        ),
        why="N x S to the last bits of its length and of 2^-11 of a float's; along and size to those of |S|",
    ),
    Case(
        "facet_stretch",
        lambda rng, n: half_angles(rng, n),
        core_float=Tolerance(0.0, 6.0e-7),
        gpu=Tolerance(0.0, 8.0e-7),
        why="quotients and a polynomial",
    ),
    Case(
        "facet_of",
        lambda rng, n: half_angles_and_axes(rng, n),
        core_float=Tolerance(0.0, 8.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=lambda x, y: np.hypot(y[:, :1], y[:, 1:]) * np.ones((1, 2)),
        why="relative to the angle, however small it is",
    ),
    Case(
        "facet_isotropic",
        lambda rng, n: half_angles(rng, n),
        core_float=Tolerance(0.0, 8.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        why="relative to the angle, however small it is",
    ),
    Case(
        "lobe_value",
        lambda rng, n: columns(*forms_and_facets(rng, n)),
        core_float=Tolerance(1.0e-30, 4.0e-7),
        gpu=Tolerance(1.0e-30, 1.0e-6),
        condition=lambda x, y: lobe_condition(x[:, :4], x[:, 4:6])[:, None],
        why="exp of a sum of three terms: relative to D times those terms",
    ),
    Case(
        "lobe_normalised_weight",
        lambda rng, n: forms_and_facets(rng, n)[0],
        core_float=Tolerance(0.0, 2.0e-7),
        gpu=Tolerance(0.0, 5.0e-7),
        why="one quotient",
    ),
    Case(
        "shadowing_over_cos_r",
        lambda rng, n: columns(
            np.maximum(cosines(rng, n), MIN_COS),
            np.maximum(cosines(rng, n), MIN_COS),
            np.maximum(cosines(rng, n), MIN_COS),
            cosines(rng, n),
        ),
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        why="products and quotients only",
    ),
    Case(
        "tangent_frame",
        tangent_frame_inputs,
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=lambda x, y: columns(
            *[np.ones(len(x))] * 3,
            *[1 / np.sin(angle_between(x[:, :3], x[:, 3:]))] * 6,
        ),
        why="T minus its share along N: relative to 1/sin of the angle between them",
    ),
    Case(
        "fold_normal",
        lambda rng, n: visible_normals(rng, n),
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 5.0e-7),
        condition=lambda x, y: (1 + np.abs(y)) / np.maximum(1 + x[:, 2:3], 1e-6),
        why="1/(1 + z) of a normal known to 1e-7",
    ),
    Case(
        "unfold_normal",
        lambda rng, n: visible_normals(rng, n)[:, :2] * log_uniform(rng, 0.1, 10, n)[:, None],
        core_float=Tolerance(4.0e-7, 0.0),
        gpu=Tolerance(4.0e-7, 0.0),
        why="quotients only",
    ),
    Case(
        "smooth_frame",
        lambda rng, n: visible_normals(rng, n),
        core_float=Tolerance(0.0, 4.0e-7),
        gpu=Tolerance(0.0, 6.0e-7),
        condition=lambda x, y: 1 / np.maximum(1 + x[:, 2:3], 1e-6) * np.ones((1, 9)),
        why="1/(1 + z) of a normal known to 1e-7",
    ),
    Case(
        "light_geometry_at",
        lambda rng, n: light_geometry_at_inputs(rng, n),
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=lambda x, y: y[:, :1] * light_geometry_condition(full_geometry(x), y),
        comparable=lambda x, y: light_geometry_comparable(full_geometry(x), y),
        why="dot products of directions known to 1e-7",
    ),
    Case(
        "light_geometry",
        light_geometry_inputs,
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=light_geometry_condition,
        comparable=light_geometry_comparable,
        why="dot products of directions known to 1e-7",
    ),
    *(
        Case(
            name,
            lambda rng, n: reflection_inputs(rng, n),
            core_float=Tolerance(1.0e-30, 6.0e-7),
            gpu=Tolerance(1.0e-30, 1.5e-6),
            condition=lambda x, y, with_g=name == "hamon_reflection": reflection_condition(
                x, with_g
            )[:, None],
            why="the lobe's tolerance times the weight",
        )
        for name in ("ji_reflection", "hamon_reflection")
    ),
    Case(
        "blend_reflection",
        lambda rng, n: columns(
            *(log_uniform(rng, 1e-6, 1e8, n) for _ in range(3)),
            np.clip(rng.uniform(-0.2, 1.2, n), 0, 1),
            np.clip(rng.uniform(-0.2, 1.2, n), 0, 1),
        ),
        core_float=Tolerance(0.0, 4.0e-7),
        gpu=Tolerance(0.0, 6.0e-7),
        condition=lambda x, y: np.abs(y),
        why="products of shares",
    ),
    Case(
        "light_point_intensity",
        lambda rng, n: log_uniform(rng, 1e-8, 1e8, n)[:, None],
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 5.0e-7),
        why="one quotient",
    ),
    Case(
        "light_distance_falloff",
        lambda rng, n: log_uniform(rng, 1e-20, 1e20, n)[:, None],
        core_float=Tolerance(0.0, 2.0e-7),
        gpu=Tolerance(0.0, 4.0e-7),
        why="one quotient: a scene in km or in mm, a lamp on the surface",
    ),
    Case(
        "light_spot_blend",
        lambda rng, n: columns(rng.uniform(-1, 1, n), rng.uniform(0, 1, n), rng.uniform(0, 1, n)),
        core_float=Tolerance(0.0, 5.0e-7),
        gpu=Tolerance(0.0, 1.0e-6),
        condition=lambda x, y: (1 + np.ones(len(x)) / np.maximum((1 - x[:, 1]) * x[:, 2], 1e-4))[
            :, None
        ],
        why="a difference of cosines over the width of the soft edge",
    ),
    Case(
        "plain_diffuse",
        lambda rng, n: light_geometries(rng, np.zeros((n, 2))),
        core_float=Tolerance(0.0, 3.0e-7),
        gpu=Tolerance(0.0, 5.0e-7),
        why="one product, one quotient",
    ),
    Case(
        "plain_gloss",
        lambda rng, n: columns(reflection_inputs(rng, n)[:, :10], rng.uniform(1.2, 3, n)),
        core_float=Tolerance(1.0e-30, 1.6e-6),
        gpu=Tolerance(1.0e-30, 3.0e-6),
        condition=lambda x, y: reflection_condition(columns(x[:, :10], -np.ones(len(x))), True)[
            :, None
        ],
        why="the lobe's tolerance plus that of any n and k",
    ),
]


def visible_normals(rng: np.random.Generator, count: int) -> Rows:
    """Towards the viewer in view space, and a little beyond the horizon."""
    normals = random_directions(rng, count)
    normals[:, 2] = np.abs(normals[:, 2]) - 0.3 * (rng.uniform(size=count) < 0.1)
    return unit(normals)


def light_geometry_at_inputs(rng: np.random.Generator, count: int) -> Rows:
    """N, V, L, half angle, facet."""
    vectors = light_geometry_inputs(rng, count).astype(np.float32).astype(float)
    normal, view, light = vectors[:, 0:3], vectors[:, 9:12], vectors[:, 12:15]
    total = light + view
    half = columns(
        np.cross(normal, total), np.sum(normal * total, axis=1), np.linalg.norm(total, axis=1)
    )
    return columns(normal, view, light, half, rng.normal(size=(count, 2)))


def full_geometry(inputs: Rows) -> Rows:
    """As light_geometry has them: N, T, B, V, L (T and B do not matter here)."""
    unused = np.zeros((len(inputs), 6))
    return columns(inputs[:, 0:3], unused, inputs[:, 3:9])


def moments(rng: np.random.Generator, count: int) -> Rows:
    mu_t, mu_b = (np.degrees(mu) for mu in half_widths(rng, count))
    rho = rng.uniform(0, np.pi, count)
    c, s = np.cos(rho), np.sin(rho)
    return columns(
        mu_t**2 * c**2 + mu_b**2 * s**2,
        (mu_t**2 - mu_b**2) * c * s,
        mu_t**2 * s**2 + mu_b**2 * c**2,
    )


def angle_between(a: Rows, b: Rows) -> Rows:
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))


def reflection_inputs(rng: np.random.Generator, count: int) -> Rows:
    """Form, geometry and weight: half normalised (negative), half measured."""
    form, facet = forms_and_facets(rng, count)
    weight = np.where(rng.uniform(size=count) < 0.5, -1.0, log_uniform(rng, 1e-3, 1e6, count))
    return columns(form, light_geometries(rng, facet), weight)


def reflection_condition(inputs: Rows, g_always: bool) -> Rows:
    form, lit, g, weight = inputs[:, :4], inputs[:, 4], inputs[:, 7], inputs[:, 10]
    normalised = weight < 0
    amount = np.where(normalised, form[:, 3] / (4 * np.pi), weight)
    amount = amount * np.where(normalised | g_always, g, 1.0)
    return lit * amount * lobe_condition(form, inputs[:, 8:10])


# --- degenerate inputs: the stated result ---------------------------------------------------------

NAN, INF = float("nan"), float("inf")
LIT_FROM_ABOVE = (0, 0, 1, 1, 0, 0, 0, 1, 0)  # N, T, B

DEGENERATE = [
    # (what, function, inputs, {output index: value}); every output must be finite
    ("n = k = 0 reflects all", "fresnel_conductor", (0, 0, 0.5), {0: 1}),
    ("n = k = 0 at 90 degrees", "fresnel_conductor", (0, 0, 0), {0: 1}),
    ("no boundary reflects nothing", "fresnel_conductor", (1, 0, 0.5), {0: 0}),
    ("no boundary at 90 degrees", "fresnel_conductor", (1, 0, 0), {0: 1}),
    ("iron at exactly 90 degrees", "fresnel_conductor", (2.9, 3.1, 0), {0: 1}),
    ("cosine above 1 is 1", "fresnel_conductor", (1.5, 0, 1.0001), {0: 0.04}),
    ("cosine below 0 is 0", "fresnel_conductor", (2.9, 3.1, -0.5), {0: 1}),
    ("n = 0: total reflection", "fresnel_conductor", (0, 3, 0.3), {0: 1}),
    ("huge n, k", "fresnel_conductor", (1e4, 1e4, 0.5), {}),
    ("table: below the horizon", "fresnel_table_position", (-1, 64), {0: 0}),
    ("table: above 1", "fresnel_table_position", (2, 64), {0: 63}),
    ("smallest isotropic lobe", "lobe_from_mu", (1.7453292e-5, 1.7453292e-5, 0), {1: 0, 2: 0}),
    ("mu 0 and negative", "lobe_from_mu", (0, -1, 0), {0: np.log(0.001), 1: 0, 2: 0}),
    ("mu NaN is 1 degree", "lobe_from_mu", (NAN, NAN, 0), {0: 0, 1: 0, 2: 0}),
    ("rho NaN is isotropic", "lobe_from_mu", (0.1, 0.01, NAN), {1: 0, 2: 0}),
    ("widest lobe", "lobe_from_mu", (1e9, INF, 0), {0: np.log(80), 1: 0, 2: 0}),
    ("map: ln mu NaN", "sanitise_lobe", (NAN, 0.1, 0.2), {0: 0, 1: 0.1, 2: 0.2}),
    ("map: ln mu -inf", "sanitise_lobe", (-INF, 0, 0), {0: np.log(0.001)}),
    ("map: ln mu +inf", "sanitise_lobe", (INF, 0, 0), {0: np.log(80)}),
    ("map: shape NaN", "sanitise_lobe", (1, NAN, 0.2), {0: 1, 1: 0, 2: 0}),
    ("map: shape infinite", "sanitise_lobe", (1, 0.1, -INF), {0: 1, 1: 0, 2: 0}),
    (
        "map: shape too long",
        "sanitise_lobe",
        (1, 30, 40),
        {1: 0.6 * np.log(10), 2: 0.8 * np.log(10)},
    ),
    ("isotropic lobe has rho 0", "lobe_axes", (0, 0, 0), {0: np.pi / 180, 1: np.pi / 180, 2: 0}),
    ("no moments: 1 degree", "lobe_from_moments", (0, 0, 0), {0: 0, 1: 0, 2: 0}),
    ("moments NaN: 1 degree", "lobe_from_moments", (NAN, 0, 1), {0: 0, 1: 0, 2: 0}),
    ("moments of a line", "lobe_from_moments", (1, 0, 0), {1: np.log(10), 2: 0}),
    ("share NaN", "sanitise_share", (NAN,), {0: 0}),
    ("share infinite", "sanitise_share", (INF,), {0: 1}),
    ("H on N", "facet_of", (0, 0, 0, 2, 2, 1, 0, 0, 0, 1, 0), {0: 0, 1: 0}),
    ("H opposite to N", "facet_of", (0, 0, 0, -2, 2, 1, 0, 0, 0, 1, 0), {}),
    ("no H", "facet_of", (0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0), {0: 0, 1: 0}),
    ("far out of the lobe", "lobe_value", (2e13, 0, 2e9, 2e11, 3.14, 3.14), {0: 0}),
    ("view along the surface", "shadowing_over_cos_r", (0.7, 1e-4, 1e-4, 0), {}),
    ("H across V", "shadowing_over_cos_r", (0, 1e-4, 1, 0), {0: 0}),
    ("T parallel to N", "tangent_frame", (0, 0, 1, 0, 0, 1), {2: 1, 5: 0}),
    ("T opposite to N", "tangent_frame", (0.6, 0.8, 0, -1.2, -1.6, 0), {0: 0.6, 1: 0.8}),
    ("T zero", "tangent_frame", (1, 0, 0, 0, 0, 0), {0: 1, 3: 0}),
    ("T NaN", "tangent_frame", (0, 1, 0, NAN, 0, 0), {1: 1, 4: 0}),
    ("T infinite", "tangent_frame", (0, 1, 0, INF, 0, 0), {1: 1, 4: 0}),
    ("T infinite both ways", "tangent_frame", (0, 1, 0, INF, -INF, 0), {1: 1, 4: 0}),
    ("N zero: no cosine", "tangent_frame", (0, 0, 0, 1, 0, 0), {0: 0, 1: 0, 2: 0, 3: 1}),
    ("N NaN: no cosine", "tangent_frame", (NAN, 0, 0, 1, 0, 0), {0: 0, 1: 0, 2: 0, 3: 1}),
    ("N infinite: no cosine", "tangent_frame", (0, INF, 0, 1, 0, 0), {0: 0, 1: 0, 2: 0, 3: 1}),
    ("N and T zero", "tangent_frame", (0, 0, 0, 0, 0, 0), {0: 0, 1: 0, 2: 0}),
    ("L = -V", "light_geometry", (*LIT_FROM_ABOVE, 0, 0.6, 0.8, 0, -0.6, -0.8), {0: 0, 3: 0}),
    ("L = -V along the surface", "light_geometry", (*LIT_FROM_ABOVE, 1, 0, 0, -1, 0, 0), {0: 0}),
    ("light at exactly 90 degrees", "light_geometry", (*LIT_FROM_ABOVE, 0, 0, 1, 1, 0, 0), {0: 0}),
    ("view at exactly 90 degrees", "light_geometry", (*LIT_FROM_ABOVE, 1, 0, 0, 0, 0, 1), {0: 0}),
    ("both at 90 degrees", "light_geometry", (*LIT_FROM_ABOVE, 1, 0, 0, 1, 0, 0), {0: 0}),
    ("light behind", "light_geometry", (*LIT_FROM_ABOVE, 0, 0, 1, 0.6, 0, -0.8), {0: 0}),
    ("view from behind", "light_geometry", (*LIT_FROM_ABOVE, 0.6, 0, -0.8, 0, 0, 1), {0: 0}),
    ("NaN in V", "light_geometry", (*LIT_FROM_ABOVE, NAN, 0, 1, 0, 0, 1), {i: 0 for i in range(6)}),
    ("NaN in L", "light_geometry", (*LIT_FROM_ABOVE, 0, 0, 1, 0, NAN, 1), {i: 0 for i in range(6)}),
    (
        "L infinite",
        "light_geometry",
        (*LIT_FROM_ABOVE, 0, 0, 1, 0, 0, INF),
        {i: 0 for i in range(6)},
    ),
    ("L zero", "light_geometry", (*LIT_FROM_ABOVE, 0, 0, 1, 0, 0, 0), {i: 0 for i in range(6)}),
    (
        "N zero",
        "light_geometry",
        (0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1),
        {i: 0 for i in range(6)},
    ),
    (
        "all along N",
        "light_geometry",
        (*LIT_FROM_ABOVE, 0, 0, 1, 0, 0, 1),
        {0: 1, 1: 1, 2: 1, 3: 1, 4: 0, 5: 0},
    ),
    (
        "not lit reflects nothing",
        "ji_reflection",
        (2e9, 0, 2e9, 2e9, 0, 0, 0, 1e4, 0, 0, -1),
        {0: 0},
    ),
    ("not lit, measured", "ji_reflection", (1, 0, 1, 1, 0, 0, 0, 1e4, 0, 0, 5), {0: 0}),
    ("chi = 0", "ji_reflection", (1, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0), {0: 0}),
    ("beta as measured", "hamon_reflection", (1, 0, 1, 1, 1, 1, 1, 2, 0, 0, 5), {0: 10}),
    ("beta of 0.001 degrees", "hamon_reflection", (2e9, 0, 2e9, 2e9, 1, 1, 1, 1, 0, 0, -1), {}),
    ("all ji", "blend_reflection", (2, 3, 4, 0, 0), {0: 2, 1: 0}),
    ("all hadori", "blend_reflection", (2, 3, 4, 0, 1), {0: 0, 1: 3}),
    ("shares NaN: all ji", "blend_reflection", (2, 3, 4, NAN, NAN), {0: 2, 1: 0}),
    ("shares outside", "blend_reflection", (2, 3, 4, -1, 7), {0: 0, 1: 3}),
    ("all ha", "blend_reflection", (2, 3, 4, 1, 1), {0: 0, 1: 4}),
    (
        "glass in air does not shine at n = 1",
        "plain_gloss",
        (1, 0, 1, 1, 1, 1, 1, 1, 0, 0, 1),
        {0: 0},
    ),
    ("a lamp without power", "light_point_intensity", (0,), {0: 0}),
    ("a lamp of 1e8 W", "light_point_intensity", (1e8,), {0: 7957747.15}),
    ("a lamp at the point", "light_distance_falloff", (0,), {0: 1e12}),
    ("spot: middle", "light_spot_blend", (1, 0.9, 0.5), {0: 1}),
    ("spot: outside", "light_spot_blend", (0.8, 0.9, 0.5), {0: 0}),
    ("spot: hard edge", "light_spot_blend", (0.9, 0.9, 0), {0: 0}),
    ("spot: no cone, no blend", "light_spot_blend", (1, 1, 0), {}),
    ("nakago in the dark", "plain_diffuse", (0, 1, 1, 1, 0, 0), {0: 0}),
]
