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
from togishi.core import packing
from togishi.core.scene_data import (
    BladeMaterial,
    Camera,
    ColourSettings,
    Instance,
    Light,
    LightKind,
    MapData,
    MeshData,
    MeshGroup,
    PlainMaterial,
    SceneData,
    SteelMaterial,
    World,
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
    room: float = 0.0,
    space: str = "rec709",
) -> tuple[SceneData, Camera, tuple[int, int]]:
    """Columns: metals; rows: LOBES. One light, and a room of this radiance under the same spectrum."""
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
        world=World((room,) * 3, spectrum),
        colour=ColourSettings(space=space),
    )
    return scene, *wall_camera(len(metals), len(LOBES))


# --- a blade --------------------------------------------------------------------------------------


def look_at(
    eye: np.ndarray, target: np.ndarray, up: np.ndarray, half_angle_deg: float, aspect: float
) -> Camera:
    """Perspective; half_angle_deg: half the picture's width."""
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(back, right), back])
    view = np.eye(4)
    view[:3, :3] = rotation
    view[:3, 3] = -rotation @ eye
    scale = 1 / math.tan(math.radians(half_angle_deg))
    near, far = 0.01, 100.0
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = scale, scale * aspect
    projection[2, 2] = -(far + near) / (far - near)
    projection[2, 3] = -2 * far * near / (far - near)
    projection[3, 2] = -1.0
    return Camera(view, projection)


def blade_mesh(**dimensions: object) -> MeshData:
    """The generated katana in metres, as the add-on hands it to the renderer. dimensions: other than the default ones."""
    blade = togishi_core.katana({**togishi_core.katana_defaults(), **dimensions})
    counts = np.diff(blade.face_start)
    triangles, faces = [], []
    for offset in (0, 1):
        # A quad gives (0, 1, 2) and (0, 2, 3), a triangle the first alone.
        face = np.flatnonzero(counts > 2 + offset)
        first = blade.face_start[face]
        triangles.append(np.column_stack([first, first + 1 + offset, first + 2 + offset]))
        faces.append(face)
    return packing.build_mesh(
        (blade.positions_mm / 1000).astype(np.float32),
        blade.corner_vertex,
        np.concatenate(triangles).astype(np.int32),
        np.concatenate(faces).astype(np.int32),
        blade.corner_normal,
        blade.face_part,
        None,
        blade.corner_uv,
        blade.corner_tangent,
        frozenset({0}),
    )


def blade_maps(width: int, height: int) -> MapData:
    """Hamon, hada, hadori and strokes of the default blade at this size."""
    channels = togishi_core.steel_pattern(
        togishi_core.katana_defaults(),
        togishi_core.default_material(),
        togishi_core.steel_defaults(),
        width,
        height,
    )

    def plane(name: str) -> np.ndarray:
        return np.broadcast_to(channels.get(name, np.zeros((1, 1), np.float32)), (height, width))

    lobes = np.stack([plane(n) for n in ("ji.ln_mu_deg", "ha.ln_mu_deg", "w", "h")], axis=-1)
    shape = np.stack([plane(n) for n in ("ji.e1", "ji.e2", "ha.e1", "ha.e2")], axis=-1)
    anisotropic = bool(np.abs(shape).max() > 0)
    return packing.map_data(
        *togishi_core.pack_mip_atlas(
            np.ascontiguousarray(lobes), np.ascontiguousarray(shape) if anisotropic else None
        )
    )


def blade_scene(size: tuple[int, int]) -> tuple[SceneData, Camera, tuple[int, int]]:
    """A close view of the blade's middle with its maps. Nine lamps, each where some point of the blade mirrors it into
    the camera, so that most of the blade shines."""
    from togishi.core import materials

    material = materials.blade_material(togishi_core.default_material(), blade_maps(2048, 256))
    middle = np.array([0.3, 0.0, 0.0])
    eye = middle + np.array([0.05, 1.0, 0.12])
    mesh = blade_mesh()
    place = mesh.position.astype(np.float64)
    normal = mesh.normal_part[:, :3].astype(np.float64)
    seen = (np.abs(place[:, 0] - middle[0]) < 0.045) & (normal[:, 1] > 0.3)
    assert seen.sum() >= 9, "the blade's middle has vertices on the side that is seen"
    centre = (place[seen].min(axis=0) + place[seen].max(axis=0)) / 2
    camera = look_at(eye, centre, np.array([0.0, 0.0, 1.0]), 1.6, size[0] / size[1])
    chosen = np.flatnonzero(seen)[np.linspace(0, seen.sum() - 1, 9).astype(int)]
    spectra = ("D65", "A", "FL11")
    lamps = []
    for number, vertex in enumerate(chosen):
        view = eye - place[vertex]
        view /= np.linalg.norm(view)
        towards = 2 * np.dot(normal[vertex], view) * normal[vertex] - view
        lamp = place[vertex] + 1.5 * towards
        lamps.append(
            Light(
                LightKind.POINT,
                position=tuple(lamp.tolist()),
                power=10.0,
                spectrum=spectra[number % len(spectra)],
            )
        )
    scene = SceneData(
        meshes={"blade": mesh},
        materials={"steel": material},
        instances=(Instance("blade", np.eye(4), ("steel",)),),
        lights=tuple(lamps),
    )
    return scene, camera, size
