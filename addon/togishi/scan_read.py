"""Scanned meshes of the formats that Blender's own importers read for us (glTF), into arrays. What they bring into the
file is taken out again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .core import native

# The core reads these itself: Blender's importers take a minute for ten million triangles, round what lies far from
# zero, and make arrays as large as a header says.
BY_CORE = (".ply", ".obj", ".stl")
BY_BLENDER = (".glb", ".gltf")
SUFFIXES = (*BY_CORE, *BY_BLENDER)
FILTER = ";".join(f"*{suffix}" for suffix in SUFFIXES)


@dataclass
class ScanArrays:
    """A scan as the core takes it. Unit: the file's."""

    origin: NDArray[np.float64]  # (3,) a vertex lies at origin + positions[i]
    positions: NDArray[np.float32]  # (V, 3)
    triangles: NDArray[np.int32]  # (F, 3) counter-clockwise from outside
    colours: NDArray[np.uint8] | None  # (V, 4) sRGB and alpha


def _blocks() -> dict[str, set[Any]]:
    """All data blocks of the file, by kind."""
    return {
        p.identifier: set(getattr(bpy.data, p.identifier))
        for p in bpy.data.bl_rna.properties
        if p.type == "COLLECTION"
    }


def _remove_new(before: dict[str, set[Any]]) -> None:
    new = [block for kind, blocks in _blocks().items() for block in blocks - before[kind]]
    bpy.data.batch_remove(new)


def _values(mesh: bpy.types.Mesh, name: str, field: str, size: int, kind: Any) -> Any:
    values = np.empty(size, kind)
    mesh.attributes[name].data.foreach_get(field, values)
    return values


def _triangles(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    corners = len(mesh.loops)
    vertex = _values(mesh, ".corner_vert", "value", corners, np.int32)
    if corners == 3 * len(mesh.polygons):
        sizes = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("loop_total", sizes)
        if (sizes == 3).all():
            return vertex.reshape(-1, 3)
    mesh.calc_loop_triangles()
    loops = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("loops", loops)
    return vertex[loops].reshape(-1, 3)


def _display(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """sRGB's transfer function."""
    return np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * linear.clip(0.0) ** (1 / 2.4) - 0.055
    )


def _at_vertices(mesh: bpy.types.Mesh, corners: NDArray[np.float32]) -> NDArray[np.float32]:
    """The mean of the corners (C, 4), linear, that meet in each vertex, as display values."""
    vertex = _values(mesh, ".corner_vert", "value", len(mesh.loops), np.int32)
    count = len(mesh.vertices)
    meeting = np.bincount(vertex, minlength=count).clip(1)
    mixed = [np.bincount(vertex, corners[:, k], count) / meeting for k in range(4)]
    return np.stack([*(_display(c) for c in mixed[:3]), mixed[3]], axis=1).astype(np.float32)


def _colours(mesh: bpy.types.Mesh) -> NDArray[np.uint8] | None:
    """Per vertex, sRGB and alpha, from bytes or floats; None where the mesh has no colours."""
    found = mesh.color_attributes
    colours = found.active_color or next(iter(found), None)
    if colours is None:
        return None
    at_corners = colours.domain == "CORNER"
    values = np.empty(4 * (len(mesh.loops) if at_corners else len(mesh.vertices)), np.float32)
    colours.data.foreach_get("color" if at_corners else "color_srgb", values)
    values = values.reshape(-1, 4)
    if at_corners:
        values = _at_vertices(mesh, values)
    return np.rint((255.0 * values).clip(0.0, 255.0)).astype(np.uint8)


def _all_colours(meshes: list[bpy.types.Mesh]) -> NDArray[np.uint8] | None:
    """Of all meshes; white where one has none, None where none has any."""
    each = [_colours(mesh) for mesh in meshes]
    if all(colours is None for colours in each):
        return None
    return np.concatenate(
        [
            np.full((len(mesh.vertices), 4), 255, np.uint8) if colours is None else colours
            for mesh, colours in zip(meshes, each, strict=True)
        ]
    )


def _placed(obj: bpy.types.Object) -> NDArray[np.float64 | np.float32]:
    mesh = obj.data
    own = _values(mesh, "position", "vector", 3 * len(mesh.vertices), np.float32).reshape(-1, 3)
    matrix = np.array(obj.matrix_world, float)
    if np.array_equal(matrix, np.eye(4)):
        return own
    return own @ matrix[:3, :3].T + matrix[:3, 3]


def _gather(objects: list[bpy.types.Object]) -> ScanArrays:
    places = [_placed(obj) for obj in objects]
    low = np.min([p.min(axis=0) for p in places], axis=0).astype(float)
    high = np.max([p.max(axis=0) for p in places], axis=0).astype(float)
    origin = 0.5 * (low + high)
    if not np.isfinite(origin).all():
        origin = np.zeros(3)  # the core names the vertex that is at fault
    starts = np.cumsum([0, *(len(p) for p in places)])
    triangles = [
        _triangles(obj.data) + np.int32(start)
        for obj, start in zip(objects, starts[:-1], strict=True)
    ]
    return ScanArrays(
        origin,
        np.concatenate([(p - origin).astype(np.float32) for p in places]),
        np.concatenate(triangles),
        _all_colours([obj.data for obj in objects]),
    )


def by_blender(path: Path) -> bool:
    """Whether read() is needed for this file; the core reads the others itself. Raises togishi_core.InputError for
    other formats, OSError where the file cannot be opened."""
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise native.core().InputError(
            f"{path}: file = {path.suffix!r}; allowed: {', '.join(SUFFIXES)}"
        )
    with path.open("rb"):
        pass  # an OSError that names what is wrong with the path
    return kind in BY_BLENDER


def _reason(error: RuntimeError) -> str:
    """What Blender's importer says; of a Python traceback, which it hands on whole, its last line."""
    lines = [line.strip() for line in str(error).splitlines()]
    return next((line for line in reversed(lines) if line and "Location:" not in line), "no reason")


def read(path: Path) -> ScanArrays:
    """The meshes of a file, all together. Raises togishi_core.InputError, naming the file, for what no mesh can be
    read from."""
    core = native.core()
    problem = core.InputError
    core.check_gltf(path)
    before = _blocks()
    selected = [obj for obj in bpy.context.view_layer.objects if obj.select_get()]
    active = bpy.context.view_layer.objects.active
    try:
        try:
            bpy.ops.import_scene.gltf(filepath=str(path))
        except RuntimeError as error:
            raise problem(f"{path}: file: Blender could not read it: {_reason(error)}") from None
        objects = [
            obj
            for obj in bpy.data.objects
            if obj not in before["objects"] and obj.type == "MESH" and len(obj.data.polygons)
        ]
        if not objects:
            raise problem(f"{path}: file = no faces; allowed: a mesh of triangles or polygons")
        # World matrices of new objects are known after an update only.
        bpy.context.view_layer.update()
        return _gather(objects)
    finally:
        _remove_new(before)
        bpy.context.view_layer.update()
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in selected)
        bpy.context.view_layer.objects.active = active
