"""The user guide's pictures, made by the current build: `make docs-pictures`.

    python blend_files/docs_pictures.py                 makes them all in docs/guide/pictures
    python blend_files/docs_pictures.py --only hamon_   those whose name begins so
    python blend_files/docs_pictures.py --check         makes them again at a quarter of the size and compares

--check ends with 1 where a picture no longer shows what the build draws (tests/blender/test_docs_pictures.py).
Runs with the bpy wheel, PYTHONPATH=addon.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import stage
from mathutils import Vector

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "guide" / "pictures"
JPEG_QUALITY = 90

# A picture shows what the build draws where its sRGB values, in blocks of the check's pixels, differ by no more than
# this in the mean. JPEG, fewer samples and coarser maps make .004 to .012; another hamon makes .05.
CHECK_SCALE = 4
CHECK_LIMIT = 0.02


@dataclass(frozen=True)
class Size:
    """What the check makes smaller: pixels of a picture, samples of a pixel, texels of the maps."""

    scale: int = 1

    def picture(self, width: int, height: int) -> tuple[int, int]:
        return width // self.scale, height // self.scale

    @property
    def samples(self) -> int:
        return 32 if self.scale == 1 else 8

    @property
    def texels(self) -> tuple[int, int]:
        return 8192 // self.scale, 1024 // self.scale


# --- the scene ------------------------------------------------------------------------------------


def add_blade(size: Size, hamon: str = "gunome", seed: int = 7) -> bpy.types.Object:
    """A katana as the guide turns it: edge up, omote to the front, the tip to the right."""
    bpy.ops.mesh.togishi_katana_add(preset="KATANA", with_pattern=False)
    blade = bpy.context.active_object
    blade.rotation_euler = (math.pi, 0.0, 0.0)
    bpy.context.view_layer.update()
    bake(blade, size, hamon, seed)
    return blade


def bake(blade: bpy.types.Object, size: Size, hamon: str, seed: int = 7) -> None:
    pattern = blade.active_material.togishi.pattern
    pattern.hamon, pattern.seed = hamon, seed
    pattern.width_px, pattern.height_px = size.texels
    bpy.ops.material.togishi_pattern_bake()


def look_at(blade: bpy.types.Object, middle_mm: float, width_mm: float) -> None:
    """The camera before the blade (-y), with a long lens, the middle of its width in the middle of the picture."""
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
    camera = scene.camera
    camera.data.lens, camera.data.clip_start = 200.0, 0.05
    places = np.empty(len(blade.data.vertices) * 3)
    blade.data.vertices.foreach_get("co", places)
    places = places.reshape(-1, 3)
    near = places[np.abs(places[:, 0] - 1e-3 * middle_mm) < 4e-3]
    across = 0.5 * (near[:, 2].min() + near[:, 2].max())
    target = blade.matrix_world @ Vector((1e-3 * middle_mm, 0.0, across))
    camera.location = target + Vector(
        (0.0, -1e-3 * width_mm * camera.data.lens / camera.data.sensor_width, 0.0)
    )
    camera.rotation_euler = (0.5 * math.pi, 0.0, 0.0)
    bpy.context.view_layer.update()


def soft_box(
    blade: bpy.types.Object,
    off_mirror_deg: float,
    along_mm: tuple[float, float],
    *,
    spectrum: str = "D65",
    lamps: int = 21,
    room: float = 0.0,
) -> None:
    """A row of points in place of a soft box, over this stretch of the blade, so far off the mirror direction."""
    from togishi import light_rig
    from togishi.core.light_presets import Lamp, LightPreset

    scene = bpy.context.scene
    light_rig.clear(scene)
    frame = light_rig.frame_of(blade, scene.camera.matrix_world.to_3x3().col[2])
    ends = [
        (blade.matrix_world @ Vector((1e-3 * x, 0.0, 0.0)) - frame.middle).dot(frame.along)
        / frame.half_length
        for x in along_mm
    ]
    row = tuple(
        Lamp(f"Lamp {i}", "POINT", float(place), off_mirror_deg, 1.6, 10.0 / lamps, spectrum)
        for i, place in enumerate(np.linspace(*ends, lamps))
    )
    light_rig.add_lamps(scene, blade, LightPreset("GUIDE", "Guide", "", row, room))


# --- the pictures ---------------------------------------------------------------------------------


def first_sword(blade: bpy.types.Object, _size: Size) -> None:
    look_at(blade, 262.0, 1010.0)
    bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")


def hamon_at(off_mirror_deg: float) -> Callable[[bpy.types.Object, Size], None]:
    def build(blade: bpy.types.Object, _size: Size) -> None:
        look_at(blade, 430.0, 96.0)
        soft_box(blade, off_mirror_deg, (350.0, 510.0), room=0.02)

    return build


def under(spectrum: str) -> Callable[[bpy.types.Object, Size], None]:
    def build(blade: bpy.types.Object, _size: Size) -> None:
        look_at(blade, 560.0, 400.0)
        soft_box(blade, 7.0, (330.0, 800.0), spectrum=spectrum, lamps=31)

    return build


def style(hamon: str) -> Callable[[bpy.types.Object, Size], None]:
    def build(blade: bpy.types.Object, size: Size) -> None:
        bake(blade, size, hamon)
        look_at(blade, 430.0, 140.0)
        soft_box(blade, 8.0, (330.0, 530.0))

    return build


@dataclass(frozen=True)
class Picture:
    """exposure: the percentile of the blade's luminance that is shown at .7 of white; several pictures that are to be
    compared share that of the first of their group."""

    name: str
    size: tuple[int, int]
    build: Callable[[bpy.types.Object, Size], None]
    percentile: float = 99.5
    group: str = ""


ALL = (
    Picture("first_sword", (960, 240), first_sword),
    *(
        Picture(f"hamon_{name}", (960, 320), hamon_at(angle), 99.0)
        for name, angle in (("off", 11.0), ("between", 5.0), ("mirror", 0.0))
    ),
    *(
        Picture(f"light_{name}", (960, 160), under(name), 99.5, "light")
        for name in ("D65", "A", "LPS")
    ),
    *(
        Picture(f"hamon_{name}", (960, 240), style(name), 99.0, "style")
        for name in ("suguha", "notare", "gunome", "choji")
    ),
)


def luminance(path: Path) -> np.ndarray:
    """Of the last render, scene-linear."""
    scene = bpy.context.scene
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    bpy.data.images["Render Result"].save_render(str(path), scene=scene)
    values = pixels(path)[..., :3]
    path.unlink()
    return values @ np.array([0.2126, 0.7152, 0.0722], np.float32)


def pixels(path: Path) -> np.ndarray:
    """(H, W, 4) as the file has them: sRGB values of a JPEG, linear ones of an EXR."""
    image = bpy.data.images.load(str(path), check_existing=False)
    try:
        values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
        image.pixels.foreach_get(values)
        return values.reshape(image.size[1], image.size[0], 4)
    finally:
        bpy.data.images.remove(image)


def make(
    picture: Picture, blade: bpy.types.Object, size: Size, folder: Path, exposures: dict[str, float]
) -> Path:
    """Render and save one picture, exposed as an eye would."""
    scene = stage.picture(*size.picture(*picture.size), samples=size.samples)
    picture.build(blade, size)
    bpy.ops.render.render(write_still=False)
    group = picture.group or picture.name
    if group not in exposures:
        values = luminance(folder / f".{picture.name}.exr")
        lit = values[values > 0.02 * values.max()]
        exposures[group] = math.log2(0.7 / float(np.percentile(lit, picture.percentile)))
    scene.view_settings.exposure = exposures[group]
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.quality = "JPEG", "RGB", JPEG_QUALITY
    path, temporary = folder / f"{picture.name}.jpg", folder / f".{picture.name}.jpg"
    bpy.data.images["Render Result"].save_render(str(temporary), scene=scene)
    temporary.replace(path)
    return path


def difference(shown: Path, made: Path) -> float:
    """Mean difference of the sRGB values, the guide's picture averaged over the check's pixels."""
    small, large = pixels(made)[..., :3], pixels(shown)[..., :3]
    height, width = small.shape[:2]
    if large.shape[0] // height != CHECK_SCALE or large.shape[1] // width != CHECK_SCALE:
        return math.inf
    blocks = large[: height * CHECK_SCALE, : width * CHECK_SCALE]
    mean = blocks.reshape(height, CHECK_SCALE, width, CHECK_SCALE, 3).mean(axis=(1, 3))
    return float(np.abs(mean - small).mean())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=PICTURES)
    parser.add_argument("--only", default="", metavar="PREFIX")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    size = Size(CHECK_SCALE if options.check else 1)
    chosen = [picture for picture in ALL if picture.name.startswith(options.only)]
    stage.start()
    blade = add_blade(size)
    stale, exposures = [], {}
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        for picture in chosen:
            began = time.perf_counter()
            folder = Path(scratch) if options.check else options.out
            path = make(picture, blade, size, folder, exposures)
            note = f"{path.stat().st_size / 1000:.0f} kB"
            if options.check:
                shown = options.out / path.name
                apart = difference(shown, path) if shown.is_file() else math.inf
                note = f"{apart:.4f} of {CHECK_LIMIT}"
                if not apart <= CHECK_LIMIT:
                    stale.append(picture.name)
            print(f"{picture.name}: {note}, {time.perf_counter() - began:.1f} s", flush=True)
    import togishi

    togishi.unregister()
    if stale:
        print(
            f"docs_pictures: {', '.join(stale)}: no longer what the build draws. Look at them, then: make docs-pictures",
            file=sys.stderr,
        )
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
