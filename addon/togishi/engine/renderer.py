"""Draws a scene (core/scene_data.py) with the `gpu` module. Knows nothing of Blender's scene or windows.

One Renderer belongs to one viewport or one final render and owns all its GPU objects. It uploads what
changed since the picture before and nothing else; `counters` says what that was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

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

from ..core import packing, shader_source
from ..core.packing import LightPass, RelativeCamera
from ..core.scene_data import (
    BladeMaterial,
    Camera,
    Instance,
    MapData,
    MeshData,
    PlainMaterial,
    SceneData,
    SteelMaterial,
)
from ..core.shader_source import LightVariant, ProgramSource, SteelVariant
from ..core.tables import Tables
from .programs import Block, build, float_buffer

_ROWS = ("model_0", "model_1", "model_2")
# Blender writes this depth where nothing is.
FAR_DEPTH = 1.0e10


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
    depth: GPUTexture | None = None  # R32F, along the view axis
    part: GPUTexture | None = None  # R32F, part id

    def read(self) -> np.ndarray:
        """(height, width, 4), rows from the bottom; waits for the GPU."""
        return read_texture(self.colour)


@dataclass
class Target:
    """A framebuffer and its textures."""

    colour: tuple[GPUTexture, ...]
    depth: GPUTexture | None
    framebuffer: GPUFrameBuffer


@dataclass
class _GpuMesh:
    data: MeshData
    batches: dict[tuple[int, bool], GPUBatch] = field(default_factory=dict)


@dataclass
class _GpuMaps:
    lobes: GPUTexture
    shape: GPUTexture | None


@dataclass(frozen=True)
class _Item:
    """One draw call of one pass."""

    program: ProgramSource
    batch: GPUBatch
    instance: Instance
    material_key: str
    material: SteelMaterial | PlainMaterial
    part: float  # part id to write, or -1 for the mesh's own


@dataclass(frozen=True)
class Gbuffer:
    """What the GPU interpolated, float32, rows from the bottom. Positions are relative to `camera`."""

    covered: np.ndarray  # (H, W) bool
    normal: np.ndarray  # (H, W, 3) unit
    tangent: np.ndarray  # (H, W, 3) unit, perpendicular to the normal
    view: np.ndarray  # (H, W, 3) unit, to the viewer
    position: np.ndarray  # (H, W, 3) relative to the camera, world axes
    lobe_ji: np.ndarray  # (H, W, 3) encoded
    lobe_ha: np.ndarray  # (H, W, 3) encoded
    w: np.ndarray  # (H, W)
    h: np.ndarray  # (H, W)
    part: np.ndarray  # (H, W) int
    depth: np.ndarray  # (H, W) along the view axis
    instance: np.ndarray  # (H, W) int, index in SceneData.instances
    camera: np.ndarray  # (3,) float64, the camera's place in the world


def read_texture(texture: GPUTexture) -> np.ndarray:
    """(height, width, channels) float32, rows from the bottom."""
    buffer = texture.read()
    channels = {"R": 1, "RG": 2, "RGBA": 4}[texture.format.rstrip("F0123456789")]
    buffer.dimensions = texture.width * texture.height * channels
    return np.array(buffer, np.float32).reshape(texture.height, texture.width, channels)


def steel_variant(material: SteelMaterial, mesh: MeshData, *, bench_61: bool = False) -> SteelVariant:
    """What a blade needs: maps only where mesh and material have them, and so on."""
    maps = material.maps if mesh.uv is not None else None
    anisotropic = material.anisotropic
    return SteelVariant(
        maps=maps is not None,
        shape=maps is not None and maps.shape is not None and anisotropic,
        hadori=maps is not None and maps.hadori,
        anisotropic=anisotropic,
        tangent=anisotropic and mesh.tangent is not None,
        bench_61=bench_61,
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
        self._blocks: dict[tuple[object, ...], Block] = {}
        self._targets: dict[tuple[object, ...], Target] = {}
        self._quad: GPUBatch | None = None
        self._items: list[_Item] = []
        self._items_of: tuple[object, ...] = ()
        self._passes: list[LightPass] = []

    # --- the picture ----------------------------------------------------------------------------

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
    ) -> Picture:
        """Colour (half float, or float32) of one sample per pixel. Leaves the GPU state as it found it.

        lod_bias: added to the level of maps; -log2(samples)/2 where samples are gathered.
        """
        output_max = shader_source.FLOAT_MAX if float32 else shader_source.HALF_MAX
        self._prepare(scene, bench_61, False, output_max)
        relative = packing.relative_camera(camera, size, jitter)
        target = self._target(size, ("RGBA32F",) if float32 else ("RGBA16F",))
        background = self._background(scene, output_max)
        with target.framebuffer.bind(), _DrawState():
            target.framebuffer.clear(color=background, depth=1.0)
            for index, light_pass in enumerate(self._passes):
                first = index == 0
                gpu.state.blend_set("NONE" if first else "ADDITIVE")
                gpu.state.depth_test_set("LESS_EQUAL" if first else "EQUAL")
                gpu.state.depth_mask_set(first)
                self._draw_pass(scene, relative, light_pass, index, lod_bias)
        self.counters.pictures += 1
        return Picture(size, target.colour[0], target.framebuffer)

    def draw_aux(self, scene: SceneData, camera: Camera, size: tuple[int, int]) -> Picture:
        """Depth and part id at the pixels' centres. The picture's colour is not lit."""
        unlit = SceneData(
            meshes=scene.meshes,
            instances=scene.instances,
            materials=scene.materials,
            colour=scene.colour,
            transparent=True,
        )
        self._prepare(unlit, False, True, shader_source.HALF_MAX)
        relative = packing.relative_camera(camera, size)
        target = self._target(size, ("RGBA16F", "R32F", "R32F"))
        with target.framebuffer.bind(), _DrawState():
            target.framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            target.colour[1].clear(format="FLOAT", value=(FAR_DEPTH,))
            gpu.state.blend_set("NONE")
            gpu.state.depth_test_set("LESS_EQUAL")
            gpu.state.depth_mask_set(True)
            self._draw_pass(unlit, relative, self._passes[0], 0, 0.0)
        return Picture(size, target.colour[0], target.framebuffer, target.colour[1], target.colour[2])

    def gbuffer(self, scene: SceneData, camera: Camera, size: tuple[int, int]) -> Gbuffer:
        """The model's inputs as the GPU interpolates them, of the scene's blades (only)."""
        self._upload(scene)
        relative = packing.relative_camera(camera, size)
        target = self._target(size, ("RGBA32F",) * len(shader_source.GBUFFER_TARGETS))
        counts = packing.LightCounts()
        frame = self._block("frame", 0)
        self._set(frame, packing.frame_block(relative, (0.0, 0.0, 0.0), 0, counts, 0.0))
        with target.framebuffer.bind(), _DrawState():
            target.framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            gpu.state.blend_set("NONE")
            gpu.state.depth_test_set("LESS_EQUAL")
            gpu.state.depth_mask_set(True)
            for number, instance in enumerate(scene.instances):
                mesh = self._meshes[instance.mesh]
                for group in mesh.data.groups:
                    key = instance.materials[min(group.slot, len(instance.materials) - 1)]
                    material = scene.materials[key]
                    if not isinstance(material, BladeMaterial) or group.nakago:
                        continue
                    variant = steel_variant(material.steel, mesh.data)
                    source = shader_source.gbuffer_program(variant)
                    shader = self._shader(source)
                    shader.bind()
                    shader.uniform_block("frame", frame.buffer)
                    self._bind_material(shader, key, material.steel, source.samplers)
                    self._push_object(shader, instance, relative, float(number), -1.0)
                    mesh.batches[group.slot, group.nakago].draw(shader)
        read = {
            name: read_texture(texture)
            for name, texture in zip(shader_source.GBUFFER_TARGETS, target.colour, strict=True)
        }
        return Gbuffer(
            covered=read["normal"][..., 3] > 0.5,
            normal=read["normal"][..., :3],
            tangent=read["tangent"][..., :3],
            view=read["view"][..., :3],
            position=read["position"][..., :3],
            lobe_ji=read["ji"][..., :3],
            lobe_ha=read["ha"][..., :3],
            w=read["ji"][..., 3],
            h=read["ha"][..., 3],
            part=np.rint(read["tangent"][..., 3]).astype(np.int32),
            depth=read["view"][..., 3],
            instance=np.rint(read["position"][..., 3]).astype(np.int32),
            camera=relative.position,
        )

    def copy(
        self, picture: GPUTexture, scale: float = 1.0, origin: tuple[int, int] = (0, 0), blend: str = "NONE"
    ) -> None:
        """Put a picture, times `scale`, onto the bound framebuffer with its corner at `origin`."""
        shader = self._shader(shader_source.copy_program())
        if self._quad is None:
            layout = GPUVertFormat()
            layout.attr_add(id="position", comp_type="F32", len=2, fetch_mode="FLOAT")
            vertices = GPUVertBuf(layout, 3)
            vertices.attr_fill("position", np.asarray([(-1, -1), (3, -1), (-1, 3)], np.float32))
            self._quad = GPUBatch(type="TRIS", buf=vertices)
        gpu.state.blend_set(blend)
        gpu.state.depth_test_set("NONE")
        shader.bind()
        shader.uniform_sampler("picture", picture)
        shader.uniform_float("origin", (float(origin[0]), float(origin[1]), 0.0, scale))
        self._quad.draw(shader)
        gpu.state.blend_set("NONE")

    @property
    def program_count(self) -> int:
        """Different programs that this Renderer has compiled."""
        return len(self._programs)

    # --- drawing --------------------------------------------------------------------------------

    def _background(self, scene: SceneData, output_max: float) -> tuple[float, float, float, float]:
        if scene.transparent:
            return (0.0, 0.0, 0.0, 0.0)
        if scene.world.black:
            return (0.0, 0.0, 0.0, 1.0)
        light = self.tables.light_rgb(scene.world.spectrum, scene.colour)
        red, green, blue = (
            min(max(a * b, 0.0), output_max)
            for a, b in zip(light, scene.world.radiance, strict=True)
        )
        return (red, green, blue, 1.0)

    def _draw_pass(
        self,
        scene: SceneData,
        camera: RelativeCamera,
        light_pass: LightPass,
        index: int,
        lod_bias: float,
    ) -> None:
        world = scene.world.radiance if index == 0 else (0.0, 0.0, 0.0)
        frame = self._block("frame", index)
        self._set(frame, packing.frame_block(camera, world, 0, light_pass.counts, lod_bias))
        lights, spots = self._block("lights", index), self._block("spots", index)
        self._set(lights, packing.lights_block(light_pass, camera.position))
        if light_pass.counts.spots or spots.tag is None:
            self._set(spots, packing.spots_block(light_pass))
            spots.tag = True
        self.counters.light_passes += 1
        bound: ProgramSource | None = None
        material_key = table_of = None
        shader: GPUShader | None = None
        for item in self._items:
            if item.program is not bound:
                bound, material_key, table_of = item.program, None, None
                shader = self._shader(item.program)
                shader.bind()
                shader.uniform_block("frame", frame.buffer)
                shader.uniform_block("lights", lights.buffer)
                if ("TgSpots", "spots") in item.program.blocks:
                    shader.uniform_block("spots", spots.buffer)
                if ("TgWavelengths", "wavelengths") in item.program.blocks:
                    shader.uniform_block("wavelengths", self._wavelengths_block().buffer)
            assert shader is not None
            metal = item.material.metal if isinstance(item.material, SteelMaterial) else ""
            if table_of != metal:
                table_of = metal
                shader.uniform_block("table", self._table(metal, light_pass, scene, index).buffer)
            if material_key != item.material_key:
                material_key = item.material_key
                self._bind_material(
                    shader, item.material_key, item.material, item.program.samplers
                )
            self._push_object(shader, item.instance, camera, 0.0, item.part)
            item.batch.draw(shader)
            self.counters.draw_calls += 1

    def _push_object(
        self, shader: GPUShader, instance: Instance, camera: RelativeCamera, number: float, part: float
    ) -> None:
        rows, mirror = packing.model_rows(instance.matrix, camera.position)
        for row in range(3):
            shader.uniform_float(_ROWS[row], rows[row].tolist())
        try:
            shader.uniform_float("object_state", (mirror, number, part, 0.0))
        except ValueError:
            # A program without light needs no normal, and the compiler has removed what nobody reads.
            if self._passes[0].lights:
                raise

    def _bind_material(
        self,
        shader: GPUShader,
        key: str,
        material: SteelMaterial | PlainMaterial,
        samplers: tuple[tuple[str, str], ...],
    ) -> None:
        if isinstance(material, PlainMaterial):
            block = self._block("plain", key)
            if block.tag is not material:
                self._set(block, packing.plain_block(material))
                block.tag = material
            shader.uniform_block("plain", block.buffer)
            return
        block = self._block("steel", key)
        if block.tag is not material:
            self._set(block, packing.steel_block(material))
            block.tag = material
        shader.uniform_block("steel", block.buffer)
        if material.maps is not None:
            maps = self._maps[id(material.maps)][1]
            if ("FLOAT_2D", "lobes_atlas") in samplers:
                shader.uniform_sampler("lobes_atlas", maps.lobes)
            if ("FLOAT_2D", "shape_atlas") in samplers and maps.shape is not None:
                shader.uniform_sampler("shape_atlas", maps.shape)

    def _table(self, metal: str, light_pass: LightPass, scene: SceneData, index: int) -> Block:
        block = self._block("table", index, metal)
        tag = (light_pass.spectra, scene.colour)
        if block.tag != tag:
            rows = self.tables.rows(metal, light_pass.spectra, scene.colour)
            self._set(block, packing.table_block(rows))
            block.tag = tag
        return block

    def _wavelengths_block(self) -> Block:
        assert self.wavelengths is not None, "bench_61 needs Renderer.wavelengths"
        block = self._block("wavelengths")
        self._set(block, self.wavelengths)
        return block

    # --- what a scene needs on the GPU ----------------------------------------------------------

    def _prepare(self, scene: SceneData, bench_61: bool, aux: bool, output_max: float) -> None:
        """Upload what is new and make the list of draw calls, unless this very scene was drawn last."""
        of = (scene, bench_61, aux, output_max)
        if self._items_of and self._items_of[0] is scene and self._items_of[1:] == of[1:]:
            return
        self._upload(scene)
        self._passes = packing.light_passes(scene.lights, scene.world)
        lights = packing.light_variant(self._passes, scene.world)
        items: list[_Item] = []
        sources: dict[object, ProgramSource] = {}
        for instance in scene.instances:
            mesh = self._meshes[instance.mesh]
            for group in mesh.data.groups:
                key = instance.materials[min(group.slot, len(instance.materials) - 1)]
                material = scene.materials[key]
                batch = mesh.batches[group.slot, group.nakago]
                if isinstance(material, BladeMaterial) and not group.nakago:
                    variant = steel_variant(material.steel, mesh.data, bench_61=bench_61)
                    source = sources.get(variant)
                    if source is None:
                        source = sources[variant] = self._steel_source(
                            lights, variant, aux, output_max
                        )
                    items.append(_Item(source, batch, instance, key, material.steel, -1.0))
                else:
                    nakago = isinstance(material, BladeMaterial)
                    plain = material.nakago if isinstance(material, BladeMaterial) else material
                    source = sources.get("plain")
                    if source is None:
                        source = sources["plain"] = shader_source.plain_program(
                            lights, aux=aux, output_max=output_max
                        )
                    part = -1.0 if nakago else 0.0
                    plain_key = f"{key}/nakago" if nakago else key
                    items.append(_Item(source, batch, instance, plain_key, plain, part))
        # One program, then one material after the other; blades last, so that stands in front of them
        # have filled the depth buffer.
        items.sort(key=lambda item: (item.program.name != "togishi_plain", id(item.program), item.material_key))
        self._items = items
        self._items_of = of

    @staticmethod
    def _steel_source(
        lights: LightVariant, variant: SteelVariant, aux: bool, output_max: float
    ) -> ProgramSource:
        return shader_source.steel_program(lights, variant, aux=aux, output_max=output_max)

    def _upload(self, scene: SceneData) -> None:
        for key, mesh in scene.meshes.items():
            known = self._meshes.get(key)
            if known is None or known.data is not mesh:
                self._meshes[key] = self._gpu_mesh(mesh)
        for key in [key for key in self._meshes if key not in scene.meshes]:
            del self._meshes[key]
        used: set[int] = set()
        for material in scene.materials.values():
            maps = material.steel.maps if isinstance(material, BladeMaterial) else None
            if maps is None:
                continue
            used.add(id(maps))
            if id(maps) not in self._maps:
                self._maps[id(maps)] = (maps, self._gpu_maps(maps))
        for key in [key for key in self._maps if key not in used]:
            del self._maps[key]

    def _gpu_mesh(self, mesh: MeshData) -> _GpuMesh:
        gpu_mesh = _GpuMesh(mesh)
        if not len(mesh.position):
            return gpu_mesh
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

    def _gpu_maps(self, maps: MapData) -> _GpuMaps:
        def texture(values: np.ndarray) -> GPUTexture:
            height, width = values.shape[:2]
            self.counters.map_uploads += 1
            return GPUTexture((width, height), format="RGBA16F", data=float_buffer(values))

        return _GpuMaps(texture(maps.lobes), None if maps.shape is None else texture(maps.shape))

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

    def _target(self, size: tuple[int, int], formats: tuple[str, ...]) -> Target:
        key = (size, formats)
        target = self._targets.get(key)
        if target is None:
            # A resized viewport would otherwise keep every size it ever had.
            for old in [k for k in self._targets if k[1] == formats]:
                del self._targets[old]
            colour = tuple(GPUTexture(size, format=name) for name in formats)
            depth = GPUTexture(size, format="DEPTH_COMPONENT32F")
            target = Target(
                colour, depth, GPUFrameBuffer(color_slots=list(colour), depth_slot=depth)
            )
            self._targets[key] = target
        return target


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
        self.clear()

    def clear(self) -> None:
        self.samples = 0
        with self._framebuffer.bind():
            self._framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0))

    def add(self, picture: Picture, scale: float = 1.0) -> None:
        with self._framebuffer.bind():
            self._renderer.copy(picture.colour, scale, blend="ADDITIVE_PREMULT")
        self.samples += 1

    def read(self) -> np.ndarray:
        return read_texture(self.texture)


def lod_bias_of(samples: int) -> float:
    """Supersampled pixels see finer levels."""
    return -0.5 * math.log2(max(samples, 1))
