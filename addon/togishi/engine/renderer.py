"""Draws a scene (core/scene_data.py) with the `gpu` module. Knows nothing of Blender's scene or windows.

One Renderer belongs to one viewport or one final render and owns all its GPU objects. It uploads what
changed since the picture before and nothing else; `counters` says what that was.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields, replace
from typing import TypeVar

import gpu
import numpy as np
from gpu.types import (
    GPUBatch,
    GPUFrameBuffer,
    GPUIndexBuf,
    GPUShader,
    GPUTexture,
    GPUVertBuf,
    GPUVertFormat,
)

from ..core import lamp_pictures, pace, packing, shader_source, surroundings
from ..core.casters import Casters, Tree, casters_block, casters_of, texels_of, tree_of
from ..core.packing import LightPass, ViewSpace
from ..core.sampling import pixel_offsets
from ..core.scene_data import (
    BladeMaterial,
    Camera,
    Environment,
    Instance,
    LampPicture,
    MapData,
    MeshData,
    NormalMapData,
    PlainMaterial,
    SceneData,
    SteelMaterial,
)
from ..core.shader_source import LightVariant, ProgramSource, SteelVariant
from ..core.tables import Tables
from .programs import Block, build, float_buffer

_Maps = TypeVar("_Maps")
_OnGpu = TypeVar("_OnGpu")

_ROWS = ("model_0", "model_1", "model_2")
# Blender writes this depth where nothing is.
FAR_DEPTH = 1.0e10
# Slices of the lobe for each lamp of a size; their errors and times: docs/light.md.
MOVING_SLICES = 4
RESTING_SLICES = 16
# Rays to each lamp of a size from a point of a matt surface: while something moves, and at rest where no more samples follow.
MOVING_RAYS = 4
RESTING_RAYS = 16


@dataclass
class Counters:
    """What a Renderer has done so far."""

    pictures: int = 0
    mesh_uploads: int = 0
    map_uploads: int = 0
    block_uploads: int = 0
    block_bytes: int = 0
    programs_built: int = 0
    draw_calls: int = 0
    light_passes: int = 0

    def since(self, before: Counters) -> Counters:
        return Counters(*(getattr(self, f.name) - getattr(before, f.name) for f in fields(self)))

    def copy(self) -> Counters:
        return Counters(*(getattr(self, f.name) for f in fields(self)))


@dataclass
class Picture:
    """Textures of the last draw, valid until the next one of the same Renderer."""

    size: tuple[int, int]
    colour: GPUTexture  # scene-linear, premultiplied alpha
    framebuffer: GPUFrameBuffer

    def read(self) -> np.ndarray:
        """(height, width, 4), rows from the bottom; waits for the GPU."""
        return read_texture(self.colour)


@dataclass
class AuxPicture:
    """Depth and part id at the pixels' centres."""

    size: tuple[int, int]
    depth: GPUTexture  # R32F, along the view axis; FAR_DEPTH where nothing is
    part: GPUTexture  # R32F, part id; 0 for what is no blade
    framebuffer: GPUFrameBuffer


@dataclass
class _Targets:
    """All textures of one size: the picture, and what the two halves of the steel share."""

    colour: GPUTexture
    depth: GPUTexture
    picture: GPUFrameBuffer
    buffers: dict[str, GPUTexture]
    surface: GPUFrameBuffer | None


@dataclass
class _GpuMesh:
    data: MeshData
    low: np.ndarray
    high: np.ndarray
    batches: dict[tuple[int, bool], GPUBatch] = field(default_factory=dict)


@dataclass
class _GpuMaps:
    data: MapData  # what is in the textures: without the levels that the GPU has no texture for
    lobes: GPUTexture
    shape: GPUTexture | None


@dataclass
class _GpuNormalMap:
    data: NormalMapData  # what is in the textures, as _GpuMaps has it
    leans: GPUTexture
    correlations: GPUTexture


@dataclass
class _GpuEnvironment:
    data: Environment
    atlas: surroundings.Atlas
    texture: GPUTexture


@dataclass(frozen=True, eq=False)
class _SteelItem:
    instance: Instance
    mesh: _GpuMesh
    batch: GPUBatch
    program: ProgramSource  # first half
    own: int  # number among the casters, -1 for none


@dataclass(frozen=True, eq=False)
class _Steel:
    """One steel of the picture: a material on meshes with the same attributes."""

    number: int
    key: str
    material: SteelMaterial
    variant: SteelVariant
    program: ProgramSource  # second half
    items: tuple[_SteelItem, ...]


@dataclass(frozen=True, eq=False)
class _PlainItem:
    instance: Instance
    batch: GPUBatch
    key: str
    material: PlainMaterial
    program: ProgramSource
    own: int = -1  # of a blade's nakago: the blade's number among the casters


@dataclass(frozen=True, eq=False)
class _Traced:
    """What rays may meet, on the GPU."""

    casters: Casters = field(default_factory=Casters)
    meshes: tuple[MeshData, ...] = ()
    place_of: dict[int, tuple[int, int, int]] = field(default_factory=dict)  # by id of the mesh
    texture: GPUTexture | None = None
    places: tuple[tuple[int, int, int], ...] = ()  # of each caster's tree


@dataclass(frozen=True)
class Gbuffer:
    """What the GPU's second half computes from, float32, rows from the bottom. View space: the viewer is the
    origin, looks along -z. Azimuths of the lobes are from `tangent`, as everywhere."""

    covered: np.ndarray  # (H, W) bool: polished steel
    normal: np.ndarray  # (H, W, 3) unit
    tangent: np.ndarray  # (H, W, 3) unit, perpendicular to the normal
    view: np.ndarray  # (H, W, 3) unit, to the viewer
    position: np.ndarray  # (H, W, 3)
    lobe_ji: np.ndarray  # (H, W, 3) encoded
    lobe_hadori: np.ndarray  # (H, W, 3) encoded
    lobe_ha: np.ndarray  # (H, W, 3) encoded
    w: np.ndarray  # (H, W)
    h: np.ndarray  # (H, W)
    part: np.ndarray  # (H, W) int
    steel: np.ndarray  # (H, W) int: index in `materials`
    materials: tuple[str, ...]  # keys in SceneData.materials
    directions: np.ndarray  # (H, W, lamps of the first pass, 3) unit, to each lamp


