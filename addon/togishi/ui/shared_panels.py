"""Blender's own panels for light, world, camera and output, shown for our engine too."""

from __future__ import annotations

import bpy

ENGINE = "TOGISHI"

# Panels that show settings which our engine does not honour.
EXCLUDED = {
    "DATA_PT_area",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "DATA_PT_falloff_curve",
    "DATA_PT_light",  # DATA_PT_EEVEE_light begins with the same row
    "DATA_PT_lightprobe",
    "DATA_PT_lightprobe_display",
    "DATA_PT_lightprobe_parallax",
    "DATA_PT_lightprobe_visibility",
    "DATA_PT_preview",
    "DATA_PT_volumes",
    "EEVEE_MATERIAL_PT_viewport_settings",
    "MATERIAL_PT_preview",
    "RENDER_PT_eevee_film",
    "RENDER_PT_eevee_hair",
    "RENDER_PT_freestyle",
    "RENDER_PT_freestyle_eevee_next",
    "RENDER_PT_gpencil",
    "RENDER_PT_grease_pencil",
    "RENDER_PT_simplify",
    "SCENE_PT_audio",
    "VIEWLAYER_PT_eevee_layer_passes_data",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "WORLD_PT_volume",
}


def _panels() -> list[type]:
    """Blender's panels for engines without panels of their own, which name BLENDER_RENDER to this day, and those of
    EEVEE for lights, worlds and material slots. What names Workbench or EEVEE alone is about those engines."""
    found = []
    for cls in bpy.types.Panel.__subclasses__():
        engines = getattr(cls, "COMPAT_ENGINES", None)
        # Blender's copies for the node editor, named NODE_…, share the set of engines with their originals.
        excluded = cls.__name__.removeprefix("NODE_") in EXCLUDED
        if not engines or excluded or "togishi" in cls.__module__:
            continue
        common = "BLENDER_RENDER" in engines
        light = cls.__name__ in {
            "DATA_PT_EEVEE_light",
            "DATA_PT_spot",
            "DATA_PT_custom_props_light",
            "EEVEE_WORLD_PT_surface",
            "EEVEE_MATERIAL_PT_context_material",
        }
        if common or light:
            found.append(cls)
    return found


def register() -> None:
    for cls in _panels():
        cls.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for cls in bpy.types.Panel.__subclasses__():
        if "togishi" not in cls.__module__ and hasattr(cls, "COMPAT_ENGINES"):
            cls.COMPAT_ENGINES.discard(ENGINE)
