"""What a picture needs to know of a scene: plain frozen data, without Blender and without a GPU.

Lengths in Blender units, angles in radians unless named `_deg`, colours in linear RGB of the scene's
working space. Matrices are float64, column vectors (m @ v), as Blender's are.

The renderer decides by identity what to upload again: a changed mesh or map is a new object, an
unchanged one the same object as in the scene before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

F16 = NDArray[np.float16]
F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I32 = NDArray[np.int32]
U32 = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class MeshGroup:
    """Triangles of one mesh that share a material slot and a program."""

    slot: int
    nakago: bool
    triangles: U32  # (T, 3) into the vertices


@dataclass(frozen=True, eq=False)
class MeshData:
    """Vertices as the GPU gets them: one for each different (position, normal, part, uv, tangent)."""

    position: F32  # (V, 3)
    normal_part: F32  # (V, 4): unit normal, part id
    uv: F32 | None  # (V, 2)
    tangent: F32 | None  # (V, 3), None: the object's x axis
    groups: tuple[MeshGroup, ...]
    closed: bool = False  # a skin around a volume, wound outwards: its far side is never seen

    @property
    def triangle_count(self) -> int:
        return sum(len(group.triangles) for group in self.groups)

    @cached_property
    def bounds(self) -> tuple[F32, F32]:
        """Lowest and highest corner of the box around all vertices, of which there is at least one."""
        return self.position.min(axis=0), self.position.max(axis=0)


@dataclass(frozen=True, eq=False)
class MapData:
    """A blade's maps as half-float atlases with their mip levels (togishi_core.pack_mip_atlas)."""

    lobes: F16  # (H', W', 4): ji.ln_mu_deg, ha.ln_mu_deg, w, h
    shape: F16 | None  # (H', W', 4): ji.e1, ji.e2, ha.e1, ha.e2
    levels: I32  # (levels, 4): x, y, width, height
    hadori: bool  # whether h is above 0 anywhere
    anisotropic: bool  # whether any shape is above 0


@dataclass(frozen=True, eq=False)
class NormalMapData:
    """A normal map as half-float atlases with its mip levels (togishi_core.pack_normal_atlas)."""

    leans: F16  # (H', W', 4): mean lean and its standard deviation along u and v
    correlations: F16  # (H', W', 1)
    levels: I32  # (levels, 4): x, y, width, height


@dataclass(frozen=True)
class SteelMaterial:
    """A blade's material. Lobes are (ln_mu_deg, e1, e2); weights are negative where normalised."""

    metal: str
    part_lobes: tuple[tuple[float, float, float], ...]  # per part id, 8 of them
    part_weights: tuple[float, ...]
    part_rough: tuple[bool, ...]  # whether the part's lobe is a hamon
    ha: tuple[float, float, float, float]  # lobe and beta
    hadori: tuple[float, float, float, float]
    maps: MapData | None = None
    normal_map: NormalMapData | None = None

    @property
    def anisotropic(self) -> bool:
        lobes = [*self.part_lobes, self.ha[:3], self.hadori[:3]]
        constant = any(abs(e1) > 1e-6 or abs(e2) > 1e-6 for _mu, e1, e2 in lobes)
        return constant or (self.maps is not None and self.maps.anisotropic)


@dataclass(frozen=True, eq=False)
class LampPicture:
    """What a rectangle shines with, times its colour. Where x and y run from -1 to 1 along the lamp's x_axis and y_axis, the
    picture's own coordinates (0 to 1, v upwards) are to_u . (x, y, 1) and to_v . (x, y, 1)."""

    pixels: F32  # (H, W, 3) linear RGB, sides powers of two up to 1024, rows from the bottom
    to_u: tuple[float, float, float] = (0.5, 0.0, 0.5)
    to_v: tuple[float, float, float] = (0.0, 0.5, 0.5)


@dataclass(frozen=True)
class PlainMaterial:
    """Anything else: an albedo and a gloss."""

    albedo: tuple[float, float, float] = (0.8, 0.8, 0.8)
    ior: float = 1.5
    gloss_ln_mu_deg: float = 2.5
    metallic: float = 0.0
    shine: tuple[float, float, float] = (0.0, 0.0, 0.0)  # radiance of its own light
    picture: LampPicture | None = None  # that multiplies it


@dataclass(frozen=True)
class BladeMaterial:
    """Polished steel, and what its nakago looks like."""

    steel: SteelMaterial
    nakago: PlainMaterial


Material = BladeMaterial | PlainMaterial


