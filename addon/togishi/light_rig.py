"""Put a light preset around a blade."""

from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .core import light_presets, spectrum_spec

COLLECTION = "Togishi lights"
# On the collection and on the lamps that a preset made. Names say nothing: Blender numbers them in a second scene.
MARK = "togishi_light_preset"
JI = 1  # shaders/shared/parts.glsl


@dataclass(frozen=True)
class Frame:
    """How a blade lies to its viewer, in the world."""

    middle: Vector
    along: Vector  # unit, towards the tip
    view: Vector  # unit, towards the viewer
    mirror: Vector  # unit, where a lamp must stand for the ji to flash
    half_length: float


def _ji_normal(obj: bpy.types.Object, view: Vector) -> Vector | None:
    """Mean normal of the ji on the viewer's side, in the world; None for what is no blade."""
    mesh = obj.data
    part = mesh.attributes.get("togishi_part")
    if part is None or not len(mesh.polygons):
        return None
    count = len(mesh.polygons)
    parts, normals, areas = np.empty(count, np.int32), np.empty(count * 3), np.empty(count)
    part.data.foreach_get("value", parts)
    mesh.polygons.foreach_get("normal", normals)
    mesh.polygons.foreach_get("area", areas)
    normals = normals.reshape(-1, 3)
    local_view = np.array(obj.matrix_world.inverted_safe().to_3x3() @ view)
    chosen = (parts == JI) & (normals @ local_view > 0.0)
    if not chosen.any():
        return None
    mean = Vector((normals[chosen] * areas[chosen, None]).sum(axis=0))
    return (obj.matrix_world.to_3x3().inverted_safe().transposed() @ mean).normalized()


def frame_of(obj: bpy.types.Object, to_viewer: Vector | None = None) -> Frame:
    """to_viewer: from what is looked at to the camera; without one the blade is looked at square on. It is the
    camera's axis, not its place, so that close-ups of a blade's end are lit as they look. The longest side is the length
    and the shortest looks at the viewer, wherever the object's own axes point: Apply Rotation turns them."""
    corners = [Vector(corner) for corner in obj.bound_box]
    low = Vector(map(min, zip(*corners, strict=True)))
    high = Vector(map(max, zip(*corners, strict=True)))
    size = high - low
    matrix = obj.matrix_world
    middle = matrix @ ((low + high) * 0.5)
    long_axis = max(range(3), key=lambda i: size[i])
    thin_axis = min((i for i in range(3) if i != long_axis), key=lambda i: size[i])
    basis = matrix.to_3x3()
    along = basis.col[long_axis].copy()
    half_length = max(0.5 * size[long_axis] * along.length, 1e-4)
    along.normalize()
    out = basis.col[thin_axis].normalized()
    view = out
    if to_viewer is not None:
        view = to_viewer.normalized()
        if out.dot(view) < 0.0:
            out = -out
    normal = _ji_normal(obj, view) or out
    return Frame(middle, along, view, view.reflect(normal) * -1.0, half_length)


def _aim(obj: bpy.types.Object, position: Vector, target: Vector) -> None:
    obj.rotation_euler = (target - position).to_track_quat("-Z", "Y").to_euler()


def _move(obj: bpy.types.Object, scene: bpy.types.Scene, way: Vector) -> None:
    """Keys on the place: from where it stands at the scene's first frame, by `way` at its last."""
    start = obj.location.copy()
    obj.keyframe_insert("location", frame=scene.frame_start)
    obj.location = start + way
    obj.keyframe_insert("location", frame=max(scene.frame_end, scene.frame_start + 1))
    obj.animation_data.action[MARK] = True
    share = (scene.frame_current - scene.frame_start) / max(scene.frame_end - scene.frame_start, 1)
    obj.location = start + way * min(max(share, 0.0), 1.0)


def set_spectrum(light: bpy.types.Light, kind: str, temperature_k: float = 0.0) -> None:
    settings = light.togishi
    settings.kind = kind
    if kind == spectrum_spec.BLACKBODY:
        settings.blackbody_k = temperature_k
    elif kind == spectrum_spec.DAYLIGHT:
        settings.daylight_k = temperature_k


def _collections(scene: bpy.types.Scene) -> list[bpy.types.Collection]:
    """Those that presets made in this scene, or that it was copied with."""
    return [child for child in scene.collection.children if child.get(MARK) and not child.library]


def _is_shared(collection: bpy.types.Collection, scene: bpy.types.Scene) -> bool:
    """Whether another scene shows the collection too, as after a linked copy."""
    return any(
        collection in other.collection.children_recursive
        for other in bpy.data.scenes
        if other != scene
    )


