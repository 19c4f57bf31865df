"""Scenes on which the GPU is held against the reference. No Blender scene: the renderer's own data.

`tile_scene` is a wall of tiles that face the camera, one per metal and lobe. A tile's normals are spread about the one
that mirrors the light into the camera at the wanted incidence, so that every incidence has its highlight, with the
lobe's flank around it, on many pixels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import togishi_core
from togishi.core.scene_data import (
    BladeMaterial,
    Camera,
    Instance,
    Light,
    LightKind,
    MapData,
    MeshData,
    MeshGroup,
    PlainMaterial,
    SceneData,
    SteelMaterial,
)

PART_JI, PART_HA = 1, 3
TILE_PIXELS = 20
VERTICES = 9
"""Along a tile's side: between them the GPU interpolates and renormalises."""


@dataclass(frozen=True)
class TestLobe:
    """Half widths in degrees; rough: a hamon's (Torrance-Sparrow), else a ji's."""

    mu_t_deg: float
    mu_b_deg: float
    rho_deg: float
    rough: bool

    @property
    def stored(self) -> tuple[float, float, float]:
        stored = togishi_core.encode_lobe(
            np.array(self.mu_t_deg), np.array(self.mu_b_deg), np.array(self.rho_deg)
        )
        ln_mu, e1, e2 = np.asarray(stored, float).reshape(3).tolist()
        return ln_mu, e1, e2


# From the sharpest polish to blasted steel; the anisotropy of strokes, and 20:1.
LOBES = (
    TestLobe(0.2, 0.2, 0, False),
    TestLobe(0.8, 0.8, 0, False),
    TestLobe(2.0, 0.5, 30, False),
    TestLobe(4.0, 0.2, 90, False),
    TestLobe(5.0, 5.0, 0, True),
    TestLobe(12.0, 9.0, 120, True),
)


def steel(metal: str, lobe: TestLobe, maps: MapData | None = None) -> BladeMaterial:
    material = SteelMaterial(
        metal=metal,
        part_lobes=(lobe.stored,) * 8,
        part_weights=(-1.0,) * 8,
        part_rough=(lobe.rough,) * 8,
        ha=(*lobe.stored, -1.0),
        hadori=(*lobe.stored, -1.0),
        maps=maps,
    )
    return BladeMaterial(steel=material, nakago=PlainMaterial())


def tile_mesh(mirror: np.ndarray, reach_rad: float, part: int) -> MeshData:
    """A unit square facing +z; its normals lean from `mirror` by up to `reach_rad`, its tangents turn slowly."""
    at = np.linspace(0.0, 1.0, VERTICES)
    u, v = (grid.ravel() for grid in np.meshgrid(at, at))
    lean_x, lean_y = (2 * u - 1) * reach_rad, (2 * v - 1) * reach_rad
    across = np.array([0.0, 1.0, 0.0])
    along = np.cross(across, mirror)
    normal = mirror + np.tan(lean_x)[:, None] * along + np.tan(lean_y)[:, None] * across
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = 0.4 * (u + v)
    tangent = np.cos(turn)[:, None] * along + np.sin(turn)[:, None] * across
    corner = np.arange(VERTICES * (VERTICES - 1)).reshape(VERTICES - 1, VERTICES)[:, :-1].ravel()
    right, up = corner + 1, corner + VERTICES
    triangles = np.concatenate(
        [np.column_stack([corner, right, up]), np.column_stack([right, up + 1, up])]
    )
    return MeshData(
        position=np.column_stack([u, v, np.zeros_like(u)]).astype(np.float32),
        normal_part=np.column_stack([normal, np.full(len(u), part)]).astype(np.float32),
        uv=np.column_stack([u, v]).astype(np.float32),
        tangent=tangent.astype(np.float32),
        groups=(MeshGroup(0, False, triangles.astype(np.uint32)),),
    )


def wall_camera(columns: int, rows: int) -> tuple[Camera, tuple[int, int]]:
    """Orthographic, 10 above the wall: every pixel sees along -z."""
    view = np.eye(4)
    view[:3, 3] = -np.array([columns / 2, rows / 2, 10.0])
    projection = np.diag([2 / columns, 2 / rows, -2 / 20.0, 1.0])
    projection[2, 3] = -1.0
    return Camera(view, projection), (columns * TILE_PIXELS, rows * TILE_PIXELS)


def directions(incidence_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """The normal that mirrors, and the direction to the light, for a viewer at +z."""
    theta = math.radians(incidence_deg)
    return (
        np.array([math.sin(theta), 0.0, math.cos(theta)]),
        np.array([math.sin(2 * theta), 0.0, math.cos(2 * theta)]),
    )


def tile_scene(
    metals: Sequence[str],
    spectrum: str,
    incidence_deg: float,
    *,
    point_light: bool,
    space: str = "rec709",
) -> tuple[SceneData, Camera, tuple[int, int]]:
    """Columns: metals; rows: LOBES. One light."""
    from togishi.core.scene_data import ColourSettings

    mirror, to_light = directions(incidence_deg)
    meshes, materials, instances = {}, {}, []
    for row, lobe in enumerate(LOBES):
        # Beyond 3.6 half widths the lobe is under 1e-4 of its peak; grazing tiles stop at the horizon.
        reach = math.radians(min(3.0 * lobe.mu_t_deg, 30.0))
        part = PART_HA if lobe.rough else PART_JI
        meshes[f"lobe {row}"] = tile_mesh(mirror, reach, part)
        for column, metal in enumerate(metals):
            materials[f"{metal} {row}"] = steel(metal, lobe)
            matrix = np.eye(4)
            matrix[:3, 3] = (column, row, 0.0)
            instances.append(Instance(f"lobe {row}", matrix, (f"{metal} {row}",)))
    middle = np.array([len(metals) / 2, len(LOBES) / 2, 0.0])
    light = (
        # So far that its direction changes by a small part of the tiles' reach.
        Light(
            LightKind.POINT,
            position=tuple((middle + 2000.0 * to_light).tolist()),
            power=1.0e8,
            spectrum=spectrum,
        )
        if point_light
        else Light(LightKind.SUN, to_light=tuple(to_light.tolist()), power=2.0, spectrum=spectrum)
    )
    scene = SceneData(
        meshes=meshes,
        materials=materials,
        instances=tuple(instances),
        lights=(light,),
        colour=ColourSettings(space=space),
    )
    return scene, *wall_camera(len(metals), len(LOBES))
