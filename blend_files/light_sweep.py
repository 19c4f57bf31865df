"""A lamp that runs along a katana, through the mirror direction of its ji: the flash wanders from the machi to the
tip, and the hamon stands out in front of it and behind it. 72 frames.

    python blend_files/light_sweep.py OUT.blend
"""

from __future__ import annotations

import bpy
import stage
from mathutils import Vector


def build() -> None:
    from togishi import blender_versions, light_rig

    blade = stage.blade()
    scene = stage.picture()
    camera = stage.camera(Vector(), blade.dimensions.x * 1.08)
    made = light_rig.add(scene, blade, "MUSEUM_SPOT", 0.6)
    for lamp in made:
        if lamp.name.endswith("Flash"):
            bpy.data.objects.remove(lamp)
    frame = light_rig.frame_of(blade, camera.matrix_world.to_3x3().col[2])
    data = bpy.data.lights.new("Sweep", "SPOT")
    data.energy = 1.4 * (frame.half_length / 0.5) ** 2
    data.spot_size, data.spot_blend = 0.9, 1.0
    data.shadow_soft_size = 0.0
    light_rig.set_spectrum(data, "blackbody", 3200.0)
    lamp = bpy.data.objects.new("Sweep", data)
    scene.collection.objects.link(lamp)
    scene.frame_start, scene.frame_end = 1, 72
    for time, along in ((1, -1.15), (72, 1.15)):
        aim = frame.middle + frame.along * (along * frame.half_length)
        lamp.location = aim + frame.mirror * (1.6 * frame.half_length)
        lamp.rotation_euler = (aim - lamp.location).to_track_quat("-Z", "Y").to_euler()
        lamp.keyframe_insert("location", frame=time)
        lamp.keyframe_insert("rotation_euler", frame=time)
    for curve in blender_versions.action_curves(lamp):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    bpy.context.view_layer.objects.active = blade
    bpy.ops.material.togishi_nodes_connect(spectrum="D50")
    scene.frame_set(36)


stage.run(build)
