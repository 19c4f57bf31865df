"""Togishi's core on numpy arrays. Angles in degrees where named `_deg`, wavelengths in nm, lengths in mm.

All functions release the GIL while they work, and raise `InputError` (a ValueError) naming what is wrong.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

__version__: str

class InputError(ValueError): ...

# --- spectral -----------------------------------------------------------------------------------

PART_NAMES: list[str]
"""Index = part id: other, ji, shinogi_ji, ha, mune, kissaki, boshi, nakago."""

def metals() -> list[dict[str, Any]]:
    """Built-in metals: [{"name", "title", "source", "licence", "nm_min", "nm_max"}], iron first (the default)."""

def lights() -> list[dict[str, Any]]:
    """Built-in light spectra: [{"name", "title", "source", "licence"}], D65 first (the default)."""

def observers() -> list[str]:
    """["cie1931_2", "cie1964_10"]."""

def colour_spaces() -> list[str]:
    """["rec709", "rec2020", "acescg", "acescg_d65", "xyz"]. acescg takes XYZ as it is (D65 is bluish there);
    acescg_d65 is what Blender's ACEScg working space needs: D65 is (1, 1, 1), by a fixed Bradford adaptation."""

def metal_nk(metal: str, wavelengths_nm: F64) -> tuple[F64, F64]:
    """n and k (N,) by PCHIP at the wavelengths. metal: a built-in name or a path to a file of the same format.
    A wavelength outside the measured range is an InputError."""

def light_power(light: str, wavelengths_nm: F64) -> F64:
    """Relative spectral power at the wavelengths (shape only). light: "D65", "daylight:5000",
    "blackbody:3200", "line:589.3", "csv:/path.csv" (see docs/architecture.md). wavelengths_nm increasing;
    zero outside the data; a line gives its power, 1, to its two neighbouring wavelengths in proportion."""

def light_notes(light: str) -> list[str]:
    """What a reader should know of this spectrum: range shortfalls, resampling. Empty for built-in lights."""

def light_rgb(
    light: str, observer: str = "cie1931_2", space: str = "rec709", adaptation: str = "none"
) -> F64:
    """(3,) linear RGB of the light itself, scaled to luminance Y = 1.
    space: one of colour_spaces(); adaptation: "none" or "cat16" / "bradford" (to the space's white)."""

def xyz_to_rgb(space: str) -> F64:
    """(3, 3) matrix from XYZ to linear RGB of the space."""

def delta_e00(xyz_a: F64, xyz_b: F64, white_xyz: F64) -> F64:
    """CIEDE2000 per row of two (N, 3) arrays; Lab under white_xyz (3,)."""

# --- bake ---------------------------------------------------------------------------------------

def fresnel_table(
    metal: str,
    light: str,
    observer: str = "cie1931_2",
    space: str = "rec709",
    size: int = 64,
    adaptation: str = "none",
) -> F32:
    """(size, 3) linear RGB of F(n, k, theta) times the light (Y = 1); row i at cos(theta) = (i/(size - 1))^2.
    size: 2 to 4096. The metal's reflectance is kept between calls: a light's new spectrum takes some 20 us."""

# --- materials and maps -------------------------------------------------------------------------

MAP_CHANNELS: list[str]
"""ji.ln_mu_deg ji.e1 ji.e2 ha.ln_mu_deg ha.e1 ha.e2 w h part"""

def materials() -> list[str]:
    """Names of the built-in materials, the default first; load_material takes them."""

def load_material(path: str) -> dict[str, Any]:
    """A blade material (a TOML file, or a built-in name), every field checked.
    Same keys as material_to_toml takes."""

def default_material() -> dict[str, Any]: ...
def material_to_toml(material: Mapping[str, Any]) -> str: ...
def encode_lobe(mu_t_deg: F64, mu_b_deg: F64, rho_deg: F64) -> F32:
    """(..., 3) of ln_mu_deg, e1, e2 from half widths and azimuth."""

def decode_lobe(lobe: F32) -> F64:
    """(..., 3) of mu_t_deg, mu_b_deg, rho_deg in [0, 180)."""

def map_mip_levels(maps: Mapping[str, F32]) -> list[dict[str, F32]]:
    """Levels 0 (the map itself) to 1 x 1 by covariance (design, section 1, "Frame and maps").
    maps: channel name -> (H, W), or (1, 1) for a constant channel; missing channels are not made up:
    at least ji.ln_mu_deg, ha.ln_mu_deg, w. Rows from v = 0 upwards."""

