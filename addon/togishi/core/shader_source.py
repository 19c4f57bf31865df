"""GLSL programs put together for what a scene has.

A program is described by plain data (`ProgramSource`): texts, defines and the interface. The engine
turns it into a GPUShaderCreateInfo; tests read it without a GPU. The texts live in `shaders/`:
`shared/` holds the formulas of the model, `viewport/` the programs around them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

# Sizes that the GLSL side and packing.py agree on.
LIGHT_CAPACITY = 256
TABLE_SIZE = 64
# 16 rows of 64 texels are 16 KiB, the size of a uniform block that every GPU has.
TABLE_ROWS = 16
MAX_LEVELS = 16
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
    world: bool = False

    def defines(self) -> dict[str, str]:
        return _flags(self)


@dataclass(frozen=True)
class SteelVariant:
    """What a blade's material and mesh have. Code of the rest is left out."""

    maps: bool = False
    shape: bool = False
    hadori: bool = False
    anisotropic: bool = False
    tangent: bool = False
    bench_61: bool = False

    def defines(self) -> dict[str, str]:
        flags = _flags(self)
        if not self.maps:
            flags["TG_ONE_LOBE"] = ""
            flags.pop("TG_SHAPE", None)
            flags.pop("TG_HADORI", None)
        if not self.anisotropic:
            flags.pop("TG_SHAPE", None)
            flags.pop("TG_TANGENT", None)
        return flags


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
    outputs: tuple[tuple[str, str], ...] = ()  # type, name
    push_constants: tuple[tuple[str, str], ...] = ()


_SIZES = {
    "TG_LIGHT_CAPACITY": str(LIGHT_CAPACITY),
    "TG_TABLE_SIZE": str(TABLE_SIZE),
    "TG_TABLE_ROWS": str(TABLE_ROWS),
    "TG_MAX_LEVELS": str(MAX_LEVELS),
    "TG_WAVELENGTHS": str(WAVELENGTHS),
    "TG_WAVELENGTH_ROWS": str(WAVELENGTH_ROWS),
}
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


def _surface(
    name: str,
    fragment: str,
    defines: dict[str, str],
    blocks: tuple[tuple[str, str], ...],
    outputs: tuple[tuple[str, str], ...],
    output_max: float,
) -> ProgramSource:
    flags = dict(defines)
    attributes = [("VEC3", "position"), ("VEC4", "normal_part")]
    varyings = [("smooth", "VEC3", "v_position"), ("smooth", "VEC3", "v_normal")]
    samplers: list[tuple[str, str]] = []
    if "TG_TANGENT" in flags:
        attributes.append(("VEC3", "tangent"))
        varyings.append(("smooth", "VEC3", "v_tangent"))
    if "TG_MAPS" in flags:
        flags["TG_UV"] = ""
        attributes.append(("VEC2", "uv"))
        varyings.append(("smooth", "VEC2", "v_uv"))
        samplers.append(("FLOAT_2D", "lobes_atlas"))
        if "TG_SHAPE" in flags:
            samplers.append(("FLOAT_2D", "shape_atlas"))
    if "TG_MAPS" in flags or "TG_AUX" in flags or "TG_GBUFFER" in flags:
        flags["TG_PART"] = ""
        varyings.append(("flat", "FLOAT", "v_part"))
    if "TG_ONE_LOBE" in flags:
        varyings.append(("flat", "VEC4", "v_form"))
        varyings.append(("flat", "VEC2", "v_weight"))
    all_blocks = [("TgFrame", "frame"), ("TgLights", "lights")]
    if "TG_SPOTS" in flags:
        all_blocks.append(("TgSpots", "spots"))
    all_blocks += [("TgTable", "table"), *blocks]
    flags.update(_SIZES)
    flags["TG_FN"] = ""
    flags["TG_OUTPUT_MAX"] = repr(float(output_max))
    return ProgramSource(
        name=name,
        vertex=resolve("viewport/surface.vert.glsl"),
        fragment=resolve(fragment),
        typedefs=_typedefs(),
        defines=tuple(sorted(flags.items())),
        attributes=tuple(attributes),
        varyings=tuple(varyings),
        blocks=tuple(all_blocks),
        samplers=tuple(samplers),
        outputs=outputs,
        push_constants=_OBJECT_PUSH,
    )


def _outputs(aux: bool) -> tuple[tuple[str, str], ...]:
    colour = (("VEC4", "out_colour"),)
    return (*colour, ("FLOAT", "out_depth"), ("FLOAT", "out_part")) if aux else colour


@cache
def steel_program(
    lights: LightVariant, steel: SteelVariant, *, aux: bool = False, output_max: float = HALF_MAX
) -> ProgramSource:
    """Polished steel. aux: depth and part id go to two further targets."""
    defines = {**lights.defines(), **steel.defines()}
    blocks: tuple[tuple[str, str], ...] = (("TgSteel", "steel"),)
    if aux:
        defines["TG_AUX"] = ""
    if steel.bench_61:
        blocks = (*blocks, ("TgWavelengths", "wavelengths"))
    return _surface(
        "togishi_steel", "viewport/steel.frag.glsl", defines, blocks, _outputs(aux), output_max
    )


@cache
def plain_program(
    lights: LightVariant, *, aux: bool = False, output_max: float = HALF_MAX
) -> ProgramSource:
    """Everything that is not polished steel."""
    defines = lights.defines()
    if aux:
        defines["TG_AUX"] = ""
    return _surface(
        "togishi_plain",
        "viewport/plain.frag.glsl",
        defines,
        (("TgPlain", "plain"),),
        _outputs(aux),
        output_max,
    )


GBUFFER_TARGETS = ("normal", "tangent", "view", "position", "ji", "ha")


@cache
def gbuffer_program(steel: SteelVariant) -> ProgramSource:
    """The GPU's own interpolated inputs of the model, one RGBA target each (GBUFFER_TARGETS)."""
    defines = {**steel.defines(), "TG_GBUFFER": ""}
    # The lobe comes from the block here, not from the vertex program.
    defines.pop("TG_ONE_LOBE", None)
    return _surface(
        "togishi_gbuffer",
        "viewport/gbuffer.frag.glsl",
        defines,
        (("TgSteel", "steel"),),
        tuple(("VEC4", f"out_{name}") for name in GBUFFER_TARGETS),
        FLOAT_MAX,
    )


@cache
def copy_program() -> ProgramSource:
    """Puts a picture, scaled, onto the bound target."""
    return ProgramSource(
        name="togishi_copy",
        vertex=resolve("viewport/screen.vert.glsl"),
        fragment=resolve("viewport/copy.frag.glsl"),
        attributes=(("VEC2", "position"),),
        varyings=(("smooth", "VEC2", "v_uv"),),
        samplers=(("FLOAT_2D", "picture"),),
        outputs=(("VEC4", "out_colour"),),
        push_constants=(("VEC4", "origin"),),
    )
