"""The demo's photo studio: one blade on black, a long lens, lamps by their angle off the mirror direction."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import togishi_core
from mathutils import Vector
from togishi import light_rig, pattern_baking, properties
from togishi.core.light_presets import Lamp, LightPreset
from togishi.core.scene_data import Camera
from togishi.engine.renderer import Renderer, read_texture
from togishi.engine.scene_sync import SceneSync

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
from accuracy_reference import reference_picture, to_xyz  # noqa: E402

LENS_MM = 200.0


def empty_scene() -> bpy.types.Scene:
    """A scene with nothing in it, black surroundings and a display without tone curve."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    import togishi

    togishi.register()
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("Black")
    light_rig.set_world_grey(scene.world, 0.0)
    scene.view_settings.view_transform = "Standard"
    return scene


def add_blade(map_size: tuple[int, int]) -> bpy.types.Object:
    """The example katana of documented dimensions, lying along +x with its edge up, as it is exhibited."""
    bpy.ops.mesh.togishi_katana_add(preset="KATANA", with_pattern=False)
    blade = bpy.context.object
    blade.rotation_euler = (np.pi, 0.0, 0.0)
    material = blade.active_material
    pattern = material.togishi.pattern
    pattern.width_px, pattern.height_px = map_size
    bake(blade)
    bpy.context.view_layer.update()
    return blade


def bake(blade: bpy.types.Object) -> None:
    """The pattern's maps, after a change of material or pattern."""
    parameters = properties.katana_parameters(blade)
    assert parameters is not None
    pattern_baking.bake_now(blade.active_material, parameters)


def _middle_of_width(blade: bpy.types.Object, along_mm: float) -> Vector:
    """The middle between edge and back at this place, in the world."""
    places = np.empty(len(blade.data.vertices) * 3)
    blade.data.vertices.foreach_get("co", places)
    places = places.reshape(-1, 3)
    near = places[np.abs(places[:, 0] - along_mm * 1e-3) < 3e-3]
    across = 0.5 * (near[:, 2].min() + near[:, 2].max())
    return blade.matrix_world @ Vector((along_mm * 1e-3, 0.0, across))


def aim_camera(
    scene: bpy.types.Scene, blade: bpy.types.Object, along_mm: float, width_mm: float
) -> None:
    """Square on to the blade's near side, centred at this distance from the machi; the picture spans width_mm."""
    if scene.camera is None:
        data = bpy.data.cameras.new("Camera")
        scene.camera = bpy.data.objects.new("Camera", data)
        scene.collection.objects.link(scene.camera)
    camera = scene.camera
    camera.data.lens = LENS_MM
    camera.data.clip_start, camera.data.clip_end = 0.05, 100.0
    target = _middle_of_width(blade, along_mm)
    outwards = (blade.matrix_world.to_3x3() @ Vector((0.0, 1.0, 0.0))).normalized()
    distance = width_mm * 1e-3 * LENS_MM / camera.data.sensor_width
    camera.location = target + outwards * distance
    camera.rotation_euler = (-outwards).to_track_quat("-Z", "Y").to_euler()
    bpy.context.view_layer.update()


def light(
    scene: bpy.types.Scene,
    blade: bpy.types.Object,
    off_mirror_deg: float,
    *,
    spectrum: str = "D65",
    along_mm: tuple[float, float] = (-100.0, 736.0),
    lamps: tuple[int, int] = (25, 1),
    room: float = 0.0,
) -> None:
    """Replaces the lamps by a soft box of points over this stretch of the blade, so far off the mirror direction.

    lamps: how many along and across the blade (1.6 degrees apart); together 10 W. room: radiance of the surroundings.
    """
    light_rig.clear(scene)
    frame = light_rig.frame_of(blade)
    ends = [
        (blade.matrix_world @ Vector((x * 1e-3, 0.0, 0.0)) - frame.middle).dot(frame.along)
        / frame.half_length
        for x in along_mm
    ]
    places = np.linspace(*ends, lamps[0]) if lamps[0] > 1 else [0.5 * sum(ends)]
    turns = off_mirror_deg + 1.6 * (np.arange(lamps[1]) - 0.5 * (lamps[1] - 1))
    power_w = 10.0 / (lamps[0] * lamps[1])
    chosen = tuple(
        Lamp(
            f"Lamp {i}.{j}", "POINT", float(place), float(turn), 1.6, power_w, spectrum, radius=0.0
        )
        for i, place in enumerate(places)
        for j, turn in enumerate(turns)
    )
    light_rig.add_lamps(scene, blade, LightPreset("DEMO", "Demo", "", chosen, 0.0), set_world=False)
    light_rig.set_world_grey(scene.world, room)
    bpy.context.view_layer.update()


