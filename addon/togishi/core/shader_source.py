"""GLSL programs put together for what a scene has.

A program is described by plain data (`ProgramSource`): texts, defines and the interface. The engine
turns it into a GPUShaderCreateInfo; tests read it without a GPU. The texts live in `shaders/`:
`shared/` holds the formulas of the model, `viewport/` the programs around them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, replace
from functools import cache
from pathlib import Path

# Sizes that the GLSL side and packing.py agree on.
LIGHT_CAPACITY = 256
AREA_CAPACITY = 64
# Bits of a whole number in GLSL.
CASTER_CAPACITY = 30
CASTER_COLOURS = 64
# Pictures that rectangles shine with, two for a surface with two sides; levels of one: sides of 1024 texels at most.
PICTURE_CAPACITY = 16
PICTURE_LEVELS = 11
# Texels to a row of the casters' trees.
TREE_WIDTH = 4096
STEEL_CAPACITY = 1024
# Linear interpolation errs by 6e-6 of F at most; a spectral line whose Z is 90 times its Y needs that.
TABLE_SIZE = 512
# Together 64 KiB, the size of a uniform block on every GPU that Blender runs on.
TABLE_ROWS = 8
MAX_LEVELS = 16
ENVIRONMENT_LEVELS = 24
PART_COUNT = 8
WAVELENGTHS = 61
WAVELENGTH_ROWS = 4

HALF_MAX = 65000.0
FLOAT_MAX = 1.0e30

_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"[ \t]*$', re.MULTILINE)


class ShaderSourceError(ValueError):
    """A shader text is missing or includes what is not there."""


def shader_root() -> Path:
    """The folder `shaders`, beside the add-on's modules (a link in a checkout, a copy in a package)."""
    return Path(__file__).resolve().parents[1] / "shaders"


@cache
def _read(name: str) -> str:
    path = shader_root() / name
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise ShaderSourceError(f"Shader file {path} cannot be read: {error}") from error


def resolve(name: str, seen: set[str] | None = None) -> str:
    """Text of a shader file with every `#include "…"` replaced by that file, each file once."""
    seen = set() if seen is None else seen
    seen.add(name)

    def included(match: re.Match[str]) -> str:
        target = match.group(1)
        return "" if target in seen else resolve(target, seen)

    return _INCLUDE.sub(included, _read(name))


@dataclass(frozen=True)
class LightVariant:
    """Which kinds of light a scene has. Code of the others is left out."""

    points: bool = True
    spots: bool = False
    suns: bool = False
    world: bool = False  # of one colour
    environment: bool = False  # an HDRI
    # Lamps of a size: rectangles, and what has a round outline; fine: the latter for a picture at rest.
    rectangles: bool = False
    rounds: bool = False
    pictures: bool = False  # some rectangles shine with one
    fine: bool = False
    shadows: bool = False  # things hide lamps
    mirrored: bool = False  # steel mirrors things; no part of programs without steel

    @property
    def areas(self) -> bool:
        return self.rectangles or self.rounds or self.environment or self.mirrored

    def defines(self) -> dict[str, str]:
        flags = _flags(self)
        if self.areas:
            flags["TG_AREAS"] = ""
        if self.environment or self.mirrored:
            flags["TG_SURROUNDINGS"] = ""
        if self.shadows or self.mirrored:
            flags["TG_CASTERS"] = ""
        return flags


# What the first half of polished steel can leave for the second, in the framebuffer's order.
STEEL_TARGETS = ("surface", "map", "turn", "shape", "bend", "spread")


