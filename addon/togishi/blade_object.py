"""A generated katana as a Blender object: mesh, attributes, custom normals, material and recipe."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from . import blender_versions, properties
from .core import native, tangents

UV_MAP = "togishi_uv"
MM = 1.0e-3


def _attribute(
    mesh: bpy.types.Mesh, name: str, kind: str, domain: str, field: str, values: Any
) -> None:
    attribute = mesh.attributes.new(name, kind, domain)
    attribute.data.foreach_set(field, np.ascontiguousarray(values).reshape(-1))


def fill_mesh(mesh: bpy.types.Mesh, katana: Any, unit_m: float = 1.0) -> None:
    """Write a togishi_core.Katana into an empty mesh. unit_m: metres per scene unit."""
    scale = MM / unit_m
    corners = len(katana.corner_vertex)
    faces = len(katana.face_part)
    mesh.vertices.add(len(katana.positions_mm))
    mesh.vertices.foreach_set("co", (katana.positions_mm * scale).astype(np.float32).reshape(-1))
    mesh.loops.add(corners)
    mesh.loops.foreach_set("vertex_index", np.asarray(katana.corner_vertex, np.int32))
    mesh.polygons.add(faces)
    mesh.polygons.foreach_set("loop_start", np.asarray(katana.face_start[:-1], np.int32))
    mesh.update(calc_edges=True)
    uv = mesh.uv_layers.new(name=UV_MAP, do_init=False)
    uv.uv.foreach_set("vector", np.ascontiguousarray(katana.corner_uv, np.float32).reshape(-1))
    _attribute(mesh, "togishi_part", "INT", "FACE", "value", katana.face_part.astype(np.int32))
    _attribute(
        mesh,
        "togishi_tangent",
        "FLOAT_VECTOR",
        "CORNER",
        "vector",
        katana.corner_tangent.astype(np.float32),
    )
    _attribute(mesh, "togishi_s_mm", "FLOAT", "POINT", "value", katana.s_mm.astype(np.float32))
    _attribute(mesh, "togishi_t_mm", "FLOAT", "POINT", "value", katana.t_mm.astype(np.float32))
    mark_ridges(mesh, np.asarray(katana.corner_normal, np.float32))
    blender_versions.set_corner_normals(mesh, katana.corner_normal)
    mesh.update()


RIDGE_COSINE = math.cos(math.radians(2.0))


def mark_ridges(mesh: bpy.types.Mesh, normal: NDArray[np.float32]) -> None:
    """Mark edges as sharp where the corner normals (C, 3) of their two faces part by more than 2 degrees. Cycles mixes
    custom normals over edges that are not: shinogi and yokote would be blurred."""
    corners, edges = len(mesh.loops), len(mesh.edges)
    edge, vertex = np.empty(corners, np.int32), np.empty(corners, np.int32)
    mesh.loops.foreach_get("edge_index", edge)
    mesh.loops.foreach_get("vertex_index", vertex)
    start, total = np.empty((2, len(mesh.polygons)), np.int32)
    mesh.polygons.foreach_get("loop_start", start)
    mesh.polygons.foreach_get("loop_total", total)
    following = np.arange(1, corners + 1, dtype=np.int32)
    following[start + total - 1] = start
    order = np.argsort(edge, kind="stable")
    count = np.bincount(edge, minlength=edges)
    first = np.cumsum(count) - count
    pair = count == 2
    a, b = order[first[pair]], order[first[pair] + 1]
    # The corner of b at a's vertex, and the one at the edge's other end.
    same = vertex[a] == vertex[b]
    here, there = np.where(same, b, following[b]), np.where(same, following[b], b)
    cosine = np.minimum(
        (normal[a] * normal[here]).sum(axis=1), (normal[following[a]] * normal[there]).sum(axis=1)
    )
    sharp = np.zeros(edges, bool)
    sharp[pair] = cosine < RIDGE_COSINE
    attribute = mesh.attributes.get("sharp_edge") or mesh.attributes.new(
        "sharp_edge", "BOOLEAN", "EDGE"
    )
    attribute.data.foreach_set("value", sharp)


def _face_values(mesh: bpy.types.Mesh, name: str) -> NDArray[np.int32] | None:
    attribute = mesh.attributes.get(name)
    if attribute is None or (attribute.domain, attribute.data_type) != ("FACE", "INT"):
        return None
    values = np.empty(len(mesh.polygons), np.int32)
    attribute.data.foreach_get("value", values)
    return values


def slot_of_part(mesh: bpy.types.Mesh) -> dict[int, int]:
    """The material slot that most faces of each part have."""
    parts, slots = _face_values(mesh, "togishi_part"), _face_values(mesh, "material_index")
    if parts is None or slots is None:
        return {}
    return {
        int(part): int(np.bincount(slots[parts == part].clip(min=0)).argmax())
        for part in np.unique(parts)
    }


def turn_tangents(mesh: bpy.types.Mesh) -> None:
    """Where a rotation was applied to the mesh, its stroke directions follow; see core/tangents.py."""
    stored = mesh.attributes.get("togishi_tangent")
    uv = mesh.uv_layers.get(UV_MAP)
    if stored is None or uv is None:
        return
    if (stored.domain, stored.data_type) != ("CORNER", "FLOAT_VECTOR"):
        return
    corners = len(mesh.loops)
    own, chart = np.empty(corners * 3, np.float32), np.empty(corners * 2, np.float32)
    vertex, place = np.empty(corners, np.int32), np.empty(len(mesh.vertices) * 3, np.float32)
    stored.data.foreach_get("vector", own)
    uv.uv.foreach_get("vector", chart)
    mesh.loops.foreach_get("vertex_index", vertex)
    mesh.vertices.foreach_get("co", place)
    mesh.calc_loop_triangles()
    triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
    mesh.loop_triangles.foreach_get("loops", triangles)
    own = own.reshape(-1, 3)
    along = tangents.uv_tangents(
        place.reshape(-1, 3)[vertex], chart.reshape(-1, 2), triangles.reshape(-1, 3)
    )
    turned = tangents.turned_with_mesh(own, along)
    if turned is not own:
        stored.data.foreach_set("vector", turned.reshape(-1))
        mesh.update()


def set_slots(mesh: bpy.types.Mesh, slots: Mapping[int, int]) -> None:
    """Give the faces of each part their material slot; 0 where none is named."""
    parts = _face_values(mesh, "togishi_part")
    if parts is not None and any(slots.values()):
        chosen = np.array([slots.get(int(part), 0) for part in parts], np.int32)
        mesh.polygons.foreach_set("material_index", chosen)
        mesh.update()


def make(parameters: Mapping[str, Any], detail: float) -> Any:
    """The core's blade. Raises togishi_core.InputError with the reason for impossible dimensions."""
    return native.core().katana(dict(parameters), detail)