def pack_mip_atlas(
    lobes: F32, shape: F32 | None
) -> tuple[NDArray[np.float16], NDArray[np.float16] | None, NDArray[np.int32]]:
    """Blade images (H, W, 4) as docs/architecture.md has them -> atlases (H', W', 4) in half float with all mip
    levels made by covariance, one texel of border, and (levels, 4) of x, y, width, height of each level in
    the atlas. NaN and infinity in a map are replaced by the nearest valid value and counted in a warning."""

# --- blade --------------------------------------------------------------------------------------

class Katana:
    """A generated blade. Positions in mm: +X to the tip, +Z towards the mune (back), +Y to omote's outside."""

    positions_mm: F64  # (V, 3)
    corner_vertex: NDArray[np.int32]  # (C,)
    face_start: NDArray[
        np.int32
    ]  # (F + 1,) first corner of each face; faces are triangles or quads
    face_part: NDArray[np.uint8]  # (F,)
    corner_normal: F32  # (C, 3)
    corner_tangent: F32  # (C, 3) along the blade, machi to tip, on both sides
    corner_uv: F32  # (C, 2) the chart of cpp_core/blade/frame.hpp
    s_mm: F32  # (V,)
    t_mm: F32  # (V,) developed distance from the mune ridge
    chart_mm: tuple[float, float]  # size that u and v in [0, 1] span
    measures: dict[
        str, float
    ]  # what was asked for, measured again on the mesh: nagasa_mm, sori_mm, ...

def katana_defaults(zukuri: str = "shinogi") -> dict[str, Any]: ...
def katana_presets() -> dict[str, dict[str, Any]]:
    """Built-in blades: name -> {"title", "source", "licence", "parameters"}, the latter for katana()."""

def katana(parameters: Mapping[str, Any], detail: float = 1.0) -> Katana:
    """Keys as katana_defaults returns; unknown keys and impossible dimensions raise InputError with the reason."""

# --- steel pattern ------------------------------------------------------------------------------

def steel_defaults() -> dict[str, Any]:
    """Parameters of a blade's pattern; docs/steel.md says what each does, its unit and range."""

def steel_choices() -> dict[str, list[str]]:
    """The names that "hamon", "boshi" and "hada" allow."""

def steel_ranges() -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each number of steel_defaults (seed: a whole number from 0 to 2^53)."""

def steel_pattern(
    katana_parameters: Mapping[str, Any],
    material: Mapping[str, Any],
    pattern: Mapping[str, Any],
    width: int,
    height: int,
    *,
    progress: Callable[[float], Any] | None = None,
) -> dict[str, F32]:
    """Property maps of a blade: channel name -> (height, width), or (1, 1) where it is constant.

    pattern: keys of steel_defaults, missing ones take the default. progress: called with the share done, in [0, 1];
    what it raises passes through, and returning False cancels with InterruptedError."""

# --- reference ----------------------------------------------------------------------------------

def reference_xyz(
    metal: str,
    lights: list[str],
    light_of: NDArray[np.int32],
    normal: F64,
    tangent: F64,
    view: F64,
    light_direction: F64,
    irradiance: F64,
    lobe_ji: F64,
    lobe_hadori: F64,
    lobe_ha: F64,
    w: F64,
    h: F64,
    chi: float = -1.0,
    beta_hadori: float = -1.0,
    beta_ha: float = -1.0,
    world: tuple[str, float] | None = None,
    observer: str = "cie1931_2",
    grid: str = "61",
) -> F64:
    """XYZ (P, 3) of P points under K lights by the plain 61-wavelength sum in double precision.

    light_of (K,): index into `lights` (spectrum names). normal, tangent, view: (P, 3), need not be unit;
    light_direction: (P, K, 3); irradiance: (P, K) on a surface facing the light (spectrum scaled to Y = 1).
    lobe_*: (P, 3) or (3,) encoded lobes; w, h: (P,). Negative weights: normalised. world: spectrum and
    radiance of a uniform room. grid: "61" (with the white correction) or "1nm" (360-830)."""

# --- the shared formulas, for tests -------------------------------------------------------------

def formula_names() -> list[str]:
    """Names of the functions of shaders/shared that formulas() evaluates."""

def formulas(name: str, precision: str, inputs: F64) -> F64:
    """One function of shaders/shared on rows of numbers, as the core computes it. A test interface.

    precision: "f32" (inputs are rounded to float first) or "f64". inputs (N, K): the arguments, structs and
    vectors flattened in the order of declaration; result (N, M) likewise."""
