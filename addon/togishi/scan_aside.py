"""Pieces of a scan that are no part of the blade (stand, scale bar): objects beside it, which follow it where it is
understood anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import bpy
import numpy as np

from . import blade_object

ASIDE = "aside"
# Custom property of each piece's object: its number, from 1. Names are the user's.
NUMBER = "togishi_aside"


def _fill(mesh: bpy.types.Mesh, piece: Mapping[str, Any], unit_m: float) -> None:
    """Into an empty mesh. unit_m: metres per scene unit."""
    places = np.asarray(piece["positions_mm"], np.float32) * (blade_object.MM / unit_m)
    triangles = np.asarray(piece["triangles"], np.int32)
    mesh.vertices.add(len(places))
    mesh.vertices.foreach_set("co", places.astype(np.float32).reshape(-1))
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.reshape(-1))
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)


def _pieces(blade: bpy.types.Object) -> list[bpy.types.Object]:
    found = [obj for obj in blade.children if NUMBER in obj and obj.type == "MESH"]
    return sorted(found, key=lambda obj: int(obj[NUMBER]))


def _collection(blade: bpy.types.Object, name: str) -> bpy.types.Collection:
    """A new one beside the blade, out of renders."""
    beside = bpy.data.collections.new(f"{name} {ASIDE}")
    parents = blade.users_collection
    (parents[0] if parents else bpy.context.scene.collection).children.link(beside)
    beside.hide_render = True
    return beside


def put(
    blade: bpy.types.Object, name: str, pieces: Sequence[Mapping[str, Any]], unit_m: float
) -> None:
    """As many pieces beside the blade, in its frame. Objects that are there get their new shape and keep what the
    user gave them; name is for new ones."""
    there = _pieces(blade)
    for obj in there[len(pieces) :]:
        mesh = obj.data
        bpy.data.objects.remove(obj)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    beside = there[0].users_collection[0] if there and there[0].users_collection else None
    for number, piece in enumerate(pieces, 1):
        if number <= len(there):
            mesh = there[number - 1].data
            mesh.clear_geometry()
            _fill(mesh, piece, unit_m)
            continue
        beside = beside or _collection(blade, name)
        label = f"{name} {ASIDE} {number}"
        mesh = bpy.data.meshes.new(label)
        _fill(mesh, piece, unit_m)
        obj = bpy.data.objects.new(label, mesh)
        obj.parent = blade
        obj[NUMBER] = number
        beside.objects.link(obj)
