"""Two image libraries and our module in one process. exchange.py REPORT ZIP ORDER

ORDER "blender-first": Blender has read and written an EXR and drawn with Cycles (its own OpenImageIO, OpenEXR and TBB are
in use) before PyPI's openimageio is loaded; "openimageio-first": PyPI's has written one before Blender is loaded.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ORDER = sys.argv[3]
SIZE = (12, 7)  # width, height


def sample(channels: int, seed: int) -> np.ndarray:
    """(height, width, channels) float32 over the whole range of half floats' exponents, negative values too."""
    random = np.random.default_rng(seed)
    shape = (SIZE[1], SIZE[0], channels)
    return (random.normal(size=shape) * 10.0 ** random.integers(-4, 4, shape)).astype(np.float32)


def write_with_openimageio(path: Path, pixels: np.ndarray) -> None:
    """Rows from the bottom, as Blender has them."""
    import OpenImageIO

    spec = OpenImageIO.ImageSpec(SIZE[0], SIZE[1], pixels.shape[2], "float")
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(pixels[::-1])), output.geterror()
    assert output.close()


def read_with_openimageio(path: Path) -> tuple[list[str], np.ndarray]:
    import OpenImageIO

    source = OpenImageIO.ImageInput.open(str(path))
    assert source is not None, OpenImageIO.geterror()
    names = list(source.spec().channelnames)
    pixels = source.read_image("float")
    source.close()
    return names, np.asarray(pixels, np.float32)[::-1]


def read_with_blender(path: Path) -> np.ndarray:
    image = bpy.data.images.load(str(path), check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    pixels = np.empty(SIZE[0] * SIZE[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(SIZE[1], SIZE[0], 4)


here = Path.home()
rgba = sample(4, seed=1)
theirs = here / "openimageio.exr"
if ORDER == "openimageio-first":
    write_with_openimageio(theirs, rgba)

import bpy  # noqa: E402 - the order is what is tested
from extension import ARGUMENTS, add_katana, install, part, problem, report  # noqa: E402

if ORDER == "blender-first":
    image = bpy.data.images.new("first", *SIZE, alpha=True, float_buffer=True, is_data=True)
    image.pixels.foreach_set(rgba.reshape(-1))
    image.file_format = "OPEN_EXR"
    image.save(filepath=str(here / "first.exr"))
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.render.resolution_x = scene.render.resolution_y = 16
    bpy.ops.render.render()
    assert "OpenImageIO" not in sys.modules
    write_with_openimageio(theirs, rgba)

report(said=install(ARGUMENTS[0]), problem=problem())
import OpenImageIO  # noqa: E402
import togishi_core  # noqa: E402

report(module=togishi_core.__file__, openimageio=OpenImageIO.__file__)
report(polygons=len(add_katana().data.polygons))

# The same file, read by both.
by_blender, by_openimageio = read_with_blender(theirs), read_with_openimageio(theirs)[1]
report(theirs=bool(np.array_equal(by_blender, rgba) and np.array_equal(by_openimageio, rgba)))

# What the add-on writes: named channels through an OpenImageIO, and the pair through Blender's own library.
map_files, map_channels = part("map_files"), part("core.map_channels")
names = (*map_channels.LOBES, *map_channels.SHAPE)
# Within what a map may hold: shares and squeezes from 0 to .5. Other values are mended on the way, with a warning.
values = np.abs(sample(len(names), seed=2)) % np.float32(0.5)
maps = {name: np.ascontiguousarray(values[..., index]) for index, name in enumerate(names)}
report(uses=map_files.open_image_io().__file__)
(named,) = map_files.save(maps, here / "maps.exr")
found, pixels = read_with_openimageio(named)
order = [found.index(name) for name in names]
report(named=bool(np.array_equal(pixels[..., order], values)))
pair = map_files._save_pair(maps, here / "pair.exr")
report(
    pair=all(
        np.array_equal(read_with_openimageio(path)[1], read_with_blender(path)) for path in pair
    )
)
for what, back in (
    ("named", map_files.load(named)),
    ("pair", map_files._load_pair(here / "pair.exr")),
):
    same = back.keys() == maps.keys() and all(np.array_equal(back[key], maps[key]) for key in maps)
    report(**{f"{what}_back": bool(same)})
# Our module's threads beside theirs, and its exceptions across them.
pattern = togishi_core.steel_pattern(
    togishi_core.katana_defaults("shinogi"), togishi_core.default_material(), {}, 256, 64
)
report(pattern=all(bool(np.isfinite(values).all()) for values in pattern.values()))
try:
    togishi_core.load_material(str(here / "none.toml"))
except (togishi_core.InputError, OSError) as error:
    report(refused=str(error))
