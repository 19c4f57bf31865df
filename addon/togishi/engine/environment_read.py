"""The HDRI of Blender's world."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
from mathutils import Matrix

from ..core.scene_data import Environment
from ..core.surroundings import prepare
from .image_maps import image_key, linear_pixels
from .node_links import feeding_node

Rows = tuple[tuple[float, float, float], ...]
STRAIGHT: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class SurroundingsError(ValueError):
    """The surroundings cannot be used as they are; the message says why, without the world's name."""


@dataclass
class KnownEnvironment:
    """The last HDRI that was prepared: a new one is made only where the image has other content."""

    key: tuple[object, ...] = ()
    environment: Environment | None = None


def texture_turn(texture: bpy.types.ShaderNodeTexEnvironment) -> Rows:
    """Rows of the rotation from the world to the picture, of the Mapping node behind the texture."""
    vector = feeding_node(texture.inputs["Vector"])
    if vector is None or vector.type == "TEX_COORD":
        return STRAIGHT
    if vector.type != "MAPPING":
        raise SurroundingsError(
            f"the texture is turned by a Mapping node only; {vector.name!r} is not one"
        )
    if any(
        vector.inputs[name].is_linked
        for name in ("Location", "Rotation", "Scale")
        if name in vector.inputs
    ):
        raise SurroundingsError(f"the sockets of {vector.name!r} must not be linked")
    scale = tuple(vector.inputs["Scale"].default_value)
    moved = "Location" in vector.inputs and any(vector.inputs["Location"].default_value)
    if any(abs(value - 1.0) > 1e-6 for value in scale) or (
        moved and vector.vector_type != "VECTOR"
    ):
        raise SurroundingsError(f"{vector.name!r} may only rotate")
    turn = vector.inputs["Rotation"].default_value.to_matrix()
    if vector.vector_type == "TEXTURE":
        turn = turn.transposed()
    return _rows(turn)


def _rows(matrix: Matrix) -> Rows:
    return tuple(tuple(float(value) for value in row) for row in matrix)


def read_environment(
    texture: bpy.types.ShaderNodeTexEnvironment, known: KnownEnvironment
) -> Environment:
    """Raises SurroundingsError with what is wrong."""
    image = texture.image
    if image is None:
        raise SurroundingsError(f"{texture.name!r} has no image")
    if texture.projection != "EQUIRECTANGULAR":
        raise SurroundingsError(f"{texture.name!r} must be equirectangular")
    key = (*image_key(image), image.colorspace_settings.name)
    if known.environment is not None and known.key == key:
        return known.environment
    pixels = linear_pixels(image)
    if pixels is None:
        raise SurroundingsError(f"image {image.name!r} cannot be read")
    known.environment, known.key = prepare(pixels), key
    return known.environment
