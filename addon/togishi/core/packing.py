"""Scene data as the bytes that the GPU programs read (shaders/viewport/interface.glsl).

Every block is std140 made of vec4 only, so it is a plain float32 array here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .pace import coarse_size
from .scene_data import (
    F32,
    F64,
    Camera,
    Instance,
    LampPicture,
    Light,
    LightKind,
    MapData,
    MeshData,
    MeshGroup,
    NormalMapData,
    PlainMaterial,
    SteelMaterial,
    World,
)
from .shader_source import (
    AREA_CAPACITY,
    ENVIRONMENT_LEVELS,
    LIGHT_CAPACITY,
    MAX_LEVELS,
    TABLE_ROWS,
    TABLE_SIZE,
    LightVariant,
)
from .surroundings import IRRADIANCE_SIZE, Atlas
from .tangents import turned_with_mesh, uv_tangents

I32 = NDArray[np.int32]

PART_JI = 1
PART_NAKAGO = 7

# --- camera -------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ViewSpace:
    """A camera as the programs use it: everything is in its own space."""

    view: F64  # (4, 4) world to view
    projection: F64  # (4, 4), jitter included
    ray: tuple[float, float, float, float]  # interface.glsl, TgFrame
    orthographic: bool


def view_space(
    camera: Camera, size: tuple[int, int], jitter: tuple[float, float] = (0.0, 0.0)
) -> ViewSpace:
    """jitter: shift of the picture in pixels, for subpixel samples."""
    projection = np.array(camera.projection, np.float64)
    projection[0] += projection[3] * (2.0 * jitter[0] / size[0])
    projection[1] += projection[3] * (2.0 * jitter[1] / size[1])
    scale, offset = [], []
    for axis in (0, 1):
        # clip = p[a][a] x + p[a][2] z + p[a][3] with x = ray depth, z = -depth, and ndc = clip/depth or clip.
        shift = -projection[axis, 2] if not camera.orthographic else projection[axis, 3]
        scale.append(float(2.0 / (size[axis] * projection[axis, axis])))
        offset.append(float((-1.0 - shift) / projection[axis, axis]))
    return ViewSpace(
        view=np.asarray(camera.view, np.float64),
        projection=projection,
        ray=(scale[0], scale[1], offset[0], offset[1]),
        orthographic=camera.orthographic,
    )


def coarse_camera(camera: Camera, size: tuple[int, int], step: int) -> Camera:
    """The camera of a picture of `size` pixels for one whose pixels are `step` times as wide: where they do not fit
    into it, the last ones reach beyond the right and upper border."""
    projection = np.array(camera.projection, np.float64)
    coarse = coarse_size(size, step)
    for axis in (0, 1):
        share = size[axis] / (coarse[axis] * step)
        # clip' = share (clip + w) - w: the left and lower border stay.
        projection[axis] = share * (projection[axis] + projection[3]) - projection[3]
    return Camera(camera.view, projection)


def frame_block(
    camera: ViewSpace,
    world_rgb: Sequence[float],
    world_row: int,
    counts: LightCounts,
    lod_bias: float,
    slices: int = 0,
    pixel: float = 1.0,
    series: tuple[int, int] = (0, 1),
    rays: tuple[int, int] = (0, 0),
) -> F32:
    """TgFrame. slices: of the lobe for each lamp of a size; pixel: width of what a sample stands for, in pixels;
    series: number of this sample, of how many; rays: to each lamp of a size from a matt surface, number of the first."""
    block = np.zeros((9, 4), np.float32)
    block[0:4] = camera.projection.T  # columns
    block[4] = camera.ray
    block[5] = (float(camera.orthographic), counts.areas, slices, pixel)
    block[6] = (*world_rgb, world_row)
    block[7] = (counts.points, counts.spots, counts.suns, lod_bias)
    block[8] = (*series, *rays)
    return block


def model_rows(matrix: F64, camera: ViewSpace) -> tuple[list[list[float]], float]:
    """Three rows of object to view space, and -1 where the object's matrix mirrors, else 1."""
    rows = camera.view @ matrix
    mirrored = float(np.linalg.det(rows[:3, :3])) < 0.0
    return rows[:3].tolist(), -1.0 if mirrored else 1.0