@dataclass(frozen=True)
class SteelVariant:
    """What a blade's material and mesh have. Code of the rest is left out."""

    maps: bool = False
    shape: bool = False
    hadori: bool = False
    anisotropic: bool = False
    tangent: bool = False
    filtered: bool = False  # highlights are the mean over a pixel's facets
    normal_map: bool = False

    def defines(self) -> dict[str, str]:
        flags = _flags(self)
        if not self.maps:
            flags["TG_ONE_LOBE"] = ""
            flags.pop("TG_SHAPE", None)
            flags.pop("TG_HADORI", None)
        if not self.anisotropic:
            flags.pop("TG_SHAPE", None)
            if not self.normal_map:
                flags.pop("TG_TANGENT", None)
        return flags

    @property
    def targets(self) -> tuple[tuple[str, str, str], ...]:
        """(texture format, GLSL type, name) of what the first half leaves for the second."""
        flags = self.defines()
        targets = [("RGBA32F", "VEC4", "surface")]
        if "TG_MAPS" in flags:
            targets.append(("RGBA32F", "VEC4", "map"))
        if "TG_ANISOTROPIC" in flags:
            targets.append(("RG32F", "VEC2", "turn"))
        if "TG_SHAPE" in flags:
            targets.append(("RGBA32F", "VEC4", "shape"))
        if self.filtered:
            targets.append(("RGBA16F", "VEC4", "bend"))
        if self.normal_map:
            targets.append(("RGBA16F", "VEC4", "spread"))
        return tuple(targets)


def _flags(variant: object) -> dict[str, str]:
    names = [f.name for f in fields(variant)]  # type: ignore[arg-type]
    return {f"TG_{name.upper()}": "" for name in names if getattr(variant, name)}


@dataclass(frozen=True)
class ProgramSource:
    """One GPU program. Types are the names that GPUShaderCreateInfo takes."""

    name: str
    vertex: str
    fragment: str
    typedefs: str = ""
    defines: tuple[tuple[str, str], ...] = ()
    attributes: tuple[tuple[str, str], ...] = ()  # type, name
    varyings: tuple[tuple[str, str, str], ...] = ()  # "smooth" or "flat", type, name
    blocks: tuple[tuple[str, str], ...] = ()  # struct, name
    samplers: tuple[tuple[str, str], ...] = ()  # type, name
    outputs: tuple[tuple[str, str], ...] = ()  # type, name; empty where a target is not written
    push_constants: tuple[tuple[str, str], ...] = ()


_SIZES = {
    "TG_LIGHT_CAPACITY": str(LIGHT_CAPACITY),
    "TG_AREA_CAPACITY": str(AREA_CAPACITY),
    "TG_CASTER_CAPACITY": str(CASTER_CAPACITY),
    "TG_CASTER_COLOURS": str(CASTER_COLOURS),
    "TG_TREE_WIDTH": str(TREE_WIDTH),
    "TG_PICTURE_CAPACITY": str(PICTURE_CAPACITY),
    "TG_PICTURE_LEVELS": str(PICTURE_LEVELS),
    "TG_STEEL_CAPACITY": str(STEEL_CAPACITY),
    "TG_TABLE_SIZE": str(TABLE_SIZE),
    "TG_TABLE_ROWS": str(TABLE_ROWS),
    "TG_MAX_LEVELS": str(MAX_LEVELS),
    "TG_ENVIRONMENT_LEVELS": str(ENVIRONMENT_LEVELS),
    "TG_WAVELENGTHS": str(WAVELENGTHS),
    "TG_WAVELENGTH_ROWS": str(WAVELENGTH_ROWS),
}
# How GLSL says what shaders/shared leaves to each compiler.
_DIALECT = {"TG_FN": "", "TG_PRECISE": "precise"}
_OBJECT_PUSH = (
    ("VEC4", "model_0"),
    ("VEC4", "model_1"),
    ("VEC4", "model_2"),
    ("VEC4", "object_state"),
)


def _typedefs() -> str:
    """Structs of the uniform blocks with every size as a number: not every backend of the gpu module
    expands a define inside a typedef."""
    text = _read("viewport/interface.glsl")
    sizes = {**_SIZES, "TG_PART_COUNT": str(PART_COUNT)}
    for name, value in sizes.items():
        text = re.sub(rf"\b{name}\b", value, text)
    return re.sub(r"//[^\n]*", "", text)


