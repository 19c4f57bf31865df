"""A small scene for command_line.sh: a coarse blade under the museum's lamps, before a camera."""

import math
import sys

import bpy

for obj in list(bpy.data.objects):
    bpy.data.objects.remove(obj)
scene = bpy.context.scene
bpy.ops.mesh.togishi_katana_add(detail=0.05, with_pattern=False)
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location, camera.rotation_euler = (0.4, 1.5, 0.0), (math.pi / 2, 0.0, math.pi)
scene.collection.objects.link(camera)
scene.camera = camera
bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")
scene.render.engine = "TOGISHI"
scene.togishi.samples = 2
scene.render.resolution_x, scene.render.resolution_y = 96, 54
scene.frame_end = 3
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])