def box_corners(low: F32, high: F32) -> F64:
    """(8, 4): the corners of a box, with 1 as their fourth coordinate."""
    return np.array(
        [
            (x, y, z, 1.0)
            for x in (low[0], high[0])
            for y in (low[1], high[1])
            for z in (low[2], high[2])
        ],
        np.float64,
    )


def screen_rect(
    bounds: Sequence[tuple[F32, F32, F64]], camera: ViewSpace
) -> tuple[float, float, float, float] | None:
    """Left, bottom, right, top in clip space that hold boxes (low, high, matrix); None: nothing in sight."""
    left, bottom, right, top = 1.0, 1.0, -1.0, -1.0
    for low, high, matrix in bounds:
        clip = box_corners(low, high) @ (camera.projection @ camera.view @ matrix).T
        if (clip[:, 3] <= 1e-6 * np.abs(clip).max()).any():
            return (-1.0, -1.0, 1.0, 1.0)  # through the viewer's plane
        x, y = clip[:, 0] / clip[:, 3], clip[:, 1] / clip[:, 3]
        left, right = min(left, float(x.min())), max(right, float(x.max()))
        bottom, top = min(bottom, float(y.min())), max(top, float(y.max()))
    # A pixel and more to each side: rounding must not cut an edge.
    rect = (
        max(left - 0.01, -1.0),
        max(bottom - 0.01, -1.0),
        min(right + 0.01, 1.0),
        min(top + 0.01, 1.0),
    )
    return rect if rect[0] < rect[2] and rect[1] < rect[3] else None


# --- lights -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class LightCounts:
    """Lamps of one pass by kind."""

    points: int = 0
    spots: int = 0
    suns: int = 0
    areas: int = 0  # of a size, whatever their kind


@dataclass(frozen=True)
class LightPass:
    """Lamps that one pass over the picture adds up, points first, then spots, then suns; apart, those of a size."""

    lights: tuple[Light, ...]
    counts: LightCounts
    spectra: tuple[str, ...]  # rows of the tables
    areas: tuple[Light, ...] = ()


_ORDER = {LightKind.POINT: 0, LightKind.SPOT: 1, LightKind.SUN: 2}


def light_passes(lights: Sequence[Light], world: World) -> list[LightPass]:
    """All lamps that give light, in as few passes as the blocks' sizes allow; at least one pass. An HDRI's bright spots
    are lamps too.

    The world's spectrum has a row in the first pass where the world is not black.
    """
    ordered = sorted(
        (light for light in (*lights, *spot_lights(world)) if not light.dark),
        key=lambda x: (x.sized, 0 if x.sized else _ORDER[x.kind]),
    )
    passes: list[LightPass] = []
    current: list[Light] = []
    spectra: list[str] = [] if world.black else [world.spectrum]

    def close() -> None:
        points = tuple(light for light in current if not light.sized)
        areas = tuple(light for light in current if light.sized)
        count = {kind: sum(1 for x in points if x.kind is kind) for kind in _ORDER}
        counts = LightCounts(
            count[LightKind.POINT], count[LightKind.SPOT], count[LightKind.SUN], len(areas)
        )
        passes.append(LightPass(points, counts, tuple(spectra), areas))
        current.clear()
        spectra.clear()

    for light in ordered:
        new_row = light.spectrum not in spectra
        full = len(current) == LIGHT_CAPACITY or (
            light.sized and sum(x.sized for x in current) == AREA_CAPACITY
        )
        if full or (new_row and len(spectra) == TABLE_ROWS):
            close()
            new_row = True
        if new_row:
            spectra.append(light.spectrum)
        current.append(light)
    if current or not passes:
        close()
    return passes


def spot_lights(world: World) -> list[Light]:
    """Suns in place of an HDRI's bright spots."""
    if world.environment is None or world.black:
        return []
    from_picture = np.asarray(world.turn, np.float64).T
    lights = []
    for spot in world.environment.spots:
        irradiance = np.asarray(spot.irradiance) * np.asarray(world.radiance)
        power = float(irradiance.max())
        if power > 0.0:
            lights.append(
                Light(
                    LightKind.SUN,
                    to_light=tuple((from_picture @ np.asarray(spot.direction)).tolist()),
                    power=power,
                    colour=tuple((irradiance / power).tolist()),
                    spectrum=world.spectrum,
                    half_angle_rad=spot.half_angle_rad,
                    shadows=True,
                )
            )
    return lights


