"""Scenes for the engine's tests: as data for the Renderer, and as objects in Blender."""

from __future__ import annotations

import math

import numpy as np
import togishi_core
from togishi.core import packing
from togishi.core.materials import blade_material
from togishi.core.scene_data import (
    BladeMaterial,
    Camera,
    Instance,
    Light,
    LightKind,
    MapData,
    MeshData,
    SceneData,
    World,
)


def sphere(radius: float = 1.0, rings: int = 48, uv: bool = True, part: int = 1) -> MeshData:
    """A closed sphere with exact normals; every angle of view and light is on it."""
    theta = np.linspace(0.0, math.pi, rings + 1)
    turn = np.linspace(0.0, 2.0 * math.pi, 2 * rings + 1)
    t, p = np.meshgrid(theta, turn, indexing="ij")
    normal = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1).reshape(-1, 3)
    index = np.arange(t.size).reshape(t.shape)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(
        -1, 4
    )
    corners = np.arange(quads.size).reshape(-1, 4)
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    corner_vertex = quads.reshape(-1)
    coordinates = np.stack([p / (2.0 * math.pi), t / math.pi], -1).reshape(-1, 2)
    return packing.build_mesh(
        (radius * normal).astype(np.float32),
        corner_vertex.astype(np.int32),
        triangles.astype(np.int32),
        np.tile(np.arange(len(quads)), 2).astype(np.int32),
        normal[corner_vertex].astype(np.float32),
        np.full(len(quads), part),
        None,
        coordinates[corner_vertex].astype(np.float32) if uv else None,
        None,
        frozenset({0}),
    )


def blade(maps: MapData | None = None, **parts: dict[str, float]) -> BladeMaterial:
    """The default material; parts: values to change, such as ji={"mu_t_deg": 4.0}."""
    material = togishi_core.default_material()
    for name, values in parts.items():
        material["parts"][name].update(values)
    return blade_material(material, maps)


def isotropic_blade(mu_deg: float = 3.0, maps: MapData | None = None) -> BladeMaterial:
    """All parts with one isotropic lobe."""
    lobe = {"mu_t_deg": mu_deg, "mu_b_deg": mu_deg, "rho_deg": 0.0}
    names = ("ji", "ha", "hadori", "shinogi_ji", "mune", "kissaki")
    return blade(maps, **{name: lobe for name in names})


def maps_of(lobes: np.ndarray, shape: np.ndarray | None = None) -> MapData:
    return packing.map_data(
        *togishi_core.pack_mip_atlas(
            np.asarray(lobes, np.float32), None if shape is None else np.asarray(shape, np.float32)
        )
    )


def look_at(
    eye: tuple[float, float, float],
    target: tuple[float, float, float] = (0.0, 0.0, 0.0),
    fov_deg: float = 45.0,
    near: float = 0.1,
    far: float = 100.0,
    aspect: float = 1.0,
) -> Camera:
    """A perspective camera; up is z."""
    back = np.subtract(eye, target).astype(np.float64)
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    view = np.eye(4)
    view[:3, :3] = np.stack([right, np.cross(back, right), back])
    view[:3, 3] = -view[:3, :3] @ np.asarray(eye, np.float64)
    f = 1.0 / math.tan(math.radians(fov_deg) / 2.0)
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = f / aspect, f
    projection[2, 2:] = (near + far) / (near - far), 2.0 * near * far / (near - far)
    projection[3, 2] = -1.0
    return Camera(view, projection)


def point_light(place: tuple[float, float, float], power: float = 100.0, **more: object) -> Light:
    return Light(LightKind.POINT, position=place, power=power, **more)  # type: ignore[arg-type]


def scene_of(
    mesh: MeshData,
    material: BladeMaterial,
    lights: tuple[Light, ...],
    matrix: np.ndarray | None = None,
    world: World | None = None,
) -> SceneData:
    instance = Instance("mesh", np.eye(4) if matrix is None else matrix, ("material",))
    return SceneData({"mesh": mesh}, (instance,), {"material": material}, lights, world or World())