def new_object(
    scene: bpy.types.Scene, name: str, katana: Any, parameters: Mapping[str, Any], detail: float
) -> bpy.types.Object:
    """An object with the blade's mesh, not yet in a collection."""
    mesh = bpy.data.meshes.new(name)
    fill_mesh(mesh, katana, scene.unit_settings.scale_length or 1.0)
    obj = bpy.data.objects.new(name, mesh)
    remember(obj, parameters, detail)
    return obj


def remember(obj: bpy.types.Object, parameters: Mapping[str, Any], detail: float) -> None:
    """Keep the recipe on the object, for editing and for baking its maps."""
    obj.togishi.katana_json = json.dumps(dict(parameters), sort_keys=True)
    obj.togishi.detail = detail


def new_material(name: str = "Blade steel") -> bpy.types.Material:
    """A blade material with the core's default values, and its node groups for Cycles and EEVEE."""
    from .nodes import steel_group

    material = bpy.data.materials.new(name)
    with properties.held_updates():
        material.togishi.is_blade = True
        properties.set_material_dict(material, native.core().default_material())
        properties.set_pattern_dict(material, native.core().steel_defaults())
    steel_group.connect(material)
    return material


def blade_material(obj: bpy.types.Object | None) -> bpy.types.Material | None:
    """The first blade material of an object."""
    if obj is None:
        return None
    for slot in obj.material_slots:
        if properties.is_blade(slot.material):
            return slot.material
    return None


def has_recipe(obj: bpy.types.Object | None) -> bool:
    """Whether a pattern can be laid over it: a generated blade, or a scanned one with its chart."""
    if obj is None or obj.type != "MESH":
        return False
    return bool(obj.togishi.katana_json or obj.togishi.frame_json)


def is_blade_object(obj: bpy.types.Object | None) -> bool:
    """Whether this is a mesh of blade steel, a generated or a scanned blade."""
    if obj is None or obj.type != "MESH":
        return False
    return blade_material(obj) is not None or has_recipe(obj)


def find_blade(context: bpy.types.Context) -> bpy.types.Object | None:
    """The active object where it is a blade, what it hangs on where that is one, else the scene's first blade."""
    active = context.active_object
    near = () if active is None else (active, active.parent)
    return next((obj for obj in (*near, *context.scene.objects) if is_blade_object(obj)), None)


def select_only(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Select the object alone and make it the active one."""
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


def edited_material(context: bpy.types.Context) -> bpy.types.Material | None:
    """The blade material that operators work on: the one that the Properties editor shows, which may be pinned, else
    the active slot's, else the blade's first."""
    active = context.active_object
    slot = None if active is None else active.active_material
    for material in (getattr(context, "material", None), slot):
        if properties.is_blade(material):
            return material
    return blade_material(find_blade(context))


def blade_owner(material: bpy.types.Material) -> bpy.types.Object | None:
    """An object with this material that has a recipe."""
    for obj in bpy.data.objects:
        if has_recipe(obj):
            for slot in obj.material_slots:
                if slot.material == material:
                    return obj
    return None