def environment_block(world: World, atlas: Atlas, camera: ViewSpace) -> F32:
    """TgEnvironment."""
    block = np.zeros((5 + ENVIRONMENT_LEVELS, 4), np.float32)
    block[0:3, :3] = np.asarray(world.turn, np.float64) @ camera.view[:3, :3].T
    block[3] = (1.0 / atlas.width, 1.0 / atlas.height, len(atlas.levels), atlas.texel_rad)
    block[4] = (*atlas.irradiance, *IRRADIANCE_SIZE)
    for i, level in enumerate(atlas.levels):
        block[5 + i] = (level.x, level.y, level.width, level.height)
    return block


def light_variant(passes: Sequence[LightPass], world: World, *, fine: bool = True) -> LightVariant:
    """One variant for all passes: passes must rasterise alike. fine: for lamps of a size, the picture at rest."""
    kinds = {light.kind for p in passes for light in p.areas}
    rounds = bool(kinds - {LightKind.RECTANGLE})
    return LightVariant(
        points=any(p.counts.points for p in passes),
        spots=any(p.counts.spots for p in passes),
        suns=any(p.counts.suns for p in passes),
        world=not world.black and world.environment is None,
        environment=not world.black and world.environment is not None,
        rectangles=LightKind.RECTANGLE in kinds,
        rounds=rounds,
        pictures=any(light.picture is not None for p in passes for light in p.areas),
        # Rectangles gain nothing by it (docs/light.md).
        fine=fine and rounds,
    )


def lights_block(light_pass: LightPass, camera: ViewSpace) -> F32:
    """TgLights."""
    block = np.zeros((LIGHT_CAPACITY, 2, 4), np.float32)
    for i, light in enumerate(light_pass.lights):
        block[i, 0, :3] = _place(light, camera)
        block[i, 0, 3] = float(light.shadows)
        block[i, 1] = _colour(light, light_pass)
    return block


def _place(light: Light, camera: ViewSpace) -> F64:
    """In view space: position; of a sun the unit vector to it."""
    if light.kind is LightKind.SUN:
        to_light: F64 = camera.view[:3, :3] @ np.asarray(light.to_light, np.float64)
        return to_light / max(float(np.linalg.norm(to_light)), 1e-30)
    place: F64 = camera.view[:3] @ np.asarray((*light.position, 1.0), np.float64)
    return place


def _colour(light: Light, light_pass: LightPass) -> F64:
    colour = np.empty(4)
    colour[:3] = np.minimum(np.asarray(light.colour, np.float64) * light.power, 1.0e30)
    colour[3] = light_pass.spectra.index(light.spectrum)
    return colour


def areas_block(
    light_pass: LightPass,
    camera: ViewSpace,
    pictures: Sequence[LampPicture] = (),
    things: Sequence[Instance] = (),
) -> F32:
    """TgAreas. pictures, and things that hide lamps: in the order of their numbers."""
    thing_numbers = {id(thing): number + 1 for number, thing in enumerate(things)}
    numbers = {id(picture): number + 1 for number, picture in enumerate(pictures)}
    block = np.zeros((AREA_CAPACITY, 6, 4), np.float32)
    for i, light in enumerate(light_pass.areas):
        block[i, 0, :3] = _place(light, camera)
        block[i, 0, 3] = _AREA_KIND[light.kind]
        block[i, 4, 3] = float(light.shadows)
        block[i, 1] = _colour(light, light_pass)
        axes = camera.view[:3, :3] @ np.array([light.x_axis, light.y_axis, light.z_axis]).T
        if light.kind is LightKind.SUN:
            block[i, 5, 0] = light.half_angle_rad
        elif light.kind in {LightKind.POINT, LightKind.SPOT}:
            block[i, 5] = (
                light.radius,
                float(light.soft_falloff),
                light.blend,
                math.cos(0.5 * light.cone_rad),
            )
            block[i, 2:5, :3] = (axes * (1.0, 1.0, -1.0)).T
        else:
            # It shines towards u x v, Blender's along -z.
            block[i, 2, :3], block[i, 3, :3] = axes[:, 0], -axes[:, 1]
            block[i, 2, 3] = numbers.get(id(light.picture), 0)
            block[i, 3, 3] = thing_numbers.get(id(light.thing), 0)
            block[i, 5] = (light.half_u, light.half_v, *_spread(light.spread_rad))
    return block


