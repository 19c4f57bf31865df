"""What differs between Blender versions, in one place. The rest of the add-on asks here."""

from __future__ import annotations

import bpy

VERSION: tuple[int, int, int] = bpy.app.version


def light_temperature_k(light: bpy.types.Light) -> float | None:
    """The light's own colour temperature in K where the version has it (4.5) and it is in use."""
    if getattr(light, "use_temperature", False):
        return float(light.temperature)
    return None


def light_exposure_stops(light: bpy.types.Light) -> float:
    """The light's own exposure in stops; 0 where the version does not have it (before 4.5)."""
    return float(getattr(light, "exposure", 0.0))


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
