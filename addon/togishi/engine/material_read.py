"""Blender's materials as the renderer's data."""

from __future__ import annotations

import math

import bpy

from ..core.materials import gloss_ln_mu_deg
from ..core.scene_data import PlainMaterial
from .node_links import feeding_node

DEFAULT = PlainMaterial(gloss_ln_mu_deg=gloss_ln_mu_deg(0.5))


def _value(node: bpy.types.Node, name: str, fallback: float) -> float:
    socket = node.inputs.get(name)
    return fallback if socket is None else float(socket.default_value)


def read_plain(material: bpy.types.Material | None) -> PlainMaterial:
    """Base colour, roughness, metallic and index of a Principled (or colour of a diffuse) shader, else the
    colour that the viewport shows in solid shading. Textures are not followed."""
    if material is None:
        return DEFAULT
    surface = None
    if material.use_nodes and material.node_tree is not None:
        output = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node(
            "ALL"
        )
        surface = feeding_node(output.inputs["Surface"]) if output is not None else None
    if surface is not None and surface.type in ("BSDF_PRINCIPLED", "BSDF_DIFFUSE"):
        principled = surface.type == "BSDF_PRINCIPLED"
        colour = surface.inputs["Base Color" if principled else "Color"].default_value
        roughness = _value(surface, "Roughness", 0.5) if principled else 1.0
        metallic = _value(surface, "Metallic", 0.0) if principled else 0.0
        ior = _value(surface, "IOR", 1.5) if principled else 1.0
    elif surface is not None and surface.type == "EMISSION":
        # It shines (emission_read.py) and reflects nothing.
        return PlainMaterial((0.0, 0.0, 0.0), ior=1.0, gloss_ln_mu_deg=DEFAULT.gloss_ln_mu_deg)
    else:
        colour = material.diffuse_color
        roughness, metallic, ior = material.roughness, material.metallic, 1.5
    red, green, blue = (
        min(max(float(c), 0.0), 1.0) if math.isfinite(c) else 0.0 for c in colour[:3]
    )
    return PlainMaterial(
        albedo=(red, green, blue),
        ior=min(max(float(ior), 1.0), 4.0),
        gloss_ln_mu_deg=gloss_ln_mu_deg(float(roughness)),
        metallic=min(max(float(metallic), 0.0), 1.0),
    )