def _program(
    name: str,
    vertex: str,
    fragment: str,
    defines: dict[str, str],
    blocks: tuple[tuple[str, str], ...],
    outputs: tuple[tuple[str, str], ...],
    *,
    attributes: tuple[tuple[str, str], ...] = (),
    varyings: tuple[tuple[str, str, str], ...] = (),
    samplers: tuple[tuple[str, str], ...] = (),
    push_constants: tuple[tuple[str, str], ...] = (),
) -> ProgramSource:
    # The text of lamps of a size is as long as all the rest: without them no compiler reads it.
    parts = (
        ("TG_AREAS", "viewport/areas.glsl"),
        ("TG_FILTERED", "viewport/pixel_step.glsl"),
        ("TG_CASTERS", "viewport/casters.glsl"),
        ("TG_PICTURES", "viewport/pictures.glsl"),
        ("TG_PICTURES", "viewport/area_pictures.glsl"),
        ("TG_SURROUNDINGS", "viewport/environment.glsl"),
        ("TG_ENVIRONMENT", "viewport/environment_read.glsl"),
        ("TG_MIRRORED", "viewport/mirrored.glsl"),
        ("TG_NORMAL_MAP", "viewport/normal_map.glsl"),
        ("TG_NORMAL_MAP", "viewport/spread.glsl"),
    )
    return ProgramSource(
        name=name,
        vertex=resolve(vertex),
        fragment=resolve(fragment, {part for flag, part in parts if flag not in defines}),
        typedefs=_typedefs(),
        defines=tuple(sorted({**defines, **_SIZES, **_DIALECT}.items())),
        attributes=attributes,
        varyings=varyings,
        blocks=blocks,
        samplers=samplers,
        outputs=outputs,
        push_constants=push_constants,
    )


def _light_blocks(lights: LightVariant) -> tuple[tuple[str, str], ...]:
    blocks = [("TgLights", "lights"), ("TgTable", "table")]
    if lights.spots:
        blocks.append(("TgSpots", "spots"))
    if lights.areas:
        blocks.append(("TgAreas", "areas"))
    if lights.environment:
        blocks.append(("TgEnvironment", "environment"))
    if lights.shadows or lights.mirrored:
        blocks.append(("TgCasters", "casters"))
    if lights.pictures:
        blocks.append(("TgPictures", "pictures"))
    return tuple(blocks)


def _light_samplers(lights: LightVariant) -> tuple[tuple[str, str], ...]:
    samplers = [("FLOAT_2D", "environment_atlas")] if lights.environment else []
    if lights.shadows or lights.mirrored:
        samplers.append(("FLOAT_2D", "trees"))
    if lights.pictures:
        samplers.append(("FLOAT_2D", "pictures_atlas"))
    return tuple(samplers)


@cache
def steel_surface_program(
    steel: SteelVariant, layout: tuple[str, ...] = STEEL_TARGETS
) -> ProgramSource:
    """First half of polished steel: which steel each pixel shows. layout: the framebuffer's targets."""
    written = {name: kind for _format, kind, name in steel.targets}
    defines = {**steel.defines(), "TG_NORMAL": "", "TG_PART": ""}
    attributes = [("VEC3", "position"), ("VEC4", "normal_part")]
    varyings = [
        ("smooth", "FLOAT", "v_position"),
        ("smooth", "VEC3", "v_normal"),
        ("flat", "FLOAT", "v_part"),
    ]
    samplers: list[tuple[str, str]] = []
    blocks = [("TgFrame", "frame")]
    if "TG_TANGENT" in defines:
        attributes.append(("VEC3", "tangent"))
        varyings.append(("smooth", "VEC3", "v_tangent"))
    if "TG_MAPS" in defines or "TG_NORMAL_MAP" in defines:
        defines["TG_UV"] = ""
        attributes.append(("VEC2", "uv"))
        varyings.append(("smooth", "VEC2", "v_uv"))
    if "TG_MAPS" in defines:
        blocks.append(("TgSteel", "steel"))
        samplers.append(("FLOAT_2D", "lobes_atlas"))
        if "TG_SHAPE" in defines:
            samplers.append(("FLOAT_2D", "shape_atlas"))
    if "TG_NORMAL_MAP" in defines:
        blocks.append(("TgNormalMap", "normal_map"))
        samplers += [("FLOAT_2D", "leans_atlas"), ("FLOAT_2D", "correlations_atlas")]
    return _program(
        "togishi_steel_surface",
        "viewport/surface.vert.glsl",
        "viewport/steel_surface.frag.glsl",
        defines,
        tuple(blocks),
        tuple((written[n], f"out_{n}") if n in written else ("", "") for n in layout),
        attributes=tuple(attributes),
        varyings=tuple(varyings),
        samplers=tuple(samplers),
        push_constants=_OBJECT_PUSH,
    )


