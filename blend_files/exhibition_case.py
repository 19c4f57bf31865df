"""A katana on a stand with a cloth, under three lamps of a museum case.

python blend_files/exhibition_case.py OUT.blend
"""

from __future__ import annotations

import math

import bpy
import numpy as np
import stage
from mathutils import Vector


def cloth(
    width: float, depth: float, height: float, material: bpy.types.Material
) -> bpy.types.Object:
    """A cloth that lies on the case's floor and rises behind, with soft folds: a rounded sweep, no edge in sight."""
    columns, rows = 96, 48
    u = np.linspace(-0.5, 0.5, columns)
    t = np.linspace(0.0, 1.0, rows)
    radius = 0.25 * depth
    floor = depth - radius
    bend = 0.5 * math.pi * radius
    length = floor + bend + height
    s = t * length
    angle = np.clip((s - floor) / radius, 0.0, 0.5 * math.pi)
    back = np.minimum(s, floor) + radius * np.sin(angle)
    up = radius * (1.0 - np.cos(angle)) + np.maximum(s - floor - bend, 0.0)
    x, row = np.meshgrid(u * width, np.arange(rows))
    fold = 0.006 * np.sin(x * 9.0 + 0.6 * np.sin(x * 3.1)) * t[row] ** 1.5
    y = 0.45 * depth - back[row] + fold * np.sin(angle[row])
    z = up[row] + fold * np.cos(angle[row]) * 0.3
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    faces = [
        (r * columns + c, r * columns + c + 1, (r + 1) * columns + c + 1, (r + 1) * columns + c)
        for r in range(rows - 1)
        for c in range(columns - 1)
    ]
    mesh = bpy.data.meshes.new("Cloth")
    mesh.from_pydata(points.tolist(), [], faces)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    mesh.materials.append(material)
    obj = bpy.data.objects.new("Cloth", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def build() -> None:
    from togishi import light_rig

    blade = stage.blade(hamon="notare", seed=3)
    stage.picture()
    length = blade.dimensions.x
    floor = -0.16
    lacquer = stage.plain_material("Black lacquer", (0.022, 0.018, 0.018), 0.2)
    # Plum, dark enough not to rival the steel.
    fabric = stage.plain_material("Cloth", (0.030, 0.012, 0.020), 0.9)
    cloth(length * 2.6, 1.1, 0.9, fabric).location.z = floor
    low = min((blade.matrix_world @ Vector(corner)).z for corner in blade.bound_box)
    stage.box("Stand base", (0.0, 0.0, floor + 0.012), (length * 0.62, 0.11, 0.024), lacquer)
    for x in (-0.26 * length, 0.26 * length):
        top = _back_height(blade, x)
        if top is None:
            top = low
        for side in (-1.0, 1.0):
            # Two prongs hold the back of the blade between them.
            stage.box(
                "Prong",
                (x, side * 0.011, 0.5 * (floor + top + 0.004)),
                (0.014, 0.010, top + 0.004 - floor),
                lacquer,
            )
        stage.box(
            "Rest", (x, 0.0, 0.5 * (floor + top)), (0.014, 0.014, top - floor - 0.001), lacquer
        )
    camera = stage.camera(Vector((0.0, 0.0, -0.03)), length * 1.12, elevation_deg=4.0)
    scene = bpy.context.scene
    frame = light_rig.frame_of(blade, camera.matrix_world.to_3x3().col[2])
    bpy.context.view_layer.objects.active = blade
    made = light_rig.add(scene, blade, "MUSEUM_SPOT", 1.0)
    for obj in made[1:]:
        bpy.data.objects.remove(obj)
    # Three lamps: a warm key and a cool fill off the mirror direction, which draw the hamon, and one that flashes.
    key = made[0]
    rig = (
        ("Key", -0.35, 10.0, 1.5, 7.0, "blackbody", 3200.0, 95.0),
        ("Fill", 0.55, 12.0, 1.8, 7.0, "daylight", 5500.0, 95.0),
        ("Flash", 0.15, 0.5, 1.6, 0.4, "blackbody", 3200.0, 30.0),
    )
    sense = 1.0 if frame.along.dot(frame.view.cross(frame.mirror)) >= 0.0 else -1.0
    from mathutils import Matrix

    for name, along, off, distance, power, kind, kelvin, cone in rig:
        obj = (
            key if name == "Key" else bpy.data.objects.new(name, bpy.data.lights.new(name, "SPOT"))
        )
        if obj is not key:
            key.users_collection[0].objects.link(obj)
        obj.name = obj.data.name = name
        direction = Matrix.Rotation(sense * math.radians(off), 3, frame.along) @ frame.mirror
        aim = frame.middle + frame.along * (along * frame.half_length)
        obj.location = aim + direction * (distance * frame.half_length)
        obj.rotation_euler = (aim - obj.location).to_track_quat("-Z", "Y").to_euler()
        obj.data.energy = power * (frame.half_length / 0.5) ** 2
        obj.data.spot_size, obj.data.spot_blend = math.radians(cone), 1.0
        light_rig.set_spectrum(obj.data, kind, kelvin)
    # A little more of the room than the preset's: the lacquer of the stand shows itself by it.
    light_rig.set_world_grey(scene.world, 0.015)
    bpy.ops.material.togishi_nodes_bake_for_scene()


def _back_height(blade: bpy.types.Object, x: float) -> float | None:
    """Height of the blade's back (its lowest line, edge up) at a place along it."""
    mesh = blade.data
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    matrix = np.array(blade.matrix_world)
    world = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    near = np.abs(world[:, 0] - x) < 0.006
    return float(world[near, 2].min()) if near.any() else None


stage.run(build)
