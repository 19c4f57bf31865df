"""A stored lobe (ln mu_deg, e1, e2) in nodes: shaders/shared/lobe.glsl states the quantities."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .graph import Graph, Socket

# Half width at half maximum against alpha. Beckmann: D falls to a half at tan(mu) = alpha sqrt(ln 2).
# GGX: (1 + tan^2/alpha^2)^-2 falls to a half at tan(mu) = alpha sqrt(sqrt(2) - 1).
BECKMANN_TAN_MU = math.sqrt(math.log(2.0))
GGX_TAN_MU = math.sqrt(math.sqrt(2.0) - 1.0)


@dataclass(frozen=True)
class LobeSockets:
    """A decoded lobe. rho and the half widths in rad."""

    stretch: Socket  # ln sqrt(mu_t/mu_b)
    mu_t: Socket
    mu_b: Socket
    rho: Socket


def decode(graph: Graph, lobe: Socket) -> LobeSockets:
    ln_mu, e1, e2 = graph.separate(lobe)
    stretch = graph.math("SQRT", graph.add(graph.mul(e1, e1), graph.mul(e2, e2)))
    radian = math.radians(1.0)
    return LobeSockets(
        stretch=stretch,
        mu_t=graph.mul(graph.math("EXPONENT", graph.add(ln_mu, stretch)), radian),
        mu_b=graph.mul(graph.math("EXPONENT", graph.sub(ln_mu, stretch)), radian),
        rho=graph.mul(graph.math("ARCTAN2", e2, e1), 0.5),
    )


def beckmann_anisotropic(
    graph: Graph,
    lobe: LobeSockets,
    colour: Socket,
    normal: Socket | None,
    tangent: Socket,
    label: str,
) -> Socket:
    """One exact Beckmann lobe (Cycles). normal: None for the surface's own. Its Glossy node with a negative anisotropy a is wide along the
    tangent: alpha_x = r^2/(1 + a), alpha_y = r^2 (1 + a). Unlike the Principled node it has no limit of
    10:1 (it ends at 10^4:1)."""
    node = graph.node("ShaderNodeBsdfAnisotropic", label, distribution="BECKMANN")
    tan_t, tan_b = graph.math("TANGENT", lobe.mu_t), graph.math("TANGENT", lobe.mu_b)
    # roughness = sqrt(sqrt(alpha_x alpha_y)), 1 + a = sqrt(alpha_y/alpha_x)
    product = graph.mul(graph.mul(tan_t, tan_b), 1.0 / BECKMANN_TAN_MU**2)
    graph.connect(graph.math("POWER", product, 0.25), node.inputs["Roughness"])
    narrowness = graph.math("SQRT", graph.math("DIVIDE", tan_b, tan_t))
    graph.connect(graph.sub(narrowness, 1.0), node.inputs["Anisotropy"])
    graph.connect(graph.mul(lobe.rho, 0.5 / math.pi), node.inputs["Rotation"])
    if normal is not None:
        graph.connect(normal, node.inputs["Normal"])
    graph.connect(tangent, node.inputs["Tangent"])
    graph.connect(colour, node.inputs["Color"])
    return node.outputs[0]


@dataclass(frozen=True)
class Bending:
    """Lobes that stand for one long lobe: their number and their spacing over tau.

    Offsets j step, weights exp(-(j h)^2/2), step = h tau, tau = 1.04 sqrt(aspect^2 - 1) in units of the
    narrow standard deviation; each lobe .36 step wide, at least 1. Against the long Gaussian, in % of its
    peak: 9 at 3.5:1 with 5 lobes, 25 at 10:1 with 9."""

    count: int
    h: float

    @property
    def weights(self) -> list[float]:
        half = self.count // 2
        raw = [math.exp(-0.5 * (j * self.h) ** 2) for j in range(-half, half + 1)]
        return [value / sum(raw) for value in raw]


ROUND = Bending(1, 1.0)
MAX_ASPECT = 10.0


def bending_for(aspect: float) -> Bending:
    """The cheapest set that holds up to this aspect (mu_t/mu_b); beyond 10:1 the set for 10:1."""
    if aspect <= 1.02:
        return ROUND
    if aspect <= 1.6:
        return Bending(3, 0.926)
    return Bending(5, 0.777) if aspect <= 3.5 else Bending(9, 0.333)


def ggx_bent(
    graph: Graph,
    lobe: LobeSockets,
    colour: Socket,
    normal: Socket,
    tangent: Socket,
    bending: Bending,
    label: str,
) -> Socket:
    """Round GGX lobes whose normals lean to both sides along the wide axis (EEVEE)."""
    tan_b = graph.math("TANGENT", lobe.mu_b)
    if bending.count == 1:
        node = graph.node("ShaderNodeBsdfAnisotropic", label, distribution="GGX")
        mean = graph.math("SQRT", graph.mul(tan_b, graph.math("TANGENT", lobe.mu_t)))
        graph.connect(
            graph.math("SQRT", graph.mul(mean, 1.0 / GGX_TAN_MU)), node.inputs["Roughness"]
        )
        graph.connect(colour, node.inputs["Color"])
        return node.outputs[0]

    # aspect^2 = exp(4 stretch); beyond 10:1 the narrow axis widens instead of the set falling apart.
    aspect2 = graph.math("EXPONENT", graph.mul(lobe.stretch, 4.0))
    tau = graph.mul(graph.math("SQRT", graph.math("MAXIMUM", graph.sub(aspect2, 1.0), 0.0)), 1.04)
    step = graph.mul(tau, bending.h)
    width = graph.math("MAXIMUM", graph.mul(step, 0.36), 1.0)
    alpha = graph.mul(graph.mul(tan_b, width), 1.0 / GGX_TAN_MU)
    roughness = graph.math("SQRT", graph.math("MINIMUM", alpha, 1.0))
    lean = graph.mul(graph.mul(lobe.mu_b, step), 1.0 / math.sqrt(2.0 * math.log(2.0)))

    flat = graph.vector(
        "SUBTRACT",
        tangent,
        graph.vector("SCALE", normal, scale=graph.vector("DOT_PRODUCT", normal, tangent)),
    )
    along = graph.vector("NORMALIZE", flat)
    across = graph.vector("CROSS_PRODUCT", normal, along)
    axis = graph.vector(
        "ADD",
        graph.vector("SCALE", along, scale=graph.math("COSINE", lobe.rho)),
        graph.vector("SCALE", across, scale=graph.math("SINE", lobe.rho)),
    )
    total: Socket | None = None
    half = bending.count // 2
    for j, weight in zip(range(-half, half + 1), bending.weights, strict=True):
        node = graph.node("ShaderNodeBsdfAnisotropic", f"{label} {j:+d}", distribution="GGX")
        slope = graph.math("TANGENT", graph.mul(lean, float(j)))
        bent = graph.vector(
            "NORMALIZE", graph.vector("ADD", normal, graph.vector("SCALE", axis, scale=slope))
        )
        graph.connect(bent, node.inputs["Normal"])
        graph.connect(roughness, node.inputs["Roughness"])
        graph.connect(graph.vector("SCALE", colour, scale=weight), node.inputs["Color"])
        if total is None:
            total = node.outputs[0]
        else:
            joined = graph.node("ShaderNodeAddShader")
            graph.connect(total, joined.inputs[0])
            graph.connect(node.outputs[0], joined.inputs[1])
            total = joined.outputs[0]
    assert total is not None
    return total