@dataclass(frozen=True, eq=False)
class Instance:
    """One appearance of a mesh."""

    mesh: str  # key in SceneData.meshes
    matrix: F64  # (4, 4) object to world
    materials: tuple[str, ...]  # key in SceneData.materials for each slot, at least one
    casts: bool = True  # hides lamps from others
    mirrored: bool = True  # is seen in others' steel


class LightKind(Enum):
    POINT = "point"
    SPOT = "spot"
    SUN = "sun"
    RECTANGLE = "rectangle"
    ELLIPSE = "ellipse"


@dataclass(frozen=True)
class Light:
    """A lamp. power: W, of a sun W/m^2 (shaders/shared/light.glsl).

    x_axis, y_axis, z_axis: in world space; a spot's over their scale, of a flat lamp unit and perpendicular. It
    shines along -z. Sizes are in world space, scale included.
    """

    kind: LightKind
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    to_light: tuple[float, float, float] = (0.0, 0.0, 1.0)  # suns
    power: float = 1.0
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    spectrum: str = "D65"
    x_axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    y_axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    z_axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    cone_rad: float = 0.785398
    blend: float = 0.15
    radius: float = 0.0  # of a point or spot: of its sphere
    soft_falloff: bool = True  # a disk that faces each point, as Blender has it; else a true sphere
    half_angle_rad: float = 0.0  # of a sun: half of the angle that its disk is seen under
    half_u: float = 0.0  # flat: half of the side along x_axis, or the ellipse's half axis
    half_v: float = 0.0  # along y_axis
    spread_rad: float = math.pi  # flat: whole angle that it shines into
    shadows: bool = False  # whether things hide it
    picture: LampPicture | None = None  # of a rectangle
    thing: Instance | None = None  # whose surface shines: it does not hide its own light

    @property
    def sized(self) -> bool:
        """Whether it is drawn with its size. Flat lamps always are: they shine to one side."""
        if self.kind is LightKind.SUN:
            return self.half_angle_rad > 0.0
        return self.kind in {LightKind.RECTANGLE, LightKind.ELLIPSE} or self.radius > 0.0

    @property
    def dark(self) -> bool:
        """Whether it gives no light: such a lamp costs nothing."""
        return not self.power > 0.0 or not max(self.colour) > 0.0


@dataclass(frozen=True)
class BrightSpot:
    """A small bright spot of an HDRI, such as the sun."""

    direction: tuple[float, float, float]  # unit, in the picture's own space
    irradiance: tuple[float, float, float]  # on a surface facing it, linear RGB
    half_angle_rad: float


@dataclass(frozen=True, eq=False)
class Environment:
    """An HDRI (core/surroundings.py makes it)."""

    pixels: F32  # (H, W, 3) equirectangular, without the spots
    matt: F32  # (16, 32, 3) what a white matt surface of each normal shines with
    spots: tuple[BrightSpot, ...]


@dataclass(frozen=True)
class World:
    """A uniform room of this radiance, before its spectrum; with an environment, what multiplies that."""

    radiance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spectrum: str = "D65"
    environment: Environment | None = None
    # Rows of the matrix from the world to the environment's own space: a rotation.
    turn: tuple[tuple[float, float, float], ...] = (
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
    )

    @property
    def black(self) -> bool:
        return not max(self.radiance) > 0.0


@dataclass(frozen=True)
class ColourSettings:
    """What turns spectra into RGB."""

    observer: str = "cie1931_2"
    space: str = "rec709"
    adaptation: str = "none"
    white: str = ""  # the spectrum that the eye is adapted to; "": each light's own


@dataclass(frozen=True, eq=False)
class SceneData:
    """Everything that is drawn."""

    meshes: dict[str, MeshData] = field(default_factory=dict)
    instances: tuple[Instance, ...] = ()
    materials: dict[str, Material] = field(default_factory=dict)
    lights: tuple[Light, ...] = ()
    world: World = World()
    colour: ColourSettings = ColourSettings()
    transparent: bool = False  # film: no background
    filtered: bool = (
        False  # highlights on steel are the mean over a pixel's facets, not the value at its centre
    )
    mirror_things: bool = False  # steel mirrors the other things of the scene

    def material_of(self, instance: Instance, slot: int) -> tuple[str, Material]:
        """Key and material of a slot; slots beyond the last have the last one's."""
        key = instance.materials[min(slot, len(instance.materials) - 1)]
        return key, self.materials[key]


@dataclass(frozen=True, eq=False)
class Camera:
    """view: world to camera (looking along -z); projection: camera to clip space, OpenGL's."""

    view: F64  # (4, 4)
    projection: F64  # (4, 4)

    @property
    def orthographic(self) -> bool:
        return abs(float(self.projection[3, 3])) > 0.5