@dataclass(frozen=True)
class Shot:
    """rgb (H, W, 3) linear Rec.709 and alpha (H, W), rows from the bottom; seconds the render took."""

    rgb: np.ndarray
    alpha: np.ndarray
    seconds: float


def shoot(
    scene: bpy.types.Scene, folder: Path, size: tuple[int, int], engine: str, samples: int
) -> Shot:
    """A final render by any engine, as a user gets it with F12, read back in scene-linear values."""
    render = scene.render
    render.engine = engine
    render.resolution_x, render.resolution_y = size
    # The room is mirrored in the blade, but the picture's ground stays black.
    render.film_transparent = True
    scene.togishi.samples = samples
    # The reference beside each picture looks at points, not at pixels.
    scene.togishi.filter_highlights = False
    if engine == "CYCLES":
        scene.cycles.samples, scene.cycles.use_denoising = samples, False
        scene.cycles.use_adaptive_sampling = False
    elif engine != "TOGISHI":
        scene.eevee.taa_render_samples = samples
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
    path = folder / "shot.exr"
    render.filepath = str(path)
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    seconds = time.perf_counter() - start
    image = bpy.data.images.load(str(path))
    try:
        values = np.empty(size[0] * size[1] * 4, np.float32)
        image.pixels.foreach_get(values)
    finally:
        bpy.data.images.remove(image)
        path.unlink()
    values = values.reshape(size[1], size[0], 4)
    return Shot(values[..., :3], values[..., 3], seconds)


@dataclass(frozen=True)
class Comparison:
    """The GPU's picture beside the reference's, one sample per pixel; delta_e is NaN off the steel."""

    rgb: np.ndarray
    reference_rgb: np.ndarray
    steel: np.ndarray
    delta_e: np.ndarray
    gpu_seconds: float
    reference_seconds: float

    @property
    def worst(self) -> float:
        return float(np.nanmax(self.delta_e))

    @property
    def mean(self) -> float:
        return float(np.nanmean(self.delta_e))


def _camera(scene: bpy.types.Scene, size: tuple[int, int]) -> Camera:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = scene.camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1])
    return Camera(
        np.linalg.inv(np.array(scene.camera.matrix_world, float)), np.array(projection, float)
    )


def compare(scene: bpy.types.Scene, size: tuple[int, int]) -> Comparison:
    """The viewport's renderer against the plain 61-wavelength double-precision sum, pixel by pixel.

    Lab under the D65 white, with the 99th percentile of the steel's luminance at 1.
    """
    sync = SceneSync()
    data = sync.update(bpy.context.evaluated_depsgraph_get())
    if sync.messages:
        raise RuntimeError("; ".join(sync.messages))
    camera, renderer = _camera(scene, size), Renderer()
    read_texture(renderer.draw(data, camera, size, float32=True).colour)  # compiles the programs
    start = time.perf_counter()
    rgb = read_texture(renderer.draw(data, camera, size, float32=True).colour)[..., :3]
    gpu_seconds = time.perf_counter() - start
    gbuffer = renderer.gbuffer(data, camera, size)
    start = time.perf_counter()
    reference = reference_picture(data, camera, gbuffer)
    reference_seconds = time.perf_counter() - start
    steel = ~np.isnan(reference[..., 1])
    if not steel.any():
        raise RuntimeError("no steel in the picture: nothing was compared")
    xyz = to_xyz(rgb, "rec709")
    scale = max(float(np.percentile(reference[steel, 1], 99.0)), 1e-30)
    white = togishi_core.light_rgb("D65", "cie1931_2", "xyz")
    delta_e = np.full(steel.shape, np.nan)
    delta_e[steel] = togishi_core.delta_e00(
        np.ascontiguousarray(xyz[steel] / scale),
        np.ascontiguousarray(reference[steel] / scale),
        white,
    )
    to_rgb = togishi_core.xyz_to_rgb("rec709")
    reference_rgb = np.where(steel[..., None], np.nan_to_num(reference) @ to_rgb.T, rgb)
    return Comparison(rgb, reference_rgb, steel, delta_e, gpu_seconds, reference_seconds)


def close() -> None:
    """bpy 4.5 hangs at its end while classes with menus made at run time are registered."""
    import togishi

    togishi.unregister()