_SCREEN_PUSH = (("VEC4", "rect"), ("VEC4", "object_state"))


def _buffers(steel: SteelVariant) -> tuple[tuple[str, str], ...]:
    return tuple(("FLOAT_2D", f"{name}_buffer") for _format, _kind, name in steel.targets)


def _steel_screen(
    name: str,
    fragment: str,
    defines: dict[str, str],
    blocks: tuple[tuple[str, str], ...],
    steel: SteelVariant,
    outputs: tuple[tuple[str, str], ...],
    samplers: tuple[tuple[str, str], ...] = (),
) -> ProgramSource:
    return _program(
        name,
        "viewport/screen.vert.glsl",
        fragment,
        defines,
        (("TgFrame", "frame"), ("TgSteel", "steel"), *blocks),
        outputs,
        attributes=(("VEC2", "position"),),
        samplers=(*_buffers(steel), *samplers),
        push_constants=_SCREEN_PUSH,
    )


@cache
def steel_light_program(
    lights: LightVariant,
    steel: SteelVariant,
    *,
    many: bool = False,
    output_max: float = HALF_MAX,
    bench_61: bool = False,
    every_lamp: bool = False,
) -> ProgramSource:
    """Second half of polished steel: each pixel under the lamps. many: other steels are in the picture.

    For benchmarks: bench_61 sums over wavelengths in each pixel, both models, as the paper does;
    every_lamp also computes lamps that a pixel's lobes do not reflect.
    """
    defines = {**lights.defines(), **steel.defines(), "TG_OUTPUT_MAX": repr(float(output_max))}
    defines.pop("TG_TANGENT", None)  # the first half has turned it into an angle
    blocks = _light_blocks(lights)
    if many:
        defines["TG_MANY"] = ""
    if every_lamp:
        defines["TG_EVERY_LAMP"] = ""
    if bench_61:
        defines["TG_BENCH_61"] = ""
        blocks = (*blocks, ("TgWavelengths", "wavelengths"))
    return _steel_screen(
        "togishi_steel_light",
        "viewport/steel_light.frag.glsl",
        defines,
        blocks,
        steel,
        (("VEC4", "out_colour"),),
        _light_samplers(lights),
    )


INPUT_TARGETS = ("normal", "tangent", "view", "position", "ji", "ha")


@cache
def steel_inputs_program(steel: SteelVariant, *, many: bool = False) -> ProgramSource:
    """The model's inputs as the second half gets them, one RGBA target each (INPUT_TARGETS)."""
    steel = replace(steel, filtered=False, normal_map=False)
    defines = steel.defines()
    if many:
        defines["TG_MANY"] = ""
    return _steel_screen(
        "togishi_steel_inputs",
        "viewport/steel_inputs.frag.glsl",
        defines,
        (),
        steel,
        tuple(("VEC4", f"out_{name}") for name in INPUT_TARGETS),
    )


