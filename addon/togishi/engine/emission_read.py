"""Surfaces that shine: rectangles are lamps, with their pictures; others are only bright."""

from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np

from ..core.lamp_pictures import power_of_two
from ..core.scene_data import F32, F64, Instance, LampPicture, Light, LightKind
from .image_maps import image_key, linear_pixels
from .node_links import feeding_node

# Corners of a rectangle may be off by this share of its sides.
_SQUARE = 1.0e-3


@dataclass(frozen=True)
class Emission:
    """What a material's surface shines with."""

    radiance: tuple[float, float, float] = (0.0, 0.0, 0.0)  # that multiplies the image
    image: bpy.types.Image | None = None
    note: str = ""

    @property
    def dark(self) -> bool:
        return not max(self.radiance) > 0.0


class KnownPictures:
    """Images as lamps shine with them, each read once while its content is the same."""

    def __init__(self) -> None:
        self._pixels: dict[tuple[object, ...], F32] = {}
        self._pictures: dict[tuple[object, ...], LampPicture] = {}

    def picture(
        self,
        image: bpy.types.Image,
        to_u: tuple[float, float, float],
        to_v: tuple[float, float, float],
    ) -> LampPicture | None:
        """None where the image has no pixels."""
        key = (*image_key(image), image.colorspace_settings.name)
        if key not in self._pixels:
            rows = linear_pixels(image)
            if rows is None:
                return None
            for old in [k for k in self._pixels if k[0] == key[0]]:
                del self._pixels[old]
            self._pixels[key] = power_of_two(rows)
        whole = (key, to_u, to_v)
        if whole not in self._pictures:
            self._pictures = {k: v for k, v in self._pictures.items() if k[0] in self._pixels}
            self._pictures[whole] = LampPicture(self._pixels[key], to_u, to_v)
        return self._pictures[whole]


def read_emission(material: bpy.types.Material | None) -> Emission:
    """Of an Emission shader or a Principled one; its colour may be an Image Texture."""
    if material is None or not material.use_nodes or material.node_tree is None:
        return Emission()
    tree = material.node_tree
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    surface = feeding_node(output.inputs["Surface"]) if output is not None else None
    if surface is None or surface.type not in {"EMISSION", "BSDF_PRINCIPLED"}:
        return Emission()
    principled = surface.type == "BSDF_PRINCIPLED"
    strength = surface.inputs["Emission Strength" if principled else "Strength"]
    colour = surface.inputs["Emission Color" if principled else "Color"]
    amount = float(strength.default_value)
    if not (math.isfinite(amount) and amount > 0.0):
        return Emission()
    note = ""
    if feeding_node(strength) is not None:
        note = f"Material {material.name!r}: what feeds its emission's strength is not followed."
    source = feeding_node(colour)
    image = None
    tint = tuple(float(c) for c in colour.default_value[:3])
    if source is not None:
        tint = (1.0, 1.0, 1.0)
        if source.type == "TEX_IMAGE" and source.image is not None:
            image = source.image
        else:
            note = f"Material {material.name!r}: its emission's colour is followed to an Image Texture only; it shines white."
    red, green, blue = (max(c, 0.0) * amount if math.isfinite(c) else 0.0 for c in tint)
    return Emission((red, green, blue), image, note)


@dataclass(frozen=True, eq=False)
class Rectangle:
    """A mesh that is one rectangle, in its own space."""

    corners: F64  # (4, 3) around
    uv: F64 | None  # (4, 2) of them


def rectangle_of(mesh: bpy.types.Mesh) -> Rectangle | None:
    """The mesh, where it is one face of four corners."""
    if len(mesh.polygons) != 1 or len(mesh.loops) != 4:
        return None
    corners = np.array([mesh.vertices[loop.vertex_index].co for loop in mesh.loops], np.float64)
    layer = mesh.uv_layers.active
    uv = None
    if layer is not None:
        uv = np.empty(8, np.float32)
        layer.uv.foreach_get("vector", uv)
        uv = uv.reshape(4, 2).astype(np.float64)
    return Rectangle(corners, uv)


def lamps_of(
    rectangle: Rectangle, thing: Instance, emission: Emission, pictures: KnownPictures
) -> list[Light]:
    """Two lamps back to back, as a surface shines to both sides; none where the thing's matrix makes it no rectangle."""
    corners = rectangle.corners @ thing.matrix[:3, :3].T + thing.matrix[:3, 3]
    side_x, side_y = corners[1] - corners[0], corners[3] - corners[0]
    length_x, length_y = float(np.linalg.norm(side_x)), float(np.linalg.norm(side_y))
    longest = max(length_x, length_y)
    if not (math.isfinite(longest) and min(length_x, length_y) > 0.0):
        return []
    off = float(np.linalg.norm(corners[2] - corners[0] - side_x - side_y))
    if off > _SQUARE * longest or abs(float(side_x @ side_y)) > _SQUARE * length_x * length_y:
        return []
    x, y = side_x / length_x, side_y / length_y
    normal = np.cross(x, y)
    brightest = max(emission.radiance)
    lamps = []
    for side in (1.0, -1.0):
        picture = None
        if emission.image is not None and rectangle.uv is not None:
            a, b, _c, d = rectangle.uv
            along_x, along_y = 0.5 * (b - a), 0.5 * (d - a)
            middle = a + along_x + along_y
            # It shines along -z of x, y, z: the front is seen with y turned round.
            along_y = -side * along_y
            to_u, to_v = (
                (float(along_x[i]), float(along_y[i]), float(middle[i])) for i in range(2)
            )
            picture = pictures.picture(emission.image, to_u, to_v)
        lamps.append(
            Light(
                kind=LightKind.RECTANGLE,
                position=tuple(corners.mean(axis=0).tolist()),
                power=math.pi * length_x * length_y * brightest,
                colour=tuple(c / brightest for c in emission.radiance),
                x_axis=tuple(x.tolist()),
                y_axis=tuple((-side * y).tolist()),
                z_axis=tuple((-side * normal).tolist()),
                half_u=0.5 * length_x,
                half_v=0.5 * length_y,
                shadows=True,
                picture=picture,
                thing=thing,
            )
        )
    return lamps
