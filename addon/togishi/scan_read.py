"""Scanned meshes read by Blender's own importers, into arrays. What they bring into the file is taken out again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .core import native

# The file's own axes are kept: a scan has no up.
_IMPORTERS: dict[str, tuple[str, str, dict[str, Any]]] = {
    ".ply": ("wm", "ply_import", {"forward_axis": "Y", "up_axis": "Z", "import_colors": "SRGB"}),
    ".stl": ("wm", "stl_import", {"forward_axis": "Y", "up_axis": "Z", "use_mesh_validate": False}),
    ".obj": ("wm", "obj_import", {"forward_axis": "Y", "up_axis": "Z", "validate_meshes": False}),
    ".glb": ("import_scene", "gltf", {}),
    ".gltf": ("import_scene", "gltf", {}),
}
SUFFIXES = tuple(_IMPORTERS)
FILTER = ";".join(f"*{suffix}" for suffix in SUFFIXES)


@dataclass
class ScanArrays:
    """A scan as the core takes it. Unit: the file's."""

    origin: NDArray[np.float64]  # (3,) a vertex lies at origin + positions[i]
    positions: NDArray[np.float32]  # (V, 3)
    triangles: NDArray[np.int32]  # (F, 3) counter-clockwise from outside
    colours: NDArray[np.uint8] | None  # (V, 4) sRGB and alpha

    @property
    def reach(self) -> float:
        """The largest coordinate in the file: what single precision rounds."""
        return float(np.abs(self.origin).max()) + float(np.abs(self.positions).max(initial=0.0))


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


def _colours(mesh: bpy.types.Mesh) -> NDArray[np.uint8] | None:
    colours = mesh.color_attributes.active_color
    if colours is None or colours.domain != "POINT":
        return None
    values = np.empty(4 * len(mesh.vertices), np.float32)
    colours.data.foreach_get("color_srgb", values)
    values *= 255.0
    return np.rint(values.clip(0.0, 255.0)).astype(np.uint8).reshape(-1, 4)


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
    colours = [_colours(obj.data) for obj in objects]
    return ScanArrays(
        origin,
        np.concatenate([(p - origin).astype(np.float32) for p in places]),
        np.concatenate(triangles),
        None
        if any(c is None for c in colours)
        else np.concatenate([c for c in colours if c is not None]),
    )


def read(path: Path) -> ScanArrays:
    """The meshes of a file, all together. Raises togishi_core.InputError, naming the file, for what no mesh can be
    read from."""
    problem = native.core().InputError
    kind = path.suffix.lower()
    if kind not in _IMPORTERS:
        raise problem(f"{path}: file = {path.suffix!r}; allowed: {', '.join(SUFFIXES)}")
    with path.open("rb"):
        pass  # an OSError that names what is wrong with the path, before Blender tries
    module, name, settings = _IMPORTERS[kind]
    before = _blocks()
    selected = [obj for obj in bpy.context.view_layer.objects if obj.select_get()]
    active = bpy.context.view_layer.objects.active
    try:
        try:
            getattr(getattr(bpy.ops, module), name)(filepath=str(path), **settings)
        except RuntimeError as error:
            raise problem(
                f"{path}: file: Blender could not read it: {str(error).strip()}"
            ) from None
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
