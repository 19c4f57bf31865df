"""The node groups "Togishi Steel": a blade material in Cycles and in EEVEE, from the same tables and maps.

What they keep of the model: the lobes, the maps, the parts, and the exact Fresnel colour under one light
spectrum. What they cannot: another spectrum per lamp (bake_cost says what that costs), and the angle of the
Fresnel term, which here is the viewing angle. For lobes of a few degrees that is the same angle.
"""

from __future__ import annotations

import json
import math
from typing import Any

import bpy
import numpy as np

from .. import blender_versions, map_images, properties
from ..core import native
from ..core.blade_lobes import LOBE_OF_PART, part_aspects
from .graph import Graph, Socket, set_constant
from .lobe_nodes import (
    LobeSockets,
    beckmann_anisotropic,
    bending_for,
    decode,
    ggx_bent,
)

GROUP_NAME = "Togishi Steel"
TABLE_SIZE = 64
UV_MAP = "togishi_uv"
KEY = "togishi_structure"

CYCLES, EEVEE = "CYCLES", "EEVEE"


def group_name(material: bpy.types.Material, target: str) -> str:
    return f"{GROUP_NAME} {target.title()}: {material.name}"


# --- the parts of the graph ----------------------------------------------------------------------


class _Builder:
    """One group for one material and one renderer."""

    def __init__(
        self, tree: bpy.types.ShaderNodeTree, material: bpy.types.Material, target: str
    ) -> None:
        self.graph = Graph(tree)
        self.material = material
        self.settings = material.togishi
        self.target = target
        lobes, shape = properties.blade_images(material)
        self.lobes_image, self.shape_image = lobes, shape
        self.normal_image = self.settings.normal_image
        self.aspects = part_aspects(
            properties.material_dict(material),
            None if shape is None else map_images.largest_stretch(shape),
        )

    def build(self, table: bpy.types.Image) -> None:
        graph = self.graph
        part = graph.node("ShaderNodeAttribute", "part", attribute_name="togishi_part").outputs[
            "Fac"
        ]
        tangent = self._tangent()
        mapped = self._mapped_normal()
        normal = mapped or graph.node("ShaderNodeNewGeometry", "normal").outputs["Normal"]
        facing = graph.node("ShaderNodeLayerWeight", "facing")
        facing.inputs["Blend"].default_value = 0.5
        if mapped is not None:
            graph.connect(mapped, facing.inputs["Normal"])
        cosine = graph.math("SUBTRACT", 1.0, facing.outputs["Facing"], label="cos(theta)")
        colour = self._fresnel(table, cosine)
        ji, ha, w, h = self._maps(part)
        hadori = graph.constant3("lobe.hadori")

        def lobe(name: str, encoded: Socket, smooth: bool) -> Socket:
            sockets = decode(graph, encoded)
            tint = self._weighted(colour, name, sockets, cosine, smooth)
            if self.target == CYCLES:
                return beckmann_anisotropic(graph, sockets, tint, mapped, tangent, name)
            bending = bending_for(self.aspects[name])
            return ggx_bent(graph, sockets, tint, normal, tangent, bending, name)

        smooth = lobe("ji", ji, True)
        polished = graph.mix_shader(h, smooth, lobe("hadori", hadori, False), "hadori")
        steel = graph.mix_shader(w, polished, lobe("ha", ha, False), "hamon")
        is_nakago = graph.math("COMPARE", part, float(_part_id("nakago")), 0.5, label="nakago")
        result = graph.mix_shader(is_nakago, steel, self._nakago(mapped), "nakago")
        output = graph.node("NodeGroupOutput")
        graph.connect(result, output.inputs[0])

    def _mapped_normal(self) -> Socket | None:
        """The normal that the material's normal map bends; None without one."""
        if self.normal_image is None:
            return None
        graph = self.graph
        uv = graph.node("ShaderNodeUVMap", "normal uv", uv_map=UV_MAP).outputs[0]
        image = graph.node(
            "ShaderNodeTexImage", "normal map", image=self.normal_image, extension="EXTEND"
        )
        graph.connect(uv, image.inputs[0])
        node = graph.node("ShaderNodeNormalMap", "bent normal", space="TANGENT", uv_map=UV_MAP)
        graph.connect(image.outputs["Color"], node.inputs["Color"])
        return node.outputs["Normal"]

    def _tangent(self) -> Socket:
        graph = self.graph
        attribute = graph.node("ShaderNodeAttribute", "tangent", attribute_name="togishi_tangent")
        turned = graph.node(
            "ShaderNodeVectorTransform",
            vector_type="VECTOR",
            convert_from="OBJECT",
            convert_to="WORLD",
        )
        graph.connect(attribute.outputs["Vector"], turned.inputs[0])
        return turned.outputs[0]

    def _fresnel(self, table: bpy.types.Image, cosine: Socket) -> Socket:
        """RGB(theta) from the table, whose texel i holds cos = (i/(size - 1))^2."""
        graph = self.graph
        position = graph.mul(graph.math("SQRT", cosine), (TABLE_SIZE - 1.0) / TABLE_SIZE)
        u = graph.add(position, 0.5 / TABLE_SIZE)
        node = graph.node(
            "ShaderNodeTexImage",
            TABLE_NODE,
            image=table,
            interpolation="Linear",
            extension="EXTEND",
        )
        graph.connect(graph.combine(u, 0.5, 0.0), node.inputs[0])
        return node.outputs["Color"]

    def _maps(self, part: Socket) -> tuple[Socket, Socket, Socket, Socket]:
        """Encoded ji and ha lobe, w and h, from the images or, without them, from the part."""
        graph = self.graph
        if self.lobes_image is None:
            chosen: Socket | None = None
            by_lobe: dict[str, list[int]] = {}
            for index, name in enumerate(LOBE_OF_PART):
                by_lobe.setdefault(name, []).append(index)
            for name, parts in by_lobe.items():
                share: Socket | None = None
                for index in parts:
                    hit = graph.math("COMPARE", part, float(index), 0.5)
                    share = hit if share is None else graph.add(share, hit)
                assert share is not None
                scaled = graph.vector("SCALE", graph.constant3(f"lobe.{name}"), scale=share)
                chosen = scaled if chosen is None else graph.vector("ADD", chosen, scaled)
            assert chosen is not None
            w = graph.add(
                graph.math("COMPARE", part, float(_part_id("ha")), 0.5),
                graph.math("COMPARE", part, float(_part_id("boshi")), 0.5),
            )
            zero = graph.node("ShaderNodeValue", "no hadori").outputs[0]
            zero.default_value = 0.0
            return chosen, graph.constant3("lobe.ha"), w, zero
        uv = graph.node("ShaderNodeUVMap", "uv", uv_map=UV_MAP).outputs[0]
        lobes = graph.node(
            "ShaderNodeTexImage", "lobes", image=self.lobes_image, extension="EXTEND"
        )
        graph.connect(uv, lobes.inputs[0])
        ji_ln_mu, ha_ln_mu, w = graph.channels(lobes.outputs["Color"])
        h = lobes.outputs["Alpha"]
        if self.shape_image is None:
            return graph.combine(ji_ln_mu, 0.0, 0.0), graph.combine(ha_ln_mu, 0.0, 0.0), w, h
        shape = graph.node(
            "ShaderNodeTexImage", "shape", image=self.shape_image, extension="EXTEND"
        )
        graph.connect(uv, shape.inputs[0])
        ji_e1, ji_e2, ha_e1 = graph.channels(shape.outputs["Color"])
        ji = graph.combine(ji_ln_mu, ji_e1, ji_e2)
        ha = graph.combine(ha_ln_mu, ha_e1, shape.outputs["Alpha"])
        return ji, ha, w, h

    def _weighted(
        self, colour: Socket, name: str, lobe: LobeSockets, cosine: Socket, smooth: bool
    ) -> Socket:
        """The colour times measured over normalised weight; a measured chi has no 1/cos(theta_r)."""
        if self.settings.weights != "measured":
            return colour
        graph = self.graph
        ratio = graph.mul(graph.mul(lobe.mu_t, lobe.mu_b), 4.0 * math.pi / math.log(2.0))
        factor = graph.mul(ratio, graph.constant(f"weight.{name}"))
        if smooth:
            factor = graph.mul(factor, cosine)
        return graph.vector("SCALE", colour, scale=factor)

    def _nakago(self, normal: Socket | None) -> Socket:
        """Rust: a Lambertian ground under a dielectric gloss (shaders/shared/plain.glsl)."""
        graph = self.graph
        diffuse = graph.node("ShaderNodeBsdfDiffuse", "rust")
        # Lamps stay white: the light's colour is in the group, for the rust as in the steel's table.
        light = graph.constant3("light.rgb")
        albedo = graph.vector("MULTIPLY", graph.constant3("nakago.albedo"), light)
        graph.connect(albedo, diffuse.inputs["Color"])
        gloss = graph.node("ShaderNodeBsdfAnisotropic", "rust gloss")
        gloss.distribution = "BECKMANN" if self.target == CYCLES else "GGX"
        tan_mu = BECKMANN_OR_GGX[self.target]
        ln_mu, _e1, _e2 = graph.separate(graph.constant3("lobe.nakago"))
        mu = graph.mul(graph.math("EXPONENT", ln_mu), math.radians(1.0))
        alpha = graph.math("MINIMUM", graph.mul(graph.math("TANGENT", mu), 1.0 / tan_mu), 1.0)
        graph.connect(graph.math("SQRT", alpha), gloss.inputs["Roughness"])
        fresnel = graph.node("ShaderNodeFresnel", "rust fresnel")
        graph.connect(graph.constant("nakago.ior"), fresnel.inputs["IOR"])
        gloss_colour = graph.vector("SCALE", light, scale=fresnel.outputs[0])
        graph.connect(gloss_colour, gloss.inputs["Color"])
        if normal is not None:
            for node in (diffuse, gloss, fresnel):
                graph.connect(normal, node.inputs["Normal"])
        both = graph.node("ShaderNodeAddShader")
        graph.connect(diffuse.outputs[0], both.inputs[0])
        graph.connect(gloss.outputs[0], both.inputs[1])
        return both.outputs[0]


