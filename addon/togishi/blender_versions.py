"""What differs between Blender versions, in one place. The rest of the add-on asks here."""

from __future__ import annotations

import math

import bpy
import numpy as np

VERSION: tuple[int, int, int] = bpy.app.version


def light_temperature_k(light: bpy.types.Light) -> float | None:
    """The light's own colour temperature in K where the version has it (4.5) and it is in use."""
    if getattr(light, "use_temperature", False):
        return float(light.temperature)
    return None


def light_exposure_stops(light: bpy.types.Light) -> float:
    """The light's own exposure in stops; 0 where the version does not have it (before 4.5)."""
    return float(getattr(light, "exposure", 0.0))


def light_is_normalised(light: bpy.types.Light) -> bool:
    """Whether a light's power is that of the whole lamp, not of each unit of its area; before 4.5 it always is."""
    return bool(getattr(light, "normalize", True))


def eevee_engine() -> str:
    """EEVEE's identifier: BLENDER_EEVEE_NEXT in 4.2 to 4.5, BLENDER_EEVEE from 5.0."""
    return "BLENDER_EEVEE" if VERSION >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"


def working_space() -> str:
    """Name, as togishi_core.colour_spaces has it, of the scene-linear space of this file.

    From 5.0 a file may work in ACEScg or Rec.2020; older versions work in Rec.709."""
    names = {
        "Linear Rec.709": "rec709",
        "Linear Rec.2020": "rec2020",
        "ACEScg": "acescg_d65",
    }
    colourspace = getattr(bpy.data, "colorspace", None)
    return names.get(getattr(colourspace, "working_space", "Linear Rec.709"), "rec709")


def use_nodes(owner: bpy.types.Material | bpy.types.World) -> None:
    """Give a material or world its node tree; from 5.0 it always has one."""
    if VERSION < (5, 0, 0) or owner.node_tree is None:
        owner.use_nodes = True


def set_file_format(settings: bpy.types.ImageFormatSettings, identifier: str) -> None:
    """Choose a still format; from 5.0 its kind of medium has to be chosen first."""
    if hasattr(settings, "media_type"):
        settings.media_type = (
            "MULTI_LAYER_IMAGE" if identifier == "OPEN_EXR_MULTILAYER" else "IMAGE"
        )
    settings.file_format = identifier


# File settings that may be relative to the .blend say so from 4.5; before, all may.
RELATIVE_PATH = {"PATH_SUPPORTS_BLEND_RELATIVE"} if VERSION >= (4, 5, 0) else set()


EXACT_NORMALS = "togishi_normal"
_ROUNDED_COSINE = math.cos(math.radians(1.5))


def set_corner_normals(mesh: bpy.types.Mesh, normals: np.ndarray) -> None:
    """Custom normals (C, 3), unit, per corner. From 4.5 they are kept as they are. Before, Blender keeps angles
    in 16 bits and averages neighbours within .8 degrees, which is as much as a polished ji's lobe is wide: there the
    exact ones are kept beside them, for our engine (corner_normals)."""
    if VERSION >= (4, 5, 0):
        attribute = mesh.attributes.new("custom_normal", "FLOAT_VECTOR", "CORNER")
        attribute.data.foreach_set("vector", np.ascontiguousarray(normals, np.float32).reshape(-1))
    else:
        mesh.normals_split_custom_set(normals)
        exact = mesh.attributes.new(EXACT_NORMALS, "FLOAT_VECTOR", "CORNER")
        exact.data.foreach_set("vector", np.ascontiguousarray(normals, np.float32).reshape(-1))


def corner_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """Normals (C, 3) of an evaluated mesh: Blender's, or the exact ones beside them where they still belong to the
    shape, that is, where they lie no further off than Blender rounds."""
    count = len(mesh.loops)
    normals = np.empty(count * 3, np.float32)
    mesh.corner_normals.foreach_get("vector", normals)
    normals = normals.reshape(-1, 3)
    kept = mesh.attributes.get(EXACT_NORMALS)
    if kept is None or kept.domain != "CORNER" or kept.data_type != "FLOAT_VECTOR":
        return normals
    exact = np.empty(count * 3, np.float32)
    kept.data.foreach_get("vector", exact)
    exact = exact.reshape(-1, 3)
    near = (exact * normals).sum(axis=1) > _ROUNDED_COSINE
    return np.where(near[:, None], exact, normals)


def action_curves(owner: bpy.types.ID) -> list[bpy.types.FCurve]:
    """The animation curves of a data-block; from 5.0 they are in the channel bag of its action's slot."""
    data = owner.animation_data
    if data is None or data.action is None:
        return []
    if hasattr(data.action, "fcurves"):
        return list(data.action.fcurves)
    return [
        curve
        for layer in data.action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        if bag.slot == data.action_slot
        for curve in bag.fcurves
    ]
