"""Blender's lamps and world as the renderer's data."""

from __future__ import annotations

import math

import bpy
import numpy as np

from .. import blender_versions, properties
from ..core.scene_data import Light, LightKind, World
from .node_links import feeding_node


def _area_m2(light: bpy.types.AreaLight) -> float:
    other = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    part = 0.25 * math.pi if light.shape in {"DISK", "ELLIPSE"} else 1.0
    return part * float(light.size) * float(other)


def read_light(light: bpy.types.Light, matrix: np.ndarray) -> tuple[Light, str]:
    """The lamp, and a note for the user ("" where nothing needs saying). matrix: (4, 4) to world.

    A light's own temperature is in its spectrum (properties.light_spectrum), so it does not tint it again.
    """
    power = float(light.energy) * 2.0 ** blender_versions.light_exposure_stops(light)
    note = ""
    axes = matrix[:3, :3]
    scales = np.linalg.norm(axes, axis=0)
    directions = axes / np.where(scales > 0.0, scales, 1.0)
    kind = {"POINT": LightKind.POINT, "SPOT": LightKind.SPOT, "SUN": LightKind.SUN}.get(light.type)
    if kind is None:
        kind = LightKind.POINT
        note = (
            f"Light {light.name!r} ({light.type.lower()}) is drawn as a point light of its power."
        )
    if not blender_versions.light_is_normalised(light):
        # The number is then per area of the lamp: of a sphere's surface, of the sun's disc seen from here.
        if kind is LightKind.SUN:
            power *= math.pi * math.sin(0.5 * float(light.angle)) ** 2
        elif light.type == "AREA":
            power *= _area_m2(light) * float(scales[0] * scales[1])
        else:
            radius = float(getattr(light, "shadow_soft_size", 0.0))
            power *= 4.0 * math.pi * radius * radius
    red, green, blue = (float(value) for value in light.color)
    x, y, z = (tuple((directions[:, i] / max(scales[i], 1e-12)).tolist()) for i in range(3))
    return (
        Light(
            kind=kind,
            position=tuple(matrix[:3, 3].tolist()),
            to_light=tuple(directions[:, 2].tolist()),
            power=power if math.isfinite(power) else 0.0,
            colour=(red, green, blue),
            spectrum=properties.light_spectrum(light),
            x_axis=x,
            y_axis=y,
            z_axis=z,
            cone_rad=float(getattr(light, "spot_size", math.pi / 4)),
            blend=float(getattr(light, "spot_blend", 0.0)),
        ),
        note,
    )


def read_world(world: bpy.types.World | None) -> tuple[World, str]:
    """The world's colour times its strength, and a note for the user."""
    if world is None:
        return World(), ""
    spectrum = properties.world_spectrum(world)
    note = ""
    colour = tuple(float(value) for value in world.color)
    strength = 1.0
    output = None
    if world.use_nodes and world.node_tree is not None:
        output = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
    if output is not None:
        background = feeding_node(output.inputs["Surface"])
        if background is None:
            return World((0.0, 0.0, 0.0), spectrum), ""
        if background.type != "BACKGROUND":
            note = (
                f"World {world.name!r}: only a Background node is used; {background.name!r} is not."
            )
        else:
            if background.inputs["Color"].is_linked:
                note = (
                    f"World {world.name!r}: textures of the surroundings are not used, "
                    "the Background node's plain colour is."
                )
            colour = tuple(float(value) for value in background.inputs["Color"].default_value[:3])
            strength = float(background.inputs["Strength"].default_value)
    red, green, blue = (max(value * strength, 0.0) for value in colour)
    return World((red, green, blue), spectrum), note
