"""Blender's meshes as arrays for the GPU."""

from __future__ import annotations

import bpy
import numpy as np

from .. import blender_versions
from ..core.packing import build_mesh
from ..core.scene_data import MeshData

UV_NAME = "togishi_uv"


def _attribute(
    mesh: bpy.types.Mesh, name: str, domain: str, kind: str, field: str, width: int, dtype: type
) -> np.ndarray | None:
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.domain != domain or attribute.data_type != kind:
        return None
    values = np.empty(len(attribute.data) * width, dtype)
    attribute.data.foreach_get(field, values)
    return values.reshape(-1, width) if width > 1 else values


def _read(collection: object, field: str, count: int, dtype: type) -> np.ndarray:
    values = np.empty(count, dtype)
    collection.foreach_get(field, values)  # type: ignore[attr-defined]
    return values


def read_mesh(mesh: bpy.types.Mesh, blade_slots: frozenset[int]) -> MeshData:
    """An evaluated mesh. blade_slots: material slots that hold blade steel."""
    mesh.calc_loop_triangles()
    triangle_count, corner_count = len(mesh.loop_triangles), len(mesh.loops)
    uv_name = UV_NAME if UV_NAME in mesh.uv_layers else None
    if uv_name is None and mesh.uv_layers.active is not None:
        uv_name = mesh.uv_layers.active.name
    return build_mesh(
        position=_read(mesh.vertices, "co", len(mesh.vertices) * 3, np.float32).reshape(-1, 3),
        corner_vertex=_read(mesh.loops, "vertex_index", corner_count, np.int32),
        triangle_corners=_read(mesh.loop_triangles, "loops", triangle_count * 3, np.int32).reshape(
            -1, 3
        ),
        triangle_face=_read(mesh.loop_triangles, "polygon_index", triangle_count, np.int32),
        corner_normal=blender_versions.corner_normals(mesh),
        face_part=_attribute(mesh, "togishi_part", "FACE", "INT", "value", 1, np.int32),
        face_slot=_attribute(mesh, "material_index", "FACE", "INT", "value", 1, np.int32),
        corner_uv=None
        if uv_name is None
        else _attribute(mesh, uv_name, "CORNER", "FLOAT2", "vector", 2, np.float32),
        corner_tangent=_attribute(
            mesh, "togishi_tangent", "CORNER", "FLOAT_VECTOR", "vector", 3, np.float32
        ),
        blade_slots=blade_slots,
    )
