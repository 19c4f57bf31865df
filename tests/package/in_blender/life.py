"""Install, add a blade, render it with the engine, disable, enable again, uninstall. life.py REPORT ZIP"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from extension import ARGUMENTS, NAME, add_katana, enabled, install, part, problem, report

FOLDER = Path(bpy.utils.user_resource("EXTENSIONS"))


def picture() -> np.ndarray:
    """(32, 64, 4), scene-linear, rendered by our engine to a file and read back."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.4, 1.5, 0.0), (math.pi / 2, 0.0, math.pi)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("room")
    scene.world.color = (0.2, 0.2, 0.2)
    scene.render.engine = "TOGISHI"
    scene.togishi.samples = 1
    scene.render.resolution_x, scene.render.resolution_y = 64, 32
    part("blender_versions").set_file_format(scene.render.image_settings, "OPEN_EXR")
    scene.render.filepath = str(Path.home() / "picture.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    return np.array(image.pixels[:], np.float32).reshape(32, 64, 4)


def files() -> list[str]:
    """What the extension has on disk, modules of its wheels included."""
    found = [*FOLDER.glob("user_default/togishi/*"), *FOLDER.glob(".local/lib/*/site-packages/*")]
    return sorted(str(path.relative_to(FOLDER)) for path in found)


bpy.ops.wm.read_factory_settings(use_empty=True)
report(said=install(ARGUMENTS[0]), enabled=enabled(), problem=problem())
import togishi_core  # noqa: E402 - the extension brings it

report(module=togishi_core.__file__, version=togishi_core.__version__, files=files())
blade = add_katana()
report(polygons=len(blade.data.polygons))
values = picture()
report(finite=bool(np.isfinite(values).all()), brightest=float(values[..., :3].max()))

bpy.ops.preferences.addon_disable(module=NAME)
report(disabled=not enabled() and not hasattr(bpy.types.Scene, "togishi"))
bpy.ops.preferences.addon_enable(module=NAME)
report(enabled_again=enabled(), problem_again=problem())
report(polygons_again=len(add_katana().data.polygons))

modules = [repository.module for repository in bpy.context.preferences.extensions.repos]
bpy.ops.extensions.package_uninstall(repo_index=modules.index("user_default"), pkg_id="togishi")
report(uninstalled=not enabled(), files_left=files())
