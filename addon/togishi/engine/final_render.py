"""A final picture: samples gathered in float32, in tiles no larger than a GPU's textures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ..core.sampling import pixel_offsets
from ..core.scene_data import Camera, SceneData
from .camera_read import Region, crop
from .renderer import Gathering, Renderer, lod_bias_of, read_texture

MAX_SAMPLES = 64
TILE = 4096


@dataclass
class FinalPicture:
    """Rows from the bottom, float32."""

    colour: np.ndarray  # (H, W, 4) scene-linear, premultiplied alpha
    depth: np.ndarray | None  # (H, W, 1)
    part: np.ndarray | None  # (H, W, 1)


def _tiles(region: Region) -> Iterator[Region]:
    for y in range(region.y, region.y + region.height, TILE):
        for x in range(region.x, region.x + region.width, TILE):
            width = min(TILE, region.x + region.width - x)
            height = min(TILE, region.y + region.height - y)
            yield Region(x, y, width, height)


def render_final(
    renderer: Renderer,
    scene: SceneData,
    camera: Camera,
    size: tuple[int, int],
    region: Region,
    *,
    samples: int,
    filter_width: float = 1.5,
    depth: bool = False,
    part: bool = False,
    progress: Callable[[float], bool] = lambda _share: True,
) -> FinalPicture | None:
    """`region` of a picture of `size` pixels. The same scene gives the same picture, bit for bit.

    samples: 1 to 64 per pixel; progress: called with the share done, returns whether to go on; the
    result is None where it said no.
    """
    samples = min(max(samples, 1), MAX_SAMPLES)
    offsets = pixel_offsets(samples, filter_width)
    result = FinalPicture(
        np.zeros((region.height, region.width, 4), np.float32),
        np.zeros((region.height, region.width, 1), np.float32) if depth else None,
        np.zeros((region.height, region.width, 1), np.float32) if part else None,
    )
    tiles = list(_tiles(region))
    steps = len(tiles) * samples
    done = 0
    for tile in tiles:
        tile_size = (tile.width, tile.height)
        tile_camera = Camera(camera.view, crop(camera.projection, size, tile))
        gathering = Gathering(renderer, tile_size)
        for number, (x, y) in enumerate(offsets.tolist()):
            picture = renderer.draw(
                scene,
                tile_camera,
                tile_size,
                jitter=(x, y),
                float32=True,
                lod_bias=lod_bias_of(samples),
                series=(number, samples),
            )
            gathering.add(picture, 1.0 / samples)
            done += 1
            if not progress(done / steps):
                return None
        rows = slice(tile.y - region.y, tile.y - region.y + tile.height)
        columns = slice(tile.x - region.x, tile.x - region.x + tile.width)
        result.colour[rows, columns] = gathering.read()
        if depth or part:
            aux = renderer.draw_aux(scene, tile_camera, tile_size)
            if result.depth is not None:
                result.depth[rows, columns] = read_texture(aux.depth)
            if result.part is not None:
                result.part[rows, columns] = read_texture(aux.part)
    return result
