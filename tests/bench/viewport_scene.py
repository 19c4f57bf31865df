"""The scene of the viewport's figures, in Blender: a blade with four lamps whose highlights sweep along it.

The same object carries both sides: our engine reads the blade material's settings and map images, EEVEE its node tree. That
tree is one Principled BSDF, fed by the same images where there are maps: less work for EEVEE than the add-on's own node
group, which stacks several lobes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector
from togishi import blade_object, map_images, properties
from togishi.core import native
from togishi.core.scene_data import Camera

SIZE = (1920, 1080)
MAP_SIZE = (4096, 512)
SPECTRA = ("D65", "A", "FL11", "LED-B3")
EEVEE = ("BLENDER_EEVEE_NEXT", "BLENDER_EEVEE")


@dataclass
class BenchScene:
    scene: bpy.types.Scene
    blade: bpy.types.Object
    material: bpy.types.Material
    lamps: list[bpy.types.Object]
    camera: bpy.types.Object
    rest: list[Vector]

    def sweep(self, frame: int) -> None:
        """Every lamp moves a little along the blade, there and back."""
        shift = 0.02 * math.sin(0.7 * frame)
        for lamp, place in zip(self.lamps, self.rest, strict=True):
            lamp.location = place + Vector((shift, 0.0, 0.0))

    def matrices(self) -> tuple[Matrix, Matrix]:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return (
            self.camera.matrix_world.inverted(),
            self.camera.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1]),
        )

    def view(self) -> Camera:
        view, projection = self.matrices()
        return Camera(np.array(view, np.float64), np.array(projection, np.float64))


def eevee_name() -> str:
    engines = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
    for name in EEVEE:
        if name in engines:
            return name
    # The wheel lists engines only when they are asked for.
    for name in EEVEE:
        try:
            bpy.context.scene.render.engine = name
        except TypeError:
            continue
        return name
    raise RuntimeError("this Blender has no EEVEE")


def plain_eevee(scene: bpy.types.Scene) -> None:
    """One sample a frame; no shadows, no ray tracing: what our side does not do either."""
    scene.render.engine = eevee_name()
    for name, value in (
        ("taa_samples", 1),
        ("taa_render_samples", 1),
        ("use_taa_reprojection", False),
        ("use_shadows", False),
        ("use_raytracing", False),
        ("use_gtao", False),
    ):
        if hasattr(scene.eevee, name):
            setattr(scene.eevee, name, value)


def principled(material: bpy.types.Material, images: list[bpy.types.Image]) -> None:
    """Metal with one roughness; with images: roughness from the first, base colour from the second."""
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = (0.56, 0.54, 0.52, 1.0)
    shader.inputs["Metallic"].default_value = 1.0
    shader.inputs["Roughness"].default_value = 0.15
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    for number, image in enumerate(images):
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        if number == 0:
            split = tree.nodes.new("ShaderNodeSeparateColor")
            tree.links.new(texture.outputs["Color"], split.inputs["Color"])
            tree.links.new(split.outputs[2], shader.inputs["Roughness"])
        else:
            tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])


def build(*, maps: bool) -> BenchScene:
    """A new file with the scene; the add-on is registered."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.world = bpy.data.worlds.new("dark")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    core = native.core()
    parameters = core.katana_defaults()
    katana = blade_object.make(parameters, 1.0)
    blade = blade_object.new_object(scene, "blade", katana, parameters, 1.0)
    scene.collection.objects.link(blade)
    material = bpy.data.materials.new("steel")
    with properties.held_updates():
        material.togishi.is_blade = True
        properties.set_material_dict(material, core.default_material())
    images = []
    if maps:
        pattern = core.steel_pattern(
            parameters, core.default_material(), core.steel_defaults(), *MAP_SIZE
        )
        map_images.assign(material, pattern)
        images = [image for image in properties.blade_images(material) if image is not None]
    principled(material, images)
    blade.data.materials.append(material)
    return BenchScene(scene, blade, material, *_light_and_camera(scene, blade))


def _light_and_camera(
    scene: bpy.types.Scene, blade: bpy.types.Object
) -> tuple[list[bpy.types.Object], bpy.types.Object, list[Vector]]:
    """The middle of the blade over most of the picture; lamps where points along it mirror them into the camera."""
    mesh = blade.data
    place = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", place)
    place = place.reshape(-1, 3).astype(np.float64)
    normal = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("normal", normal)
    normal = normal.reshape(-1, 3).astype(np.float64)
    middle = 0.3
    seen = np.flatnonzero((np.abs(place[:, 0] - middle) < 0.05) & (normal[:, 1] > 0.5))
    centre = Vector(((place[seen].min(axis=0) + place[seen].max(axis=0)) / 2).tolist())
    data = bpy.data.cameras.new("camera")
    data.sensor_width, data.lens = 36.0, 400.0
    data.clip_start, data.clip_end = 0.01, 100.0
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    camera.location = centre + Vector((0.05, 1.2, 0.15))
    camera.rotation_euler = (centre - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    eye = np.array(camera.location)
    lamps = []
    chosen = seen[np.linspace(0, len(seen) - 1, len(SPECTRA)).astype(int)]
    for vertex, spectrum in zip(chosen, SPECTRA, strict=True):
        view = eye - place[vertex]
        view /= np.linalg.norm(view)
        towards = 2 * np.dot(normal[vertex], view) * normal[vertex] - view
        light = bpy.data.lights.new(spectrum, "POINT")
        light.energy, light.use_shadow, light.shadow_soft_size = 5.0, False, 0.0
        light.togishi.kind = spectrum
        lamp = bpy.data.objects.new(spectrum, light)
        lamp.location = place[vertex] + 1.5 * towards
        scene.collection.objects.link(lamp)
        lamps.append(lamp)
    bpy.context.view_layer.update()
    return lamps, camera, [lamp.location.copy() for lamp in lamps]
