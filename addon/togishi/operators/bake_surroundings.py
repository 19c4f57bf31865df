"""A world of any nodes as an HDRI, by Cycles: our engine mirrors pictures only."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import bpy
from bpy.props import IntProperty

from .. import blender_versions
from .poll import allowed, local

# The sun of a sky needs them at its edge; everything else is even within a texel.
SAMPLES = 16


def picture_of(world: bpy.types.World, width: int) -> bpy.types.Image:
    """The world in all directions, packed, strength included. Raises RuntimeError where Cycles is not there."""
    scene = bpy.data.scenes.new("Togishi surroundings")
    data = bpy.data.cameras.new("Togishi surroundings")
    camera = bpy.data.objects.new("Togishi surroundings", data)
    try:
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, world
        # The picture's middle is x, its left y.
        camera.rotation_euler = (math.radians(90.0), 0.0, math.radians(-90.0))
        data.type = "PANO"
        settings = data if hasattr(data, "panorama_type") else data.cycles
        settings.panorama_type = "EQUIRECTANGULAR"
        render = scene.render
        try:
            render.engine = "CYCLES"
        except TypeError as error:
            raise RuntimeError("Cycles is switched off in the preferences' add-ons") from error
        scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
        # One sample wide: no light of a sun into the texels around it.
        scene.cycles.pixel_filter_type = "BOX"
        scene.cycles.filter_width = 1.0
        render.resolution_x, render.resolution_y = width, width // 2
        render.resolution_percentage = 100
        blender_versions.set_file_format(render.image_settings, "OPEN_EXR")
        render.image_settings.color_depth = "32"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "surroundings.exr"
            render.filepath = str(path)
            bpy.ops.render.render(scene=scene.name, write_still=True)
            image = bpy.data.images.load(str(path))
            image.name = f"{world.name} surroundings"
            image.pack()
        return image
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)


def show(world: bpy.types.World, image: bpy.types.Image) -> None:
    """The image as the world's background; the nodes of before stay beside it."""
    tree = world.node_tree
    background = tree.nodes.new("ShaderNodeBackground")
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    if output is None:
        output = tree.nodes.new("ShaderNodeOutputWorld")
    background.location = output.location[0] - 200.0, output.location[1] - 200.0
    texture.location = output.location[0] - 500.0, output.location[1] - 200.0
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])


class TOGISHI_OT_bake_surroundings(bpy.types.Operator):
    """Let Cycles take a picture of the surroundings in all directions and use it in place of their nodes"""

    bl_idname = "world.togishi_bake_surroundings"
    bl_label = "Bake Surroundings"
    bl_options = {"REGISTER", "UNDO"}

    width: IntProperty(
        name="Width", description="Of the picture, in pixels", default=1024, min=64, max=4096
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        world = context.scene.world
        has_nodes = world is not None and world.use_nodes and world.node_tree is not None
        return allowed(
            cls,
            (has_nodes, "Needs a world with nodes"),
            (local(world), "This world is linked from another file; make it local to change it"),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        world = context.scene.world
        try:
            image = picture_of(world, self.width)
        except RuntimeError as error:
            self.report({"ERROR"}, f"The surroundings were not baked: {error}")
            return {"CANCELLED"}
        show(world, image)
        return {"FINISHED"}


CLASSES = (TOGISHI_OT_bake_surroundings,)