def read_texture(texture: GPUTexture) -> np.ndarray:
    """(height, width, channels) float32, rows from the bottom."""
    buffer = texture.read()
    channels = {"R": 1, "RG": 2, "RGBA": 4}[texture.format.rstrip("F0123456789")]
    buffer.dimensions = texture.width * texture.height * channels
    return np.array(buffer, np.float32).reshape(texture.height, texture.width, channels)


def steel_variant(
    material: SteelMaterial, mesh: MeshData, *, filtered: bool = False
) -> SteelVariant:
    """What a blade needs: maps only where mesh and material have them, and so on."""
    maps = material.maps if mesh.uv is not None else None
    anisotropic = material.anisotropic
    normal_map = (
        material.normal_map is not None and mesh.uv is not None and mesh.tangent is not None
    )
    return SteelVariant(
        maps=maps is not None,
        shape=maps is not None and maps.shape is not None and anisotropic,
        hadori=maps is not None and maps.hadori,
        anisotropic=anisotropic,
        tangent=(anisotropic or normal_map) and mesh.tangent is not None,
        filtered=filtered,
        normal_map=normal_map,
    )


class Renderer:
    """Draws SceneData. Every call needs an active GPU context."""

    def __init__(self) -> None:
        self.counters = Counters()
        self.tables = Tables()
        self.wavelengths: np.ndarray | None = None  # TgWavelengths, for bench_61 only
        self._programs: dict[ProgramSource, GPUShader] = {}
        self._meshes: dict[str, _GpuMesh] = {}
        self._maps: dict[int, tuple[MapData, _GpuMaps]] = {}
        self._normal_maps: dict[int, tuple[NormalMapData, _GpuNormalMap]] = {}
        self._blocks: dict[tuple[object, ...], Block] = {}
        self._targets: dict[tuple[object, ...], _Targets] = {}
        self._largest_texture = int(gpu.capabilities.max_texture_size_get())
        self._rect: GPUBatch | None = None
        self._steels: list[_Steel] = []
        self._plains: list[_PlainItem] = []
        self._passes: list[LightPass] = []
        self._has_areas = False
        self._environment: _GpuEnvironment | None = None
        self._trees: dict[int, tuple[MeshData, Tree]] = {}
        self._traced = _Traced()
        self._pictures: tuple[LampPicture, ...] = ()
        self._picture_atlas: GPUTexture | None = None
        self._unhung: list[str] = []
        self._slices = RESTING_SLICES
        self._series = (0, 1)
        self._rays = (0, 0)
        self._prepared: tuple[object, ...] = ()

    # --- pictures -------------------------------------------------------------------------------

    def draw(
        self,
        scene: SceneData,
        camera: Camera,
        size: tuple[int, int],
        *,
        jitter: tuple[float, float] = (0.0, 0.0),
        float32: bool = False,
        lod_bias: float = 0.0,
        bench_61: bool = False,
        every_lamp: bool = False,
        moving: bool = False,
        series: tuple[int, int] = (0, 1),
        added: tuple[int, int] = (0, 1),
    ) -> Picture:
        """Colour (half float, or float32) of one sample per pixel. Leaves the GPU state as it found it.

        lod_bias: added to the level of maps; -log2(samples)/2 where samples are gathered. Highlights are filtered over as
        much less of a pixel.
        moving: lamps of a size by few slices of the lobe; else as they are in a final picture.
        series: number of this sample, of how many that are added up: an HDRI is then mirrored by other facets in each.
        added: the same of samples that a user watches arriving: other rays find the shadows in each.
        bench_61, every_lamp: slower ways to the same picture, for benchmarks (steel_light_program).

        Polished steel is drawn in two halves: its triangles leave normal, depth and lobes, then every pixel
        is lit once. Triangles of a scanned blade are smaller than the blocks of pixels that GPUs shade, and
        lighting them directly computes a pixel up to five times.
        """
        output_max = shader_source.FLOAT_MAX if float32 else shader_source.HALF_MAX
        self._prepare(scene, output_max, bench_61, every_lamp, moving)
        space = packing.view_space(camera, size, jitter)
        self._series = series
        number, samples = added if added[1] > 1 else series
        rays = (
            MOVING_RAYS
            if moving or samples >= RESTING_RAYS // MOVING_RAYS
            else RESTING_RAYS // samples
        )
        self._rays = (rays, number * rays)
        targets = self._targets_of(size, "RGBA32F" if float32 else "RGBA16F")
        background = self._background(scene, output_max)
        with _DrawState():
            with targets.picture.bind():
                targets.picture.clear(color=background, depth=1.0)
            self._set_frame(scene, space, 0, lod_bias)
            if self._environment is not None:
                content = packing.environment_block(scene.world, self._environment.atlas, space)
                self._set(self._block("environment"), content)
            if self._traced.texture is not None:
                content = casters_block(self._traced.casters, self._traced.places, space)
                self._set(self._block("casters"), content)
            if self._steels and targets.surface is not None:
                with targets.surface.bind():
                    self._draw_surfaces(space)
            with targets.picture.bind():
                for index in range(len(self._passes)):
                    if index:
                        self._set_frame(scene, space, index, lod_bias)
                    self._set_lights(space, index)
                    self._light_steels(scene, space, targets, index)
                for index in range(len(self._passes) if self._plains else 0):
                    if len(self._passes) > 1:
                        self._set_frame(scene, space, index, lod_bias)
                    self._draw_plains(scene, space, index)
                if self._environment is not None and not scene.transparent:
                    self._draw_background(scene, output_max)
        self.counters.pictures += 1
        return Picture(size, targets.colour, targets.picture)

    @property
    def problems(self) -> list[str]:
        """What a user should know of the last picture: what could not be drawn as the scene has it."""
        coarser = [
            f"Map of {known.levels[0][2]} x {known.levels[0][3]} texels: this GPU's textures have at most "
            f"{self._largest_texture} to a side, so {drawn.data.levels[0][2]} x {drawn.data.levels[0][3]} are drawn."
            for known, drawn in (*self._maps.values(), *self._normal_maps.values())
            if len(drawn.data.levels) < len(known.levels)
        ]
        return [
            *self.tables.problems.values(),
            *coarser,
            *self._traced.casters.left_out,
            *self._unhung,
        ]

    def prepare_lights(self, scene: SceneData) -> None:
        """Everything that a changed light costs before the next picture: its table row and its block."""
        self._prepare(scene, shader_source.HALF_MAX, False)
        for index in range(len(self._passes)):
            for metal in {steel.material.metal for steel in self._steels}:
                self._table(metal, scene, index)

    def draw_moving(
        self, scene: SceneData, camera: Camera, size: tuple[int, int], step: int
    ) -> tuple[Picture, int]:
        """A picture for while something moves, its pixels `step` of the screen's wide (copy() puts it there), and the
        step for the next one. Waits for the GPU: nothing else tells how long it took."""
        begin = time.monotonic()
        built = self.counters.programs_built
        picture = self.draw(
            scene,
            packing.coarse_camera(camera, size, step),
            pace.coarse_size(size, step),
            moving=True,
        )
        picture.framebuffer.read_color(0, 0, 1, 1, 4, 0, "FLOAT")
        if self.counters.programs_built > built:
            return picture, step  # compiling happens once
        return picture, pace.next_step(step, time.monotonic() - begin)

    def draw_aux(self, scene: SceneData, camera: Camera, size: tuple[int, int]) -> AuxPicture:
        """Depth and part id at the pixels' centres."""
        self._upload(scene)
        space = packing.view_space(camera, size)
        depth, part = GPUTexture(size, format="R32F"), GPUTexture(size, format="R32F")
        test = GPUTexture(size, format="DEPTH_COMPONENT32F")
        framebuffer = GPUFrameBuffer(color_slots=[depth, part], depth_slot=test)
        block = self._block("frame", "aux")
        self._set(block, packing.frame_block(space, (0.0, 0.0, 0.0), 0, packing.LightCounts(), 0.0))
        shader = self._shader(shader_source.aux_program())
        with framebuffer.bind(), _DrawState():
            framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            depth.clear(format="FLOAT", value=(FAR_DEPTH,))
            _solid_state()
            shader.bind()
            shader.uniform_block("frame", block.buffer)
            for instance in scene.instances:
                mesh = self._meshes[instance.mesh]
                for group in mesh.data.groups:
                    blade = isinstance(scene.material_of(instance, group.slot)[1], BladeMaterial)
                    self._push_object(shader, instance, space, 0, -1.0 if blade else 0.0)
                    unseen = _unseen_faces(mesh.data, instance.matrix) if blade else "NONE"
                    gpu.state.face_culling_set(unseen)
                    mesh.batches[group.slot, group.nakago].draw(shader)
            gpu.state.face_culling_set("NONE")
        return AuxPicture(size, depth, part, framebuffer)

    def gbuffer(self, scene: SceneData, camera: Camera, size: tuple[int, int]) -> Gbuffer:
        """What each pixel of polished steel is computed from. For accuracy tests."""
        self._prepare(scene, shader_source.FLOAT_MAX, False)
        space = packing.view_space(camera, size)
        targets = self._targets_of(size, "RGBA32F")
        names = shader_source.INPUT_TARGETS
        textures = [GPUTexture(size, format="RGBA32F") for _ in names]
        framebuffer = GPUFrameBuffer(color_slots=textures, depth_slot=targets.depth)
        self._set_frame(scene, space, 0, 0.0)
        with _DrawState():
            with framebuffer.bind():
                framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            if self._steels and targets.surface is not None:
                with targets.surface.bind():
                    self._draw_surfaces(space)
                with framebuffer.bind():
                    _screen_state()
                    for steel in self._steels:
                        source = shader_source.steel_inputs_program(
                            steel.variant, many=len(self._steels) > 1
                        )
                        self._bind_screen(source, steel, targets, (-1.0, -1.0, 1.0, 1.0))
                        self._rectangle().draw(self._shader(source))
        read = dict(zip(names, (read_texture(texture) for texture in textures), strict=True))
        if self._passes:
            self._set_lights(space, 0)
        directions = [
            self._direction_picture(targets, textures[0], targets.depth, lamp)
            for lamp in range(len(self._passes[0].lights))
        ]
        # 0: nothing there, else 1 + part + 8 steel.
        code = np.rint(read["tangent"][..., 3]).astype(np.int32) - 1
        hadori = (read["ha"][..., 3], read["normal"][..., 3], read["view"][..., 3])
        return Gbuffer(
            covered=code >= 0,
            normal=read["normal"][..., :3],
            tangent=read["tangent"][..., :3],
            view=read["view"][..., :3],
            position=read["position"][..., :3],
            lobe_ji=read["ji"][..., :3],
            lobe_hadori=np.stack(hadori, axis=-1),
            lobe_ha=read["ha"][..., :3],
            w=read["ji"][..., 3],
            h=read["position"][..., 3],
            part=np.where(code >= 0, code % 8, 0),
            steel=np.where(code >= 0, code // 8, 0),
            materials=tuple(steel.key for steel in self._steels),
            directions=np.stack(directions, axis=2)
            if directions
            else np.zeros((*code.shape, 0, 3), np.float32),
        )

    def _direction_picture(
        self, targets: _Targets, target: GPUTexture, depth: GPUTexture, lamp: int
    ) -> np.ndarray:
        """(H, W, 3): towards this lamp of the first pass."""
        framebuffer = GPUFrameBuffer(color_slots=[target], depth_slot=depth)
        with _DrawState(), framebuffer.bind():
            framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0))
            _screen_state()
            for steel in self._steels:
                source = shader_source.steel_direction_program(steel.variant)
                shader = self._bind_screen(source, steel, targets, (-1.0, -1.0, 1.0, 1.0))
                shader.uniform_block("lights", self._block("lights", 0).buffer)
                shader.uniform_float("object_state", (1.0, float(steel.number), -1.0, float(lamp)))
                self._rectangle().draw(shader)
        return read_texture(target)[..., :3]

    def copy(
        self,
        picture: GPUTexture,
        scale: float = 1.0,
        origin: tuple[int, int] = (0, 0),
        blend: str = "NONE",
        step: int = 1,
    ) -> None:
        """Put a picture, times `scale`, onto the bound framebuffer with its corner at `origin` (px). step: side of its
        pixels in those of the framebuffer."""
        shader = self._shader(shader_source.copy_program())
        gpu.state.blend_set(blend)
        gpu.state.depth_test_set("NONE")
        shader.bind()
        shader.uniform_sampler("picture", picture)
        shader.uniform_float("rect", (-1.0, -1.0, 1.0, 1.0))
        shader.uniform_float("origin", (float(origin[0]), float(origin[1]), float(step), scale))
        self._rectangle().draw(shader)
        gpu.state.blend_set("NONE")

    @property
    def program_count(self) -> int:
        """Different programs that this Renderer has compiled."""
        return len(self._programs)

    # --- drawing --------------------------------------------------------------------------------

    def _background(self, scene: SceneData, output_max: float) -> tuple[float, float, float, float]:
        if scene.transparent:
            return (0.0, 0.0, 0.0, 0.0)
        if scene.world.black or scene.world.environment is not None:
            return (0.0, 0.0, 0.0, 1.0)
        light = self.tables.light_rgb(scene.world.spectrum, scene.colour)
        red, green, blue = (
            min(max(a * b, -output_max), output_max)
            for a, b in zip(light, scene.world.radiance, strict=True)
        )
        return (red, green, blue, 1.0)

    def _set_frame(self, scene: SceneData, space: ViewSpace, index: int, lod_bias: float) -> None:
        """The block "frame" for one pass of lamps; the world belongs to the first."""
        world = scene.world.radiance if index == 0 else (0.0, 0.0, 0.0)
        counts = self._passes[index].counts
        # Twice the distance between samples, so that what is narrower than it is not missed between two.
        pixel = min(2.0 * 2.0**lod_bias, 1.0)
        content = packing.frame_block(
            space, world, 0, counts, lod_bias, self._slices, pixel, self._series, self._rays
        )
        self._set(self._block("frame"), content)

    def _set_lights(self, space: ViewSpace, index: int) -> None:
        light_pass = self._passes[index]
        self._set(self._block("lights", index), packing.lights_block(light_pass, space))
        spots = self._block("spots", index)
        if light_pass.counts.spots or not spots.made:
            self._set(spots, packing.spots_block(light_pass, space))
        things = [caster.instance for caster in self._traced.casters.casters]
        areas = self._block("areas", index)
        if light_pass.areas or (self._has_areas and not areas.made):
            self._set(areas, packing.areas_block(light_pass, space, self._pictures, things))
        self.counters.light_passes += 1

    def _bind_lights(self, shader: GPUShader, source: ProgramSource, index: int) -> None:
        names = {name for _struct, name in source.blocks}
        shader.uniform_block("frame", self._block("frame").buffer)
        shader.uniform_block("lights", self._block("lights", index).buffer)
        if "spots" in names:
            shader.uniform_block("spots", self._block("spots", index).buffer)
        if "areas" in names:
            shader.uniform_block("areas", self._block("areas", index).buffer)
        if "environment" in names:
            self._bind_environment(shader)
        if "pictures" in names:
            assert self._picture_atlas is not None
            shader.uniform_block("pictures", self._block("pictures").buffer)
            shader.uniform_sampler("pictures_atlas", self._picture_atlas)
        if "casters" in names:
            assert self._traced.texture is not None
            shader.uniform_block("casters", self._block("casters").buffer)
            shader.uniform_sampler("trees", self._traced.texture)
        if "wavelengths" in names:
            shader.uniform_block("wavelengths", self._wavelengths_block().buffer)

    def _bind_environment(self, shader: GPUShader) -> None:
        assert self._environment is not None
        shader.uniform_block("environment", self._block("environment").buffer)
        shader.uniform_sampler("environment_atlas", self._environment.texture)

    def _draw_background(self, scene: SceneData, output_max: float) -> None:
        shader = self._shader(shader_source.background_program(output_max=output_max))
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(False)
        shader.bind()
        shader.uniform_block("frame", self._block("frame").buffer)
        self._bind_environment(shader)
        light = self.tables.light_rgb(scene.world.spectrum, scene.colour)
        colour = [a * b for a, b in zip(light, scene.world.radiance, strict=True)]
        shader.uniform_float("rect", (-1.0, -1.0, 1.0, 1.0))
        shader.uniform_float("origin", (*colour, 0.0))
        self._rectangle().draw(shader)
        self.counters.draw_calls += 1

    def _draw_surfaces(self, space: ViewSpace) -> None:
        _solid_state()
        bound: ProgramSource | None = None
        for steel in self._steels:
            for item in steel.items:
                shader = self._shader(item.program)
                if item.program is not bound:
                    bound = item.program
                    shader.bind()
                    shader.uniform_block("frame", self._block("frame").buffer)
                if ("TgSteel", "steel") in item.program.blocks:
                    shader.uniform_block("steel", self._steel_block(steel).buffer)
                maps = steel.material.maps
                if steel.variant.maps and maps is not None:
                    textures = self._maps[id(maps)][1]
                    shader.uniform_sampler("lobes_atlas", textures.lobes)
                    if steel.variant.shape and textures.shape is not None:
                        shader.uniform_sampler("shape_atlas", textures.shape)
                if steel.variant.normal_map:
                    self._bind_normal_map(shader, steel)
                number = steel.number + shader_source.STEEL_CAPACITY * (item.own + 1)
                self._push_object(shader, item.instance, space, number, -1.0)
                gpu.state.face_culling_set(_unseen_faces(item.mesh.data, item.instance.matrix))
                item.batch.draw(shader)
                self.counters.draw_calls += 1
        gpu.state.face_culling_set("NONE")

    def _bind_normal_map(self, shader: GPUShader, steel: _Steel) -> None:
        maps = steel.material.normal_map
        assert maps is not None
        drawn = self._normal_maps[id(maps)][1]
        block = self._block("normal map", steel.key)
        if block.tag is not maps:
            self._set(block, packing.normal_map_block(drawn.data))
            block.tag = maps
        shader.uniform_block("normal_map", block.buffer)
        shader.uniform_sampler("leans_atlas", drawn.leans)
        shader.uniform_sampler("correlations_atlas", drawn.correlations)

    def _light_steels(
        self, scene: SceneData, space: ViewSpace, targets: _Targets, index: int
    ) -> None:
        _screen_state()
        gpu.state.blend_set("NONE" if index == 0 else "ADDITIVE")
        for steel in self._steels:
            bounds = [(item.mesh.low, item.mesh.high, item.instance.matrix) for item in steel.items]
            rect = packing.screen_rect(bounds, space)
            if rect is None:
                continue
            shader = self._bind_screen(steel.program, steel, targets, rect)
            self._bind_lights(shader, steel.program, index)
            table = self._table(steel.material.metal, scene, index)
            shader.uniform_block("table", table.buffer)
            self._rectangle().draw(shader)
            self.counters.draw_calls += 1

    def _bind_screen(
        self,
        source: ProgramSource,
        steel: _Steel,
        targets: _Targets,
        rect: tuple[float, float, float, float],
    ) -> GPUShader:
        shader = self._shader(source)
        shader.bind()
        shader.uniform_block("frame", self._block("frame").buffer)
        shader.uniform_block("steel", self._steel_block(steel).buffer)
        for _kind, name in source.samplers:
            if name.endswith("_buffer"):
                shader.uniform_sampler(name, targets.buffers[name.removesuffix("_buffer")])
        shader.uniform_float("rect", rect)
        if ("TG_MANY", "") in source.defines or source.name == "togishi_steel_inputs":
            shader.uniform_float("object_state", (1.0, float(steel.number), -1.0, 0.0))
        return shader

    def _draw_plains(self, scene: SceneData, space: ViewSpace, index: int) -> None:
        gpu.state.depth_test_set("LESS_EQUAL" if index == 0 else "EQUAL")
        gpu.state.depth_mask_set(index == 0)
        gpu.state.blend_set("NONE" if index == 0 else "ADDITIVE")
        bound: tuple[ProgramSource, PlainMaterial] | None = None
        for item in self._plains:
            if bound is None or bound[0] is not item.program:
                shader = self._shader(item.program)
                shader.bind()
                self._bind_lights(shader, item.program, index)
                shader.uniform_block("table", self._table("", scene, index).buffer)
                bound = None
            if bound is None or item.material is not bound[1]:
                bound = (item.program, item.material)
                block = self._block("plain", item.key)
                tag = (item.material, self._picture_number(item.material.picture))
                if block.tag != tag:
                    self._set(block, packing.plain_block(*tag))
                    block.tag = tag
                shader.uniform_block("plain", block.buffer)
            # What shines does so in the first pass.
            later = -1.0 if index == 0 else -2.0
            self._push_object(shader, item.instance, space, item.own + 1, later)
            item.batch.draw(shader)
            self.counters.draw_calls += 1

    def _push_object(
        self, shader: GPUShader, instance: Instance, space: ViewSpace, number: int, part: float
    ) -> None:
        rows, mirror = packing.model_rows(instance.matrix, space)
        for name, row in zip(_ROWS, rows, strict=True):
            shader.uniform_float(name, row)
        try:
            shader.uniform_float("object_state", (mirror, float(number), part, 0.0))
        except ValueError:
            # Without light and world nobody reads it, and the compiler has removed it.
            if any(light_pass.lights or light_pass.areas for light_pass in self._passes):
                raise

    def _steel_block(self, steel: _Steel) -> Block:
        block = self._block("steel", steel.key)
        if block.tag is not steel.material:
            material = steel.material
            if material.maps is not None:
                material = replace(material, maps=self._maps[id(material.maps)][1].data)
            self._set(block, packing.steel_block(material))
            block.tag = steel.material
        return block

    def _table(self, metal: str, scene: SceneData, index: int) -> Block:
        block = self._block("table", index, metal)
        spectra = self._passes[index].spectra
        tag = (spectra, scene.colour, self.tables.version)
        if block.tag != tag:
            self._set(block, packing.table_block(self.tables.rows(metal, spectra, scene.colour)))
            block.tag = tag
        return block

    def _wavelengths_block(self) -> Block:
        assert self.wavelengths is not None, "bench_61 needs Renderer.wavelengths"
        block = self._block("wavelengths")
        self._set(block, self.wavelengths)
        return block

    def _rectangle(self) -> GPUBatch:
        if self._rect is None:
            layout = GPUVertFormat()
            layout.attr_add(id="position", comp_type="F32", len=2, fetch_mode="FLOAT")
            vertices = GPUVertBuf(layout, 4)
            vertices.attr_fill("position", np.asarray([(0, 0), (1, 0), (0, 1), (1, 1)], np.float32))
            self._rect = GPUBatch(type="TRI_STRIP", buf=vertices)
        return self._rect

    # --- what a scene needs on the GPU ----------------------------------------------------------

    def _prepare(
        self,
        scene: SceneData,
        output_max: float,
        bench_61: bool = False,
        every_lamp: bool = False,
        moving: bool = False,
    ) -> None:
        """Upload what is new and list what is drawn, unless this very scene was drawn last."""
        self.tables.refresh()
        prepared = (scene, output_max, bench_61, every_lamp, moving, self.tables.version)
        if self._prepared == prepared:
            return
        self._upload(scene)
        wanted = None if scene.world.black else scene.world.environment
        if wanted is None:
            self._environment = None
        elif self._environment is None or self._environment.data is not wanted:
            self._environment = self._blurred(wanted)
        self._passes = packing.light_passes(scene.lights, scene.world)
        self._trace(casters_of(scene))
        casters = self._traced.casters
        lights = replace(
            packing.light_variant(self._passes, scene.world, fine=not moving),
            shadows=casters.shadows,
            mirrored=casters.mirrored,
        )
        self._has_areas = lights.areas
        self._slices = MOVING_SLICES if moving else RESTING_SLICES
        self._hang_pictures(lamp_pictures.pictures_of(scene.lights))
        groups: dict[tuple[str, SteelVariant], list[tuple[Instance, _GpuMesh, GPUBatch]]] = {}
        self._plains = []
        for instance in scene.instances:
            mesh = self._meshes[instance.mesh]
            for group in mesh.data.groups:
                key, material = scene.material_of(instance, group.slot)
                batch = mesh.batches[group.slot, group.nakago]
                if isinstance(material, PlainMaterial):
                    program = self._plain_program(lights, material, mesh.data, output_max)
                    self._plains.append(_PlainItem(instance, batch, key, material, program))
                elif group.nakago:
                    own = casters.number_of(instance)
                    program = self._plain_program(lights, material.nakago, mesh.data, output_max)
                    nakago = _PlainItem(
                        instance, batch, f"{key}/nakago", material.nakago, program, own
                    )
                    self._plains.append(nakago)
                else:
                    variant = steel_variant(material.steel, mesh.data, filtered=scene.filtered)
                    groups.setdefault((key, variant), []).append((instance, mesh, batch))
        self._plains.sort(key=lambda item: (item.program.defines, item.key))
        self._steels = []
        used = {name for _key, variant in groups for _format, _kind, name in variant.targets}
        layout = tuple(name for name in shader_source.STEEL_TARGETS if name in used)
        for number, ((key, variant), drawn) in enumerate(groups.items()):
            first = shader_source.steel_surface_program(variant, layout)
            items = tuple(_SteelItem(*item, first, casters.number_of(item[0])) for item in drawn)
            blade = scene.materials[key]
            assert isinstance(blade, BladeMaterial)
            second = shader_source.steel_light_program(
                lights,
                variant,
                many=len(groups) > 1,
                output_max=output_max,
                bench_61=bench_61,
                every_lamp=every_lamp,
            )
            self._steels.append(_Steel(number, key, blade.steel, variant, second, items))
        self._prepared = prepared

    def _hang_pictures(self, pictures: list[LampPicture]) -> None:
        """What rectangles shine with, in one texture that is made again only where a picture changed."""
        most = shader_source.PICTURE_CAPACITY
        hung = tuple(pictures[:most])
        self._unhung = (
            [
                f"{len(pictures)} rectangles shine with a picture; the first {most} do, the rest are white."
            ]
            if len(pictures) > most
            else []
        )
        if hung == self._pictures:
            return
        self._pictures = hung
        atlas = lamp_pictures.atlas_of(hung)
        height, width, _channels = atlas.texels.shape
        self._picture_atlas = (
            GPUTexture((width, height), format="RGBA16F", data=float_buffer(atlas.texels))
            if hung
            else None
        )
        if hung:
            self._set(self._block("pictures"), lamp_pictures.pictures_block(hung, atlas))
        self.counters.map_uploads += len(hung)

    def _picture_number(self, picture: LampPicture | None) -> int:
        """From 1; 0 where it is none of those that are hung."""
        return next((i + 1 for i, hung in enumerate(self._pictures) if hung is picture), 0)

    def _trace(self, casters: Casters) -> None:
        """The trees of what rays may meet, in one texture that is made again only where a mesh changed."""
        meshes = {id(caster.mesh): caster.mesh for caster in casters.casters}
        if self._traced.meshes != tuple(meshes.values()):
            self._trees = {
                key: self._trees.get(key) or (mesh, tree_of(mesh)) for key, mesh in meshes.items()
            }
            texels, places = texels_of([tree for _mesh, tree in self._trees.values()])
            height, width, _channels = texels.shape
            if height > self._largest_texture:
                raise ValueError(
                    f"Shadows and mirrored objects need {height} x {width} texels, and this GPU's textures have at most "
                    f"{self._largest_texture} to a side. Switch off their shadow and glossy visibility."
                )
            texture = (
                GPUTexture((width, height), format="RGBA32F", data=float_buffer(texels))
                if meshes
                else None
            )
            self.counters.map_uploads += 1
            self._traced = _Traced(
                casters, tuple(meshes.values()), dict(zip(meshes, places, strict=True)), texture
            )
        places_of = [self._traced.place_of[id(caster.mesh)] for caster in casters.casters]
        self._traced = replace(self._traced, casters=casters, places=tuple(places_of))

    def _plain_program(
        self, lights: LightVariant, material: PlainMaterial, mesh: MeshData, output_max: float
    ) -> ProgramSource:
        return shader_source.plain_program(
            lights,
            shines=max(material.shine) > 0.0,
            pictured=self._picture_number(material.picture) > 0 and mesh.uv is not None,
            output_max=output_max,
        )

    def _upload(self, scene: SceneData) -> None:
        for key, mesh in scene.meshes.items():
            known = self._meshes.get(key)
            if known is None or known.data is not mesh:
                self._meshes[key] = self._gpu_mesh(mesh)
        for key in [key for key in self._meshes if key not in scene.meshes]:
            del self._meshes[key]
        steels = [m.steel for m in scene.materials.values() if isinstance(m, BladeMaterial)]
        _keep(self._maps, (steel.maps for steel in steels), self._gpu_maps)
        _keep(self._normal_maps, (steel.normal_map for steel in steels), self._gpu_normal_map)

    def _gpu_mesh(self, mesh: MeshData) -> _GpuMesh:
        if not len(mesh.position):
            return _GpuMesh(mesh, np.zeros(3, np.float32), np.zeros(3, np.float32))
        gpu_mesh = _GpuMesh(mesh, *mesh.bounds)
        layout = GPUVertFormat()
        arrays = {"position": mesh.position, "normal_part": mesh.normal_part}
        if mesh.uv is not None:
            arrays["uv"] = mesh.uv
        if mesh.tangent is not None:
            arrays["tangent"] = mesh.tangent
        for name, values in arrays.items():
            layout.attr_add(id=name, comp_type="F32", len=values.shape[1], fetch_mode="FLOAT")
        vertices = GPUVertBuf(layout, len(mesh.position))
        for name, values in arrays.items():
            vertices.attr_fill(name, np.ascontiguousarray(values, np.float32))
        for group in mesh.groups:
            indices = GPUIndexBuf(type="TRIS", seq=np.ascontiguousarray(group.triangles, np.uint32))
            gpu_mesh.batches[group.slot, group.nakago] = GPUBatch(
                type="TRIS", buf=vertices, elem=indices
            )
        self.counters.mesh_uploads += 1
        return gpu_mesh

    def _map_texture(self, values: np.ndarray) -> GPUTexture:
        height, width, channels = values.shape
        self.counters.map_uploads += 1
        kind = {1: "R16F", 4: "RGBA16F"}[channels]
        return GPUTexture((width, height), format=kind, data=float_buffer(values))

    def _gpu_maps(self, maps: MapData) -> _GpuMaps:
        if max(maps.lobes.shape[:2]) > self._largest_texture:
            maps = packing.coarser_maps(maps, self._largest_texture)
        shape = None if maps.shape is None else self._map_texture(maps.shape)
        return _GpuMaps(maps, self._map_texture(maps.lobes), shape)

    def _gpu_normal_map(self, maps: NormalMapData) -> _GpuNormalMap:
        if max(maps.leans.shape[:2]) > self._largest_texture:
            maps = packing.coarser_normal_map(maps, self._largest_texture)
        return _GpuNormalMap(
            maps, self._map_texture(maps.leans), self._map_texture(maps.correlations)
        )

    def _blurred(self, data: Environment) -> _GpuEnvironment:
        """The atlas of an HDRI's levels, each from the one before it."""
        height, width = data.pixels.shape[:2]
        atlas = surroundings.atlas_of(width, height)
        texture = GPUTexture((atlas.width, atlas.height), format="RGBA16F")
        whole = GPUFrameBuffer(color_slots=[texture])
        before = _bordered(data.pixels)
        with _DrawState():
            gpu.state.depth_test_set("NONE")
            gpu.state.blend_set("NONE")
            for number, level in enumerate(atlas.levels):
                if number:
                    before = self._next_level(before, atlas.levels[number - 1], level)
                self._put(before, whole, (atlas.width, atlas.height), (level.x, level.y))
            matt = _bordered(data.matt)
            self._put(matt, whole, (atlas.width, atlas.height), atlas.irradiance)
        self.counters.map_uploads += 1
        return _GpuEnvironment(data, atlas, texture)

    def _next_level(
        self, before: GPUTexture, old: surroundings.Level, level: surroundings.Level
    ) -> GPUTexture:
        texture = GPUTexture((level.width + 2, level.height + 2), format="RGBA32F")
        shader = self._shader(shader_source.environment_level_program())
        with GPUFrameBuffer(color_slots=[texture]).bind():
            shader.bind()
            shader.uniform_sampler("before", before)
            shader.uniform_float("rect", (-1.0, -1.0, 1.0, 1.0))
            shader.uniform_float("sizes", (level.width, level.height, old.width, old.height))
            # A tap for each texel of the level before.
            texel = max(2.0 * math.pi / old.width, math.pi / old.height)
            reach = min(max(math.ceil(2.8 * level.blur_rad / texel), 4), 8)
            shader.uniform_float("blur", (level.blur_rad, float(reach), 0.0, 0.0))
            self._rectangle().draw(shader)
        return texture

    def _put(
        self,
        picture: GPUTexture,
        target: GPUFrameBuffer,
        size: tuple[int, int],
        corner: tuple[int, int],
    ) -> None:
        """A bordered picture into a larger one, its corner without the border at `corner`."""
        left, bottom = corner[0] - 1, corner[1] - 1
        right, top = left + picture.width, bottom + picture.height
        shader = self._shader(shader_source.copy_program())
        with target.bind():
            shader.bind()
            shader.uniform_sampler("picture", picture)
            shader.uniform_float(
                "rect",
                (
                    2.0 * left / size[0] - 1.0,
                    2.0 * bottom / size[1] - 1.0,
                    2.0 * right / size[0] - 1.0,
                    2.0 * top / size[1] - 1.0,
                ),
            )
            shader.uniform_float("origin", (float(left), float(bottom), 1.0, 1.0))
            self._rectangle().draw(shader)

    def _shader(self, source: ProgramSource) -> GPUShader:
        shader = self._programs.get(source)
        if shader is None:
            shader = self._programs[source] = build(source)
            self.counters.programs_built += 1
        return shader

    def _block(self, *key: object) -> Block:
        block = self._blocks.get(key)
        if block is None:
            block = self._blocks[key] = Block()
        return block

    def _set(self, block: Block, content: np.ndarray) -> None:
        count = block.set(content)
        if count:
            self.counters.block_uploads += 1
            self.counters.block_bytes += count

    def _targets_of(self, size: tuple[int, int], colour_format: str) -> _Targets:
        wanted = {
            name: texture_format
            for steel in self._steels
            for texture_format, _kind, name in steel.variant.targets
        }
        layout = tuple((n, wanted[n]) for n in shader_source.STEEL_TARGETS if n in wanted)
        key = (size, colour_format, layout)
        targets = self._targets.get(key)
        if targets is None:
            # A resized viewport would otherwise keep every size it ever had.
            for old in [k for k in self._targets if k[1] == colour_format]:
                del self._targets[old]
            colour = GPUTexture(size, format=colour_format)
            depth = GPUTexture(size, format="DEPTH_COMPONENT32F")
            buffers = {name: GPUTexture(size, format=kind) for name, kind in layout}
            targets = self._targets[key] = _Targets(
                colour=colour,
                depth=depth,
                picture=GPUFrameBuffer(color_slots=[colour], depth_slot=depth),
                buffers=buffers,
                surface=GPUFrameBuffer(color_slots=list(buffers.values()), depth_slot=depth)
                if buffers
                else None,
            )
        return targets


