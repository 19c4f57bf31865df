"""A scan's colours and its relief in the blade's material: nodes at hand, which the user connects. Togishi's steel is
lit by its own model; a scan's colours hold the light under which it was taken, so they replace nothing by themselves."""

from __future__ import annotations

import bpy

from .. import blender_versions
from ..blade_object import MM, UV_MAP

CHART, COLOUR, DISPLACEMENT, RELIEF = (
    "Togishi scan chart",
    "Togishi scan colours",
    "Togishi scan displacement",
    "Togishi scan relief",
)
_LEFT, _TOP, _STEP = -900.0, 300.0, 320.0


def _node(tree: bpy.types.NodeTree, kind: str, name: str, row: int, column: int) -> bpy.types.Node:
    node = tree.nodes.get(name)
    if node is None:
        node = tree.nodes.new(kind)
        node.name = node.label = name
        node.location = (_LEFT + column * _STEP, _TOP - row * _STEP)
    return node


def _image(
    tree: bpy.types.NodeTree, name: str, image: bpy.types.Image | None, row: int
) -> bpy.types.Node | None:
    """The node of an image, in the chart; None where there is no image any more, or none yet."""
    if image is None:
        old = tree.nodes.get(name)
        if old is not None:
            tree.nodes.remove(old)
        return None
    fresh = name not in tree.nodes
    node = _node(tree, "ShaderNodeTexImage", name, row, 1)
    node.image = image
    if fresh:
        node.extension = "EXTEND"
        chart = _node(tree, "ShaderNodeUVMap", CHART, 0, 0)
        chart.uv_map = UV_MAP
        tree.links.new(chart.outputs["UV"], node.inputs["Vector"])
    return node


def put(
    material: bpy.types.Material,
    colours: bpy.types.Image | None,
    displacement: bpy.types.Image | None,
    unit_m: float,
) -> None:
    """Nodes of both, made or brought up to date. Connections of the user's stay. unit_m: metres per scene unit."""
    blender_versions.use_nodes(material)
    tree = material.node_tree
    relief_source = _image(tree, DISPLACEMENT, displacement, 1)
    if relief_source is None:
        old = tree.nodes.get(RELIEF)
        if old is not None:
            tree.nodes.remove(old)
    else:
        fresh = RELIEF not in tree.nodes
        relief = _node(tree, "ShaderNodeDisplacement", RELIEF, 1, 2)
        relief.inputs["Midlevel"].default_value = 0.0
        relief.inputs["Scale"].default_value = MM / unit_m  # the image is in mm
        if fresh:
            tree.links.new(relief_source.outputs["Color"], relief.inputs["Height"])
    picture = _image(tree, COLOUR, colours, 0)
    if picture is not None:
        tree.nodes.active = picture  # what Solid shading shows as Texture