# interface.glsl, TgArea
_AREA_KIND = {
    LightKind.RECTANGLE: 0,
    LightKind.ELLIPSE: 1,
    LightKind.POINT: 2,
    LightKind.SPOT: 3,
    LightKind.SUN: 4,
}


def _spread(spread_rad: float) -> tuple[float, float]:
    """Tangent of half the spread, 0 for all directions; 1/(that less the angle), which keeps the power."""
    half = 0.5 * min(max(spread_rad, math.radians(1.0)), math.pi)
    if half > math.radians(89.9):
        return 0.0, 0.0
    return math.tan(half), 1.0 / (math.tan(half) - half)


def spots_block(light_pass: LightPass, camera: ViewSpace) -> F32:
    """TgSpots."""
    block = np.zeros((LIGHT_CAPACITY, 3, 4), np.float32)
    spots = [light for light in light_pass.lights if light.kind is LightKind.SPOT]
    for i, light in enumerate(spots):
        axes = camera.view[:3, :3] @ np.array([light.x_axis, light.y_axis, light.z_axis]).T
        block[i, 0] = (*axes[:, 0], light.blend)
        block[i, 1] = (*axes[:, 1], math.cos(0.5 * light.cone_rad))
        # in_lamp.z of the shader is the cosine to the way the lamp shines, which is -z.
        block[i, 2, :3] = -axes[:, 2]
    return block


# --- materials ----------------------------------------------------------------------------------


def steel_block(material: SteelMaterial) -> F32:
    """TgSteel."""
    block = np.zeros((21 + MAX_LEVELS, 4), np.float32)
    for part in range(8):
        lobe, weight = material.part_lobes[part], material.part_weights[part]
        block[part] = (*lobe, weight)
        # Where a map gives w, the ji under a ha or boshi face is the ji's.
        smooth = PART_JI if material.part_rough[part] else part
        block[8 + part] = (*material.part_lobes[smooth], material.part_weights[smooth])
    block[16] = material.ha
    block[17] = material.hadori
    block[18:20] = np.asarray(material.part_rough, np.float32).reshape(2, 4)
    if material.maps is not None:
        height, width = material.maps.lobes.shape[:2]
        levels = material.maps.levels[:MAX_LEVELS]
        block[20, :3] = (1.0 / width, 1.0 / height, len(levels))
        block[21 : 21 + len(levels)] = levels
    return block


def normal_map_block(maps: NormalMapData) -> F32:
    """TgNormalMap."""
    block = np.zeros((1 + MAX_LEVELS, 4), np.float32)
    height, width = maps.leans.shape[:2]
    levels = maps.levels[:MAX_LEVELS]
    block[0, :3] = (1.0 / width, 1.0 / height, len(levels))
    block[1 : 1 + len(levels)] = levels
    return block


def plain_block(material: PlainMaterial, picture: int = 0) -> F32:
    """TgPlain. picture: number of its own, from 1."""
    block = np.zeros((3, 4), np.float32)
    block[2] = (*material.shine, picture)
    block[0] = (*material.albedo, material.ior)
    block[1, :2] = (material.gloss_ln_mu_deg, material.metallic)
    return block


def table_block(rows: Sequence[F32]) -> F32:
    """TgTable from rows of (TABLE_SIZE, 3)."""
    block = np.zeros((TABLE_ROWS, TABLE_SIZE, 4), np.float32)
    for i, row in enumerate(rows):
        block[i, :, :3] = row
    return block


# --- maps ---------------------------------------------------------------------------------------

# The bits of a half float without its sign: they order as the magnitudes do, and integers compare faster.
_MAGNITUDE = np.uint16(0x7FFF)
_SHAPE_BITS = np.float16(1e-3).view(np.uint16)


def map_data(lobes: NDArray[np.float16], shape: NDArray[np.float16] | None, levels: I32) -> MapData:
    """Atlases as togishi_core.pack_mip_atlas repaired them, and what of them a shader needs. What is finite but
    outside the model's range the shared formulas bring into it."""
    x, y, width, height = (int(v) for v in levels[0])
    level0 = (slice(y, y + height), slice(x, x + width))
    return MapData(
        lobes=lobes,
        shape=shape,
        levels=np.asarray(levels, np.int32),
        hadori=bool((lobes[(*level0, 3)] > 0.0).any()),
        anisotropic=shape is not None
        and bool(((shape[level0].view(np.uint16) & _MAGNITUDE) > _SHAPE_BITS).any()),
    )