def _bordered(pixels: np.ndarray) -> GPUTexture:
    """An equirectangular picture with its border, as a texture."""
    colour = surroundings.with_border(pixels)
    whole = np.ones((*colour.shape[:2], 4), np.float32)
    whole[..., :3] = colour
    size = (whole.shape[1], whole.shape[0])
    return GPUTexture(size, format="RGBA32F", data=float_buffer(whole))


def _keep(
    kept: dict[int, tuple[_Maps, _OnGpu]],
    wanted: Iterable[_Maps | None],
    make: Callable[[_Maps], _OnGpu],
) -> None:
    """On the GPU: what is wanted, made where it is not there yet; the rest goes."""
    data = {id(one): one for one in wanted if one is not None}
    for key, one in data.items():
        if key not in kept:
            kept[key] = (one, make(one))
    for unused in [key for key in kept if key not in data]:
        del kept[unused]


def _screen_state() -> None:
    # The rectangle lies at the far end, so this test passes where steel is.
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("GREATER")
    gpu.state.depth_mask_set(False)


def _unseen_faces(data: MeshData, matrix: np.ndarray) -> str:
    """The faces of a closed blade that look away. Within some micrometres of its edge line they lie as near as those
    that are seen and win the depth test by rounding: bright dots along the edge where the far side is lit."""
    if not data.closed:
        return "NONE"
    mirrored = float(np.linalg.det(matrix[:3, :3])) < 0.0
    return "FRONT" if mirrored else "BACK"