def clear(scene: bpy.types.Scene) -> None:
    """Remove the lights that an earlier preset made in this scene. What else lies in their collection stays, and so do
    the lights of other scenes."""
    for collection in _collections(scene):
        if _is_shared(collection, scene):
            scene.collection.children.unlink(collection)
            for obj in collection.objects:
                if not obj.get(MARK) and obj.name not in scene.collection.objects:
                    scene.collection.objects.link(obj)
            continue
        for obj in list(collection.objects):
            if not obj.get(MARK):
                continue
            if any(other != scene for other in obj.users_scene):
                collection.objects.unlink(obj)
                continue
            data = obj.data
            action = obj.animation_data.action if obj.animation_data else None
            bpy.data.objects.remove(obj)
            if action is not None and action.get(MARK) and action.users == 0:
                bpy.data.actions.remove(action)
            if isinstance(data, bpy.types.Light) and data.users == 0:
                bpy.data.lights.remove(data)


def add(
    scene: bpy.types.Scene,
    target: bpy.types.Object,
    identifier: str,
    strength: float = 1.0,
    set_world: bool = True,
) -> list[bpy.types.Object]:
    """Make a preset's lights in their own collection, aimed at the target; returns the objects."""
    return add_lamps(scene, target, light_presets.preset(identifier), strength, set_world)


def add_lamps(
    scene: bpy.types.Scene,
    target: bpy.types.Object,
    chosen: light_presets.LightPreset,
    strength: float = 1.0,
    set_world: bool = True,
) -> list[bpy.types.Object]:
    """The same for lamps that stand in no list of presets."""
    own = [found for found in _collections(scene) if not _is_shared(found, scene)]
    if own:
        collection = own[0]
    else:
        collection = bpy.data.collections.new(COLLECTION)
        collection[MARK] = True
        scene.collection.children.link(collection)
    axis = scene.camera.matrix_world.to_3x3().col[2] if scene.camera else None
    frame = frame_of(target, axis)
    half = frame.half_length
    # Away from the viewer means: turned about the blade's length, the way the mirror direction is turned already.
    sense = 1.0 if frame.along.dot(frame.view.cross(frame.mirror)) >= 0.0 else -1.0
    made = []
    for lamp in chosen.lamps:
        light = bpy.data.lights.new(f"{chosen.label}: {lamp.name}", lamp.kind)
        turn = Matrix.Rotation(sense * math.radians(lamp.off_mirror_deg), 3, frame.along)
        direction = turn @ frame.mirror
        aim = frame.middle + frame.along * (lamp.along * half)
        position = aim + direction * (lamp.distance * half)
        if lamp.kind == "SUN":
            aim = frame.middle
            position = aim + (direction + frame.along * lamp.along) * (2.0 * half)
        if lamp.kind == "SUN":
            light.energy = lamp.power_w * strength
            light.angle = 0.0093
        else:
            # Irradiance is power over distance squared, in scene units.
            light.energy = lamp.power_w * strength * (half / 0.5) ** 2
            if lamp.kind == "AREA":
                light.shape = "RECTANGLE"
                light.size, light.size_y = (size * half for size in lamp.size)
            else:
                light.shadow_soft_size = lamp.radius * half
        if lamp.kind == "SPOT":
            light.spot_size = math.radians(lamp.cone_deg)
            light.spot_blend = lamp.blend
        set_spectrum(light, lamp.spectrum_kind, lamp.temperature_k)
        obj = bpy.data.objects.new(light.name, light)
        obj[MARK] = True
        obj.location = position
        _aim(obj, position, aim)
        if lamp.kind == "AREA":
            # The long side along the blade.
            back = (position - aim).normalized()
            along = (frame.along - back * frame.along.dot(back)).normalized()
            axes = Matrix((along, back.cross(along), back)).transposed()
            obj.rotation_euler = axes.to_euler()
        collection.objects.link(obj)
        if lamp.to_along is not None:
            _move(obj, scene, frame.along * ((lamp.to_along - lamp.along) * half))
        made.append(obj)
    if set_world:
        world = scene.world or bpy.data.worlds.new("World")
        scene.world = world
        set_world_grey(world, chosen.world_grey)
    return made


def set_world_grey(world: bpy.types.World, grey: float) -> None:
    """A uniform grey room of this radiance, in the world's colour and in its Background node."""
    from . import blender_versions

    world.color = (grey, grey, grey)
    blender_versions.use_nodes(world)
    node = next((n for n in world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground"), None)
    if node is not None:
        node.inputs["Color"].default_value = (grey, grey, grey, 1.0)
        node.inputs["Strength"].default_value = 1.0