def _cut(levels: I32, size: tuple[int, ...], largest: int) -> tuple[tuple[slice, slice], I32]:
    """Rows and columns of an atlas that its finest levels, as many as fit, and their border of one texel cover so that
    no side is above `largest` texels; those levels in that part."""
    for first in range(len(levels)):
        left, bottom = (levels[first:, :2].min(axis=0) - 1).clip(0)
        right, top = (levels[first:, :2] + levels[first:, 2:]).max(axis=0) + 1
        if first == 0:
            left, bottom = 0, 0
            top, right = size[:2]
        if max(right - left, top - bottom) <= largest:
            part = (slice(bottom, top), slice(left, right))
            return part, levels[first:] - np.asarray((left, bottom, 0, 0), np.int32)
    raise ValueError(f"largest texture is {largest} texels; allowed: 3 or more")


def coarser_maps(maps: MapData, largest: int) -> MapData:
    """The same maps without their finest levels, so that no side of an atlas is above `largest` texels."""
    part, levels = _cut(maps.levels, maps.lobes.shape, largest)
    return MapData(
        lobes=np.ascontiguousarray(maps.lobes[part]),
        shape=None if maps.shape is None else np.ascontiguousarray(maps.shape[part]),
        levels=levels,
        hadori=maps.hadori,
        anisotropic=maps.anisotropic,
    )


def coarser_normal_map(maps: NormalMapData, largest: int) -> NormalMapData:
    """As coarser_maps."""
    part, levels = _cut(maps.levels, maps.leans.shape, largest)
    return NormalMapData(
        leans=np.ascontiguousarray(maps.leans[part]),
        correlations=np.ascontiguousarray(maps.correlations[part]),
        levels=levels,
    )


# --- meshes -------------------------------------------------------------------------------------


def _merge_key(columns: Sequence[NDArray[np.uint32]]) -> NDArray[np.uint64]:
    """64-bit mix of the bit patterns of a corner's attributes: equal corners have equal keys."""
    key = np.full(len(columns[0]), 0x9E3779B97F4A7C15, np.uint64)
    with np.errstate(over="ignore"):
        for column in columns:
            key ^= column.astype(np.uint64)
            key *= np.uint64(0xBF58476D1CE4E5B9)
            key ^= key >> np.uint64(29)
    return key


def _fill_degenerate(normal: F32) -> F32:
    """Normals that are zero or not finite become +z; the rest is left as it is."""
    good = np.isfinite(normal).all(axis=1) & (np.abs(normal).max(axis=1, initial=0.0) > 0.0)
    if good.all():
        return normal
    return np.where(good[:, None], normal, np.asarray((0.0, 0.0, 1.0), np.float32))


def _rounded(vectors: F32, steps: float) -> list[NDArray[np.uint32]]:
    """Columns of unit vectors in steps of 1/steps, as bit patterns."""
    whole = np.rint(np.clip(vectors, -2.0, 2.0) * np.float32(steps)).astype(np.int32)
    return [np.ascontiguousarray(whole[:, i]).view(np.uint32) for i in range(vectors.shape[1])]