def _tan_factors() -> dict[str, float]:
    from .lobe_nodes import BECKMANN_TAN_MU, GGX_TAN_MU

    return {CYCLES: BECKMANN_TAN_MU, EEVEE: GGX_TAN_MU}


BECKMANN_OR_GGX = _tan_factors()


def _part_id(name: str) -> int:
    return {part: index for index, part in enumerate(PARTS)}[name]


PARTS = ("other", "ji", "shinogi_ji", "ha", "mune", "kissaki", "boshi", "nakago")


# --- table ---------------------------------------------------------------------------------------


TABLE_NODE = "F(theta)"


def _own_table(material: bpy.types.Material) -> bpy.types.Image | None:
    """The image in the material's own groups, where nobody else has it. Names say nothing: they are cut, they are
    changed, and other files have them too."""
    trees = [group_of(material, target) for target in (CYCLES, EEVEE) if _is_own(material, target)]
    nodes = [tree.nodes.get(TABLE_NODE) for tree in trees]
    images = [node.image for node in nodes if node is not None and node.image is not None]
    for image in images:
        mine = image.library is None and image.users <= images.count(image)
        if mine and tuple(image.size) == (TABLE_SIZE, 1):
            return image
    return None


def _write_table(material: bpy.types.Material) -> bpy.types.Image:
    """The Fresnel table as an image of one row. Writing it takes some 0.1 ms."""
    image = _own_table(material)
    if image is None:
        image = bpy.data.images.new(
            f"{GROUP_NAME} F: {material.name}",
            TABLE_SIZE,
            1,
            alpha=False,
            float_buffer=True,
            is_data=True,
        )
        image.use_half_precision = False
    table = native.core().fresnel_table(
        properties.metal_spec(material),
        material.togishi.node_spectrum,
        space=blender_versions.working_space(),
        size=TABLE_SIZE,
    )
    pixels = np.ones((TABLE_SIZE, 4), np.float32)
    pixels[:, :3] = table
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


