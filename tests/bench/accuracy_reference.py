"""The reference's picture of what the GPU drew: fed the GPU's own interpolated normals, tangents, views, positions,
directions to the lamps and map values (Renderer.gbuffer), so that what remains is the arithmetic of the shading."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import togishi_core
from togishi.core import packing
from togishi.core.scene_data import BladeMaterial, Camera, LightKind, SceneData
from togishi.engine.renderer import Gbuffer

ReferenceXyz = Callable[..., np.ndarray]


def to_xyz(rgb: np.ndarray, space: str) -> np.ndarray:
    """Linear RGB of the working space to XYZ."""
    return rgb.astype(np.float64) @ np.linalg.inv(togishi_core.xyz_to_rgb(space)).T


def arriving(
    scene: SceneData, camera: Camera, position: np.ndarray
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Spectra, index of each lamp's, and irradiances (P, K) at positions in view space. The lamps' places are those
    that the GPU gets, in float."""
    passes = packing.light_passes(scene.lights, scene.world)
    assert len(passes) == 1, "a test scene fits into one pass"
    space = packing.view_space(camera, (1, 1))
    block = packing.lights_block(passes[0], space).astype(np.float64)
    irradiances = []
    for light, (place, _) in zip(passes[0].lights, block, strict=False):
        assert light.colour == (1.0, 1.0, 1.0), "the reference knows spectra, not tints"
        assert light.kind is not LightKind.SPOT
        if light.kind is LightKind.SUN:
            irradiances.append(np.full(len(position), light.power))
        else:
            to_light = place[:3] - position
            squared = np.sum(to_light**2, axis=1)
            irradiances.append(light.power / (4 * math.pi * squared))
    spectra = list(passes[0].spectra)
    light_of = np.array([spectra.index(light.spectrum) for light in passes[0].lights], np.int32)
    return spectra, light_of, np.stack(irradiances, axis=1)


def reference_picture(
    scene: SceneData,
    camera: Camera,
    gbuffer: Gbuffer,
    reference_xyz: ReferenceXyz | None = None,
) -> np.ndarray:
    """XYZ (H, W, 3); NaN where there is no polished steel."""
    evaluate = reference_xyz or togishi_core.reference_xyz
    picture = np.full((*gbuffer.covered.shape, 3), np.nan)
    for number, key in enumerate(gbuffer.materials):
        material = scene.materials[key]
        assert isinstance(material, BladeMaterial)
        steel = material.steel
        here = gbuffer.covered & (gbuffer.steel == number)
        parts = gbuffer.part[here]
        for part in np.unique(parts):
            chosen = here.copy()
            chosen[here] = parts == part
            points = {
                name: getattr(gbuffer, name)[chosen].astype(np.float64)
                for name in (
                    "normal",
                    "tangent",
                    "view",
                    "position",
                    "lobe_ji",
                    "lobe_hadori",
                    "lobe_ha",
                    "w",
                    "h",
                )
            }
            spectra, light_of, irradiances = arriving(scene, camera, points.pop("position"))
            with_maps = steel.maps is not None
            chi = packing.steel_block(steel)[8 + part if with_maps else part, 3]
            picture[chosen] = evaluate(
                steel.metal,
                spectra,
                light_of,
                light_direction=gbuffer.directions[chosen].astype(np.float64),
                irradiance=irradiances,
                chi=float(chi),
                beta_ha=float(steel.ha[3] if with_maps else chi),
                beta_hadori=float(steel.hadori[3]),
                world=None
                if scene.world.black
                else (scene.world.spectrum, float(scene.world.radiance[0])),
                observer=scene.colour.observer,
                **points,
            )
    return picture
