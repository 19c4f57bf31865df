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

# A picture shows what the build draws where all but one in a hundred of the check's pixels agree with it to this, in
# sRGB values of 0 to 1. JPEG, fewer samples and coarser maps make up to .08; another style of hamon makes .3, tungsten
# light in place of daylight .2.
CHECK_SCALE = 4
CHECK_LIMIT = 0.12


@dataclass(frozen=True)
class Size:
    """What the check makes smaller: pixels of a picture, samples of a pixel, texels of the maps."""

    scale: int = 1

    def picture(self, width: int, height: int) -> tuple[int, int]:
        return width // self.scale, height // self.scale

    @property
    def samples(self) -> int:
        return 16 if self.scale == 1 else 4

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
    room: float = 0.04,
) -> None:
    """A row of points in place of a soft box, over this stretch of the blade, so far off the mirror direction; together
    1 W. room: radiance of the surroundings."""
    from togishi import light_rig
    from togishi.core.light_presets import Lamp, LightPreset

    scene = bpy.context.scene
    # The room is mirrored in the blade, but the picture's ground stays black.
    scene.render.film_transparent = True
    light_rig.clear(scene)
    frame = light_rig.frame_of(blade, scene.camera.matrix_world.to_3x3().col[2])
    ends = [
        (blade.matrix_world @ Vector((1e-3 * x, 0.0, 0.0)) - frame.middle).dot(frame.along)
        / frame.half_length
        for x in along_mm
    ]
    row = tuple(
        Lamp(f"Lamp {i}", "POINT", float(place), off_mirror_deg, 1.6, 1.0 / lamps, spectrum)
        for i, place in enumerate(np.linspace(*ends, lamps))
    )
    light_rig.add_lamps(scene, blade, LightPreset("GUIDE", "Guide", "", row, room))
    scene.world.togishi.kind = spectrum


# --- the pictures ---------------------------------------------------------------------------------


def first_sword(blade: bpy.types.Object, _size: Size) -> None:
    look_at(blade, 262.0, 1010.0)
    bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")


def hamon_at(off_mirror_deg: float) -> Callable[[bpy.types.Object, Size], None]:
    def build(blade: bpy.types.Object, _size: Size) -> None:
        look_at(blade, 430.0, 96.0)
        soft_box(blade, off_mirror_deg, (350.0, 510.0))

    return build


def under(spectrum: str) -> Callable[[bpy.types.Object, Size], None]:
    def build(blade: bpy.types.Object, _size: Size) -> None:
        look_at(blade, 560.0, 400.0)
        soft_box(blade, 8.0, (330.0, 800.0), spectrum=spectrum, lamps=31, room=0.01)

    return build


def style(hamon: str) -> Callable[[bpy.types.Object, Size], None]:
    """Without hadori: it would cover what is to be compared."""

    def build(blade: bpy.types.Object, size: Size) -> None:
        blade.active_material.togishi.pattern.hadori = 0.0
        bake(blade, size, hamon)
        look_at(blade, 430.0, 110.0)
        soft_box(blade, 11.0, (340.0, 520.0))

    return build


@dataclass(frozen=True)
class Picture:
    """percentile: of the lit blade's luminance, exposed to 1.3 (AgX shows that just below white); 0: as it is, without
    an exposure of its own. Pictures that are to be compared share the exposure of the first of their group."""

    name: str
    size: tuple[int, int]
    build: Callable[[bpy.types.Object, Size], None]
    percentile: float = 98.0
    group: str = ""


ALL = (
    Picture("first_sword", (960, 200), first_sword, 0.0),
    *(
        Picture(f"hamon_{name}", (960, 320), hamon_at(angle))
        for name, angle in (("off", 11.0), ("between", 5.0), ("mirror", 0.0))
    ),
    *(
        Picture(f"light_{name}", (960, 160), under(name), group="light")
        for name in ("D65", "A", "LPS")
    ),
    *(
        Picture(f"hamon_{name}", (960, 260), style(name), group="style")
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
    if not picture.percentile:
        exposures[group] = 0.0
    elif group not in exposures:
        values = luminance(folder / f".{picture.name}.exr")
        lit = values[values > 0.02 * values.max()]
        exposures[group] = math.log2(1.3 / float(np.percentile(lit, picture.percentile)))
    scene.view_settings.exposure = exposures[group]
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.quality = "JPEG", "RGB", JPEG_QUALITY
    path, temporary = folder / f"{picture.name}.jpg", folder / f".{picture.name}.jpg"
    bpy.data.images["Render Result"].save_render(str(temporary), scene=scene)
    temporary.replace(path)
    return path


# Panels, from the screenshots that `make test-window` leaves: (picture, screenshot, rows from the top that are shown).
WINDOW = ROOT / "out" / "window"
PANELS = (
    ("panel_sidebar", "sidebar_first", 730),
    ("panel_material", "open_material", 640),
    ("panel_photographs", "sidebar_photographs", 770),
)


def crop_panels(folder: Path) -> None:
    """Where there are screenshots; else the pictures stay as they are."""
    for name, source, rows in PANELS:
        shot = WINDOW / f"{source}.png"
        if not shot.is_file():
            print(f"{name}: left as it is; `make test-window` takes the screenshot", flush=True)
            continue
        values = np.ascontiguousarray(pixels(shot)[-rows:])
        values[..., 3] = 1.0
        image = bpy.data.images.new(name, values.shape[1], values.shape[0])
        image.pixels.foreach_set(values.reshape(-1))
        image.file_format = "PNG"
        path, temporary = folder / f"{name}.png", folder / f".{name}.png"
        image.save(filepath=str(temporary))
        temporary.replace(path)
        bpy.data.images.remove(image)
        print(f"{name}: {path.stat().st_size / 1000:.0f} kB", flush=True)


def smoothed(values: np.ndarray) -> np.ndarray:
    """Means of 3 x 3: the reconstruction filter is as wide in pixels in small pictures as in large ones."""
    height, width = values.shape[:2]
    return sum(
        values[y : height - 2 + y, x : width - 2 + x] for y in range(3) for x in range(3)
    ) * np.float32(1.0 / 9.0)


def difference(shown: Path, made: Path) -> float:
    """99th percentile of the sRGB values' difference, the guide's picture averaged over the check's pixels."""
    small, large = pixels(made)[..., :3], pixels(shown)[..., :3]
    height, width = small.shape[:2]
    if large.shape[0] // height != CHECK_SCALE or large.shape[1] // width != CHECK_SCALE:
        return math.inf
    blocks = large[: height * CHECK_SCALE, : width * CHECK_SCALE]
    mean = blocks.reshape(height, CHECK_SCALE, width, CHECK_SCALE, 3).mean(axis=(1, 3))
    return float(np.percentile(np.abs(smoothed(mean) - smoothed(small)), 99.0))


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
            note = f"{path.stat().st_size / 1000:.0f} kB, {bpy.context.scene.view_settings.exposure:+.1f} stops"
            if options.check:
                shown = options.out / path.name
                apart = difference(shown, path) if shown.is_file() else math.inf
                note = f"{apart:.4f} of {CHECK_LIMIT}"
                if not apart <= CHECK_LIMIT:
                    stale.append(picture.name)
            print(f"{picture.name}: {note}, {time.perf_counter() - began:.1f} s", flush=True)
    if not options.check:
        crop_panels(options.out)
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