# --- public --------------------------------------------------------------------------------------


def _structure(builder: _Builder) -> str:
    """What decides which nodes there are; all else are numbers that can be set."""
    return json.dumps(
        [
            builder.target,
            builder.lobes_image is not None,
            builder.shape_image is not None,
            builder.normal_image is not None,
            builder.settings.weights,
            [bending_for(builder.aspects[name]).count for name in ("ji", "ha", "hadori")]
            if builder.target == EEVEE
            else [],
        ]
    )


def _set_constants(tree: bpy.types.ShaderNodeTree, values: dict[str, Any], spectrum: str) -> None:
    core = native.core()
    set_constant(
        tree, "light.rgb", core.light_rgb(spectrum, space=blender_versions.working_space())
    )
    for name, part in values["parts"].items():
        encoded = core.encode_lobe(
            np.array([part["mu_t_deg"]]), np.array([part["mu_b_deg"]]), np.array([part["rho_deg"]])
        )
        set_constant(tree, f"lobe.{name}", np.asarray(encoded).reshape(3))
        weight = part.get("chi", part.get("beta"))
        if weight is not None:
            set_constant(tree, f"weight.{name}", weight)
    set_constant(tree, "nakago.albedo", values["parts"]["nakago"]["albedo_rgb"])
    set_constant(tree, "nakago.ior", values["parts"]["nakago"]["ior"])