def _solid_state() -> None:
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)


class _DrawState:
    """Sets the GPU's state for drawing solids, and puts it back."""

    def __enter__(self) -> None:
        self._blend = gpu.state.blend_get()
        self._test = gpu.state.depth_test_get()
        self._mask = gpu.state.depth_mask_get()
        gpu.state.face_culling_set("NONE")

    def __exit__(self, *_: object) -> None:
        gpu.state.blend_set(self._blend)
        gpu.state.depth_test_set(self._test)
        gpu.state.depth_mask_set(self._mask)


class Gathering:
    """Samples of one picture, added up in float32."""

    def __init__(self, renderer: Renderer, size: tuple[int, int]) -> None:
        self._renderer = renderer
        self.size = size
        self.samples = 0
        self.texture = GPUTexture(size, format="RGBA32F")
        self._framebuffer = GPUFrameBuffer(color_slots=[self.texture])

    def restart(self) -> None:
        """The next sample is the first one."""
        self.samples = 0

    def add(self, picture: Picture, scale: float = 1.0) -> None:
        """Add a picture times `scale`."""
        with self._framebuffer.bind():
            blend = "NONE" if self.samples == 0 else "ADDITIVE_PREMULT"
            self._renderer.copy(picture.colour, scale, blend=blend)
        self.samples += 1

    def offset(self, wanted: int, filter_width: float) -> tuple[float, float]:
        """Where in the pixel the next of `wanted` samples lies. The first one lies in the centre, so that a
        picture that stops after one sample is not shifted."""
        offsets = pixel_offsets(wanted, filter_width)
        first = int(np.argmin((offsets**2).sum(axis=1)))
        order = [first, *(i for i in range(wanted) if i != first)]
        x, y = offsets[order[min(self.samples, wanted - 1)]].tolist()
        return (0.0, 0.0) if self.samples == 0 else (x, y)

    def read(self) -> np.ndarray:
        return read_texture(self.texture)


def lod_bias_of(samples: int) -> float:
    """Supersampled pixels see finer levels."""
    return -0.5 * math.log2(max(samples, 1))