@cache
def steel_direction_program(steel: SteelVariant) -> ProgramSource:
    """The direction to one lamp in each pixel of a steel, as the second half computes it."""
    steel = replace(steel, filtered=False, normal_map=False)
    return _steel_screen(
        "togishi_steel_direction",
        "viewport/steel_direction.frag.glsl",
        {**steel.defines(), "TG_MANY": "", "TG_OUTPUT_MAX": repr(FLOAT_MAX)},
        (("TgLights", "lights"), ("TgTable", "table")),
        steel,
        (("VEC4", "out_direction"),),
    )


@cache
def plain_program(
    lights: LightVariant,
    *,
    shines: bool = False,
    pictured: bool = False,
    output_max: float = HALF_MAX,
) -> ProgramSource:
    """Everything that is not polished steel. shines: with light of its own; pictured: with a picture of it."""
    lights = replace(lights, mirrored=False)
    defines = {
        **lights.defines(),
        "TG_OUTPUT_MAX": repr(float(output_max)),
        "TG_NORMAL": "",
        "TG_POSITION": "",
    }
    attributes = [("VEC3", "position"), ("VEC4", "normal_part")]
    varyings = [("smooth", "VEC3", "v_position"), ("smooth", "VEC3", "v_normal")]
    if shines:
        defines["TG_SHINES"] = ""
    if pictured:
        defines["TG_UV"] = ""
        attributes.append(("VEC2", "uv"))
        varyings.append(("smooth", "VEC2", "v_uv"))
    return _program(
        "togishi_plain",
        "viewport/surface.vert.glsl",
        "viewport/plain.frag.glsl",
        defines,
        (("TgFrame", "frame"), ("TgPlain", "plain"), *_light_blocks(lights)),
        (("VEC4", "out_colour"),),
        attributes=tuple(attributes),
        varyings=tuple(varyings),
        samplers=_light_samplers(lights),
        push_constants=_OBJECT_PUSH,
    )


@cache
def background_program(*, output_max: float = HALF_MAX) -> ProgramSource:
    """The HDRI itself, where nothing is in front of it."""
    return _program(
        "togishi_background",
        "viewport/screen.vert.glsl",
        "viewport/background.frag.glsl",
        {"TG_ENVIRONMENT": "", "TG_OUTPUT_MAX": repr(float(output_max))},
        (("TgFrame", "frame"), ("TgEnvironment", "environment")),
        (("VEC4", "out_colour"),),
        attributes=(("VEC2", "position"),),
        samplers=(("FLOAT_2D", "environment_atlas"),),
        push_constants=(("VEC4", "rect"), ("VEC4", "origin")),
    )


@cache
def environment_level_program() -> ProgramSource:
    """One level of an HDRI from the level before it."""
    return _program(
        "togishi_environment_level",
        "viewport/screen.vert.glsl",
        "viewport/environment_level.frag.glsl",
        {},
        (),
        (("VEC4", "out_colour"),),
        attributes=(("VEC2", "position"),),
        samplers=(("FLOAT_2D", "before"),),
        push_constants=(("VEC4", "rect"), ("VEC4", "sizes"), ("VEC4", "blur")),
    )


@cache
def aux_program() -> ProgramSource:
    """Depth and part id of every surface."""
    return _program(
        "togishi_aux",
        "viewport/surface.vert.glsl",
        "viewport/aux.frag.glsl",
        {"TG_PART": ""},
        (("TgFrame", "frame"),),
        (("FLOAT", "out_depth"), ("FLOAT", "out_part")),
        attributes=(("VEC3", "position"), ("VEC4", "normal_part")),
        varyings=(("smooth", "FLOAT", "v_position"), ("flat", "FLOAT", "v_part")),
        push_constants=_OBJECT_PUSH,
    )


@cache
def copy_program() -> ProgramSource:
    """Puts a picture, scaled, onto the bound target."""
    return _program(
        "togishi_copy",
        "viewport/screen.vert.glsl",
        "viewport/copy.frag.glsl",
        {},
        (),
        (("VEC4", "out_colour"),),
        attributes=(("VEC2", "position"),),
        samplers=(("FLOAT_2D", "picture"),),
        push_constants=(("VEC4", "rect"), ("VEC4", "origin")),
    )
