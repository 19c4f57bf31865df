"""What the example scenes share: the add-on, a blade, a camera square on, black surroundings."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
from mathutils import Vector

ROOT = Path(__file__).resolve().parents[1]


def start() -> None:
    """An empty file with the add-on, whether it is installed or runs from the checkout."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types.Scene, "togishi"):
        sys.path.insert(0, str(ROOT / "addon"))
        import togishi

        togishi.register()


def blade(
    preset: str = "KATANA",
    hamon: str = "gunome",
    seed: int = 7,
    texels: tuple[int, int] = (4096, 512),
) -> bpy.types.Object:
    """A blade with its maps, edge up as blades are shown, its middle at the origin."""
    bpy.ops.mesh.togishi_katana_add(preset=preset, with_pattern=False)
    obj = bpy.context.active_object
    pattern = obj.active_material.togishi.pattern
    pattern.hamon, pattern.seed = hamon, seed
    pattern.width_px, pattern.height_px = texels
    bpy.ops.material.togishi_pattern_bake()
    obj.rotation_euler = (math.pi, 0.0, 0.0)
    bpy.context.view_layer.update()
    corners = [obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
    obj.location -= sum(corners, Vector()) / 8.0
    bpy.context.view_layer.update()
    return obj


def camera(
    target: Vector, width_m: float, lens_mm: float = 100.0, elevation_deg: float = 0.0
) -> bpy.types.Object:
    """A long lens that sees `width_m` at the target, from the side of +y. Long, so that perspective does not
    bend the sori."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens_mm
    data.clip_start = 0.01
    distance = width_m * lens_mm / data.sensor_width
    obj = bpy.data.objects.new("Camera", data)
    rise = math.radians(elevation_deg)
    obj.location = target + Vector((0.0, math.cos(rise), math.sin(rise))) * distance
    obj.rotation_euler = (target - obj.location).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.scene.camera = obj
    bpy.context.view_layer.update()
    return obj


def picture(width: int = 1920, height: int = 1080, samples: int = 32) -> bpy.types.Scene:
    """Render settings of every example: our engine, black surroundings, AgX."""
    scene = bpy.context.scene
    scene.render.engine = "TOGISHI"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.togishi.samples = samples
    scene.view_settings.view_transform = "AgX"
    return scene


def plain_material(
    name: str, colour: tuple[float, float, float], roughness: float
) -> bpy.types.Material:
    """A plain surface for stand and cloth."""
    from togishi import blender_versions

    material = bpy.data.materials.new(name)
    material.diffuse_color = (*colour, 1.0)
    blender_versions.use_nodes(material)
    shader = next(n for n in material.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return material


def box(
    name: str,
    centre: tuple[float, float, float],
    size: tuple[float, float, float],
    material: bpy.types.Material,
) -> bpy.types.Object:
    """An axis-aligned box with its edges rounded a little, so that they catch light."""
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=centre)
    obj = bpy.context.active_object
    obj.name = name
    obj.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bevel = obj.modifiers.new("Rounded edges", "BEVEL")
    bevel.width = min(size) * 0.12
    bevel.segments = 3
    obj.data.materials.append(material)
    return obj


def run(build: Callable[[], None]) -> None:
    """`python SCRIPT.py OUT.blend`: build the scene and save it. Exit code 2 for a wrong command line."""
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    if len(arguments) != 1 or not arguments[0].endswith(".blend"):
        print(f"usage: python {Path(sys.argv[0]).name} OUT.blend", file=sys.stderr)
        sys.exit(2)
    out = Path(arguments[0]).resolve()
    out.parent.mkdir(parents=True, exist_ok=True)
    start()
    build()
    temporary = out.with_name(f".{out.name}")
    bpy.ops.wm.save_as_mainfile(filepath=str(temporary), compress=True, check_existing=False)
    temporary.replace(out)
    print(f"Saved: '{out}'")
    import togishi

    togishi.unregister()