def _mean(normal: F32, group: NDArray[np.integer[Any]], count: int) -> F32:
    """(count, 3) unit mean of the normals of each group."""
    total = np.stack([np.bincount(group, normal[:, i], count) for i in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    mean: F32 = (total / np.maximum(length, 1e-30)).astype(np.float32)
    return mean


def is_closed(position: F32, triangles: NDArray[np.int64]) -> bool:
    """Whether triangles (T, 3) of vertices (V, 3) are the skin of a volume seen from outside: every edge has two of
    them, wound alike, and the volume is above 0."""
    a = triangles.reshape(-1)
    b = np.roll(triangles, -1, axis=1).reshape(-1)
    count = np.int64(len(position))
    there, back = np.sort(a * count + b), np.sort(b * count + a)
    if (there[1:] == there[:-1]).any() or not np.array_equal(there, back):
        return False
    with np.errstate(invalid="ignore"):  # vertices that are no places have no volume
        p = position.astype(np.float64)
        p -= p.mean(axis=0)
        corner = p[triangles]
        volume = np.einsum("ij,ij->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2]))
    return bool(volume > 0.0)


def build_mesh(
    position: F32,
    corner_vertex: NDArray[np.int32],
    triangle_corners: NDArray[np.int32],
    triangle_face: NDArray[np.int32],
    corner_normal: F32,
    face_part: NDArray[np.integer[Any]] | None,
    face_slot: NDArray[np.integer[Any]] | None,
    corner_uv: F32 | None,
    corner_tangent: F32 | None,
    blade_slots: frozenset[int] = frozenset(),
) -> MeshData:
    """A mesh for the GPU from Blender's arrays.

    position (V, 3); corner_vertex (C,); triangle_corners (T, 3) into the corners; triangle_face (T,);
    corner_normal, corner_tangent (C, 3); corner_uv (C, 2); face_part, face_slot (F,). Vertices are
    corners, those that agree in everything merged. Faces without a part are ji (the blade has one
    part then). blade_slots: material slots whose nakago faces are drawn with the plain program.
    """
    triangles = np.asarray(triangle_corners, np.int64)
    if not len(triangles):
        empty = np.zeros((0, 3), np.float32)
        return MeshData(empty, np.zeros((0, 4), np.float32), None, None, ())
    corner_count = len(corner_vertex)
    part = np.full(corner_count, PART_JI, np.float32)
    triangle_part = np.full(len(triangles), PART_JI, np.int64)
    if face_part is not None:
        triangle_part = np.clip(np.asarray(face_part, np.int64)[triangle_face], 0, 7)
        part[triangles] = triangle_part[:, None]
    normal = _fill_degenerate(np.asarray(corner_normal, np.float32))
    # Blender keeps custom normals in so few bits that the corners of one vertex differ: normals that agree
    # to a ninth of a degree are one normal, their mean.
    columns = [np.asarray(corner_vertex).astype(np.uint32), part.view(np.uint32)]
    columns += _rounded(normal, 512.0)
    if corner_uv is not None:
        corner_uv = np.nan_to_num(np.asarray(corner_uv, np.float32), posinf=0.0, neginf=0.0)
        columns += [np.ascontiguousarray(corner_uv[:, i]).view(np.uint32) for i in range(2)]
    if corner_tangent is not None:
        corner_tangent = np.nan_to_num(
            np.asarray(corner_tangent, np.float32), posinf=0.0, neginf=0.0
        )
        columns += _rounded(corner_tangent, 256.0)
    _, first, inverse = np.unique(_merge_key(columns), return_index=True, return_inverse=True)
    # In the order of the mesh rather than of the keys, which the vertex cache likes.
    order = np.argsort(first, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    first = first[order]
    vertex_of_corner = rank[inverse.reshape(-1)]
    merged = vertex_of_corner[triangles]
    normal = _mean(normal, vertex_of_corner, len(first))
    points = np.nan_to_num(np.asarray(position, np.float32)[np.asarray(corner_vertex)[first]])
    uv = None if corner_uv is None else np.ascontiguousarray(corner_uv[first])
    tangent = None if uv is None else uv_tangents(points, uv, merged)
    if corner_tangent is not None:
        own = np.ascontiguousarray(corner_tangent[first])
        tangent = own if tangent is None else turned_with_mesh(own, tangent)
    slots = (
        np.zeros(len(triangles), np.int64)
        if face_slot is None
        else np.maximum(np.asarray(face_slot, np.int64)[triangle_face], 0)
    )
    nakago = (triangle_part == PART_NAKAGO) & np.isin(slots, list(blade_slots))
    groups = []
    for slot in np.unique(slots):
        for is_nakago in (False, True):
            chosen = (slots == slot) & (nakago == is_nakago)
            if chosen.any():
                groups.append(
                    MeshGroup(int(slot), is_nakago, np.ascontiguousarray(merged[chosen], np.uint32))
                )
    return MeshData(
        position=np.ascontiguousarray(points),
        normal_part=np.concatenate([normal, part[first, None]], axis=1),
        uv=uv,
        tangent=tangent,
        groups=tuple(groups),
        # Asked for steel alone: sorting the edges of a large stand takes longer than drawing it.
        closed=bool(blade_slots)
        and is_closed(np.asarray(position), np.asarray(corner_vertex, np.int64)[triangles]),
    )
