"""The handle by which a user tells how a scanned blade lies: an empty at its machi, X to the tip and Z to the back."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from . import blade_object, scan_import

# Custom property of the handle's object. Names are the user's.
HANDLE = "togishi_pose_handle"
_SIZE_MM = 40.0


def find(blade: bpy.types.Object) -> bpy.types.Object | None:
    return next((child for child in blade.children if HANDLE in child), None)


def add(blade: bpy.types.Object) -> bpy.types.Object:
    handle = bpy.data.objects.new(f"{blade.name} pose", None)
    handle.empty_display_type = "ARROWS"
    handle.empty_display_size = _SIZE_MM * blade_object.MM / blade.togishi.scan.unit_m
    handle.show_in_front = True
    handle.parent = blade
    handle[HANDLE] = True
    (blade.users_collection or (bpy.context.scene.collection,))[0].objects.link(handle)
    return handle


def moved(
    blade: bpy.types.Object, handle: bpy.types.Object
) -> tuple[dict[str, Any], np.ndarray, tuple[float, float, float]]:
    """The import's report, the handle's axes in the blade's (3, 3) and its place in mm, as core.scan_pose takes them.
    The view layer has to be up to date. ValueError where the blade has no extent."""
    matrix = blade.matrix_world.inverted() @ handle.matrix_world
    to_mm = blade.togishi.scan.unit_m / blade_object.MM
    return (
        scan_import.report_of(blade),
        np.array(matrix.to_3x3()),
        tuple(v * to_mm for v in matrix.translation),
    )


def put_back(blade: bpy.types.Object) -> None:
    """To the machi, as it is understood now."""
    handle = find(blade)
    if handle is not None:
        handle.matrix_parent_inverse = Matrix()
        handle.matrix_basis = Matrix()
