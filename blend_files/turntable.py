"""A katana that turns about its own length under museum spots: 96 frames, one turn.

python blend_files/turntable.py OUT.blend
"""

from __future__ import annotations

import math

import bpy
import stage
from mathutils import Vector


def build() -> None:
    blade = stage.blade(hamon="choji")
    scene = stage.picture()
    stage.camera(Vector(), blade.dimensions.x * 1.08)
    bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")
    bpy.ops.material.togishi_nodes_bake_for_scene()
    pivot = bpy.data.objects.new("Turntable", None)
    scene.collection.objects.link(pivot)
    bpy.context.view_layer.update()
    blade.parent = pivot
    blade.matrix_parent_inverse = pivot.matrix_world.inverted()
    scene.frame_start, scene.frame_end = 1, 96
    for frame, angle in ((1, 0.0), (97, 2.0 * math.pi)):
        pivot.rotation_euler.x = angle
        pivot.keyframe_insert("rotation_euler", index=0, frame=frame)
    # Even speed, so that the last frame runs into the first.
    from togishi import blender_versions

    for curve in blender_versions.action_curves(pivot):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.frame_set(1)


stage.run(build)