def _group_node(material: bpy.types.Material, target: str) -> bpy.types.ShaderNode | None:
    tree = material.node_tree
    return None if tree is None else tree.nodes.get(f"{GROUP_NAME} {target}")


def group_of(material: bpy.types.Material, target: str) -> bpy.types.ShaderNodeTree | None:
    """The material's group, whatever material or group are called by now."""
    node = _group_node(material, target)
    return None if node is None else node.node_tree


def _is_own(material: bpy.types.Material, target: str) -> bool:
    """Whether the material has a group for itself. A copied material has the group of the first one until it is
    brought up to date, and one that was made local may have its library's."""
    tree = group_of(material, target)
    if tree is None or tree.library is not None:
        return False
    return all(group_of(other, target) != tree for other in bpy.data.materials if other != material)


def update_group(material: bpy.types.Material, target: str) -> bpy.types.ShaderNodeTree:
    """Make or bring up to date the group of a material for "CYCLES" or "EEVEE"."""
    tree = group_of(material, target)
    if tree is None or not _is_own(material, target):
        tree = bpy.data.node_groups.new(group_name(material, target), "ShaderNodeTree")
        tree.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    table = _write_table(material)
    builder = _Builder(tree, material, target)
    structure = _structure(builder)
    if tree.get(KEY) != structure:
        tree.nodes.clear()
        builder.build(table)
        tree[KEY] = structure
    else:
        for label, image in (
            (TABLE_NODE, table),
            ("lobes", builder.lobes_image),
            ("shape", builder.shape_image),
            ("normal map", builder.normal_image),
        ):
            node = tree.nodes.get(label)
            if node is not None:
                node.image = image
    _set_constants(tree, properties.material_dict(material), material.togishi.node_spectrum)
    return tree


def has_groups(material: bpy.types.Material) -> bool:
    return any(group_of(material, target) is not None for target in (CYCLES, EEVEE))


def connect(material: bpy.types.Material) -> None:
    """Give the material both groups, each at its own renderer's output. Other nodes stay as they are."""
    blender_versions.use_nodes(material)
    tree = material.node_tree
    for row, target in enumerate((CYCLES, EEVEE)):
        group = update_group(material, target)
        node = _group_node(material, target) or tree.nodes.new("ShaderNodeGroup")
        node.name = f"{GROUP_NAME} {target}"
        node.label = f"{GROUP_NAME} ({target.title() if target == CYCLES else target})"
        node.node_tree = group
        node.location = (0.0, -300.0 * (row + 1))
        node.width = 240.0
        output = tree.nodes.get(f"{GROUP_NAME} output {target}") or tree.nodes.new(
            "ShaderNodeOutputMaterial"
        )
        output.name = f"{GROUP_NAME} output {target}"
        output.target = target
        output.location = (300.0, -300.0 * (row + 1))
        tree.links.new(node.outputs[0], output.inputs["Surface"])


def refresh(material: bpy.types.Material) -> None:
    """After an edit: bring existing groups up to date."""
    if native.problem() or not material.togishi.is_blade:
        return
    try:
        for target in (CYCLES, EEVEE):
            node = _group_node(material, target)
            if node is not None and node.node_tree is not None:
                node.node_tree = update_group(material, target)
    except native.core().InputError as error:
        # While a path or a spectrum is being typed. The engine and the bake's operator refuse it in their own words.
        print(f"Info: Togishi: {material.name!r} keeps its node groups as they are: {error}")
