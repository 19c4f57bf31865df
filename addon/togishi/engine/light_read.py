"""Blender's lamps and world as the renderer's data."""

from __future__ import annotations

import math

import bpy
import numpy as np

from .. import blender_versions, properties
from ..core.scene_data import Light, LightKind, World
from .environment_read import KnownEnvironment, SurroundingsError, read_environment, texture_turn
from .node_links import feeding_node

_ROUND = {"DISK", "ELLIPSE"}


def area_size(light: bpy.types.AreaLight) -> tuple[float, float]:
    """Sides, or the axes of the ellipse, in the lamp's own units."""
    other = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    return float(light.size), float(other)


def _flat_axes(directions: np.ndarray) -> np.ndarray:
    """Columns x, y, z of a lamp that shines along -z, unit and perpendicular, whatever its matrix sheared or mirrored."""
    x = directions[:, 0] if directions[:, 0].any() else np.array((1.0, 0.0, 0.0))
    y = directions[:, 1] - x * (x @ directions[:, 1])
    length = float(np.linalg.norm(y))
    if length < 1e-6:
        y = np.cross(np.array((0.0, 0.0, 1.0)) if abs(x[2]) < 0.9 else np.array((0.0, 1.0, 0.0)), x)
        length = float(np.linalg.norm(y))
    y = y / length
    z = np.cross(x, y)
    # The outline is the same with y turned round; what it shines along is not.
    sign = -1.0 if z @ directions[:, 2] < 0.0 else 1.0
    return np.stack([x, sign * y, sign * z], axis=1)


def read_light(light: bpy.types.Light, matrix: np.ndarray) -> Light:
    """The lamp. matrix: (4, 4) to world.

    A light's own temperature is in its spectrum (properties.light_spectrum), so it does not tint it again.
    """
    power = float(light.energy) * 2.0 ** blender_versions.light_exposure_stops(light)
    axes = matrix[:3, :3]
    scales = np.linalg.norm(axes, axis=0)
    directions = axes / np.where(scales > 0.0, scales, 1.0)
    radius = float(getattr(light, "shadow_soft_size", 0.0))
    half_u = half_v = 0.0
    kind = {"POINT": LightKind.POINT, "SPOT": LightKind.SPOT, "SUN": LightKind.SUN}.get(light.type)
    flat = kind is None
    if kind is None:
        kind = LightKind.ELLIPSE if light.shape in _ROUND else LightKind.RECTANGLE
        size_x, size_y = area_size(light)
        half_u, half_v = 0.5 * size_x * float(scales[0]), 0.5 * size_y * float(scales[1])
    if not blender_versions.light_is_normalised(light):
        # The number is then per area of the lamp: of a sphere's surface, of the sun's disc seen from here.
        if kind is LightKind.SUN:
            power *= math.pi * math.sin(0.5 * float(light.angle)) ** 2
        elif flat:
            power *= (math.pi if kind is LightKind.ELLIPSE else 4.0) * half_u * half_v
        else:
            power *= 4.0 * math.pi * radius * radius
    red, green, blue = (float(value) for value in light.color)
    columns = _flat_axes(directions) if flat else directions / np.maximum(scales, 1e-12)
    x, y, z = (tuple(columns[:, i].tolist()) for i in range(3))
    return Light(
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
        radius=0.0 if flat or kind is LightKind.SUN else radius,
        soft_falloff=bool(getattr(light, "use_soft_falloff", True)),
        half_angle_rad=0.5 * float(getattr(light, "angle", 0.0)),
        half_u=half_u,
        half_v=half_v,
        spread_rad=float(getattr(light, "spread", math.pi)),
        shadows=bool(light.use_shadow),
    )


def read_world(world: bpy.types.World | None, known: KnownEnvironment) -> tuple[World, str]:
    """The world's colour or HDRI times its strength, and a note for the user."""
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
            colour = tuple(float(value) for value in background.inputs["Color"].default_value[:3])
            strength = float(background.inputs["Strength"].default_value)
            texture = feeding_node(background.inputs["Color"])
            try:
                if texture is not None and texture.type == "TEX_ENVIRONMENT":
                    turn = texture_turn(texture)
                    environment = read_environment(texture, known)
                    bright = max(strength, 0.0)
                    return World((bright, bright, bright), spectrum, environment, turn), ""
                if texture is not None:
                    raise SurroundingsError(
                        f"{texture.name!r} is no Environment Texture (Bake Surroundings makes one)"
                    )
            except SurroundingsError as error:
                note = f"World {world.name!r}: {error}: the Background node's plain colour is used."
    red, green, blue = (max(value * strength, 0.0) for value in colour)
    return World((red, green, blue), spectrum), note
