"""Togishi's core on numpy arrays. Angles in degrees where named `_deg`, wavelengths in nm, lengths in mm.

All functions release the GIL while they work, and raise `InputError` (a ValueError) naming what is wrong.
"""

import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I32 = NDArray[np.int32]

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

def adapt_rgb(
    light: str, observer: str = "cie1931_2", space: str = "rec709", adaptation: str = "cat16"
) -> F64:
    """(3, 3) matrix on linear RGB of the space: what an eye sees that is adapted to the white of `light`, which becomes
    the space's white. A light too saturated to be a white is an InputError."""

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
    size: 2 to 4096; beyond 64 the rows come from a polynomial in cos(theta), to float precision.
    The metal's reflectance is kept between calls: a light's new spectrum takes some 30 us at 512 rows."""

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

def ray_tree(
    positions: F32, normals: F32, triangles: NDArray[np.uint32], groups: NDArray[np.uint16]
) -> tuple[F32, F32]:
    """A surface as the GPU's rays search it (shaders/shared/trace/ray_tree.glsl): texels of the nodes (2 N, 4) and of the
    triangles (4 T, 4). positions, normals (V, 3); triangles (T, 3), at most 2^21; groups (T,), 0 to 4095."""

def pack_normal_atlas(
    image: F32,
) -> tuple[NDArray[np.float16], NDArray[np.float16], NDArray[np.int32]]:
    """Normal map (H, W, 3 or more), red, green, blue = 0.5 + 0.5 n in the chart (docs/conventions.md) -> atlases in half
    float with all mip levels: (H', W', 4) mean lean (nx, ny)/nz and its standard deviation along u and v,
    (H', W', 1) their correlation, and (levels, 4) as pack_mip_atlas. Texels without a normal are taken as flat, those
    that lean more than 84 degrees as 84; both are counted in a warning."""

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
    frame: dict[str, Any]  # {"frame": ...}: the outline in the chart, as steel_pattern takes it
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
    blade: Mapping[str, Any],
    material: Mapping[str, Any],
    pattern: Mapping[str, Any],
    width: int,
    height: int,
    *,
    progress: Callable[[float], Any] | None = None,
) -> dict[str, F32]:
    """Property maps of a blade: channel name -> (height, width), or (1, 1) where it is constant.

    blade: dimensions as katana() takes them, or {"frame": ...} of a scanned blade. pattern: keys of steel_defaults,
    missing ones take the default. progress: called with the share done, in [0, 1]; what it raises passes through, and
    returning False cancels with InterruptedError."""

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

# --- goniometer scans and their fit: docs/measurement.md ------------------------------------------

class ScanSet:
    """Scans of one part, to be fitted together. Read-only."""

    part: str  # "ji" or "hamon"
    calibration: str  # "absolute", "relative" or "per_scan"
    unit: str
    metal: str  # "auto": to be chosen by the fit
    light: str
    name: str
    channels: list[str]  # titles of the intensity columns: (C,)
    inputs: list[dict[str, str]]  # [{"file", "sha256"}]
    notes: list[str]
    scans: list[dict[str, Any]]
    """[{"file", "incidence_deg", "turn_deg", "quantity", "source_aperture_deg", "detector_aperture_deg", "saturation",
    "receive_deg" (N,), "azimuth_deg" (N,), "line" (N,), "intensity" (N, C), "sigma" (N, C) or None}]; NaN: a gap."""
    readings: int  # that are not gaps

    def to_text(self) -> str:
        """A scan file that parse_scans reads back."""

class Fit:
    """What fit_scans found. Read-only."""

    scan_set: ScanSet
    record: dict[str, Any]
    """As in the material's [fit.<part>] (cpp_core/brdf/fit_record.hpp): "part", "model", "metal", "calibration",
    "chi2_reduced", "bic", "readings", "outliers", "clipped", "noise_relative", "noise_floor", "metals"
    [[name, delta_bic]], "parameter" [{"name", "value", "sigma", "unit", "determined", "reason", "text"}],
    "correlations" (P, P) lists, "scan" [...], "input" [...], "notes" [...]."""
    lobe: dict[str, float]  # mu_t_deg, mu_b_deg, rho_deg, weight
    scans: list[dict[str, Any]]
    """In the order of scan_set.scans: [{"modelled" (N, C), "residual_sigma" (N, C), "state" (N, C) uint8: 0 used,
    1 outlier, 2 clipped, 3 gap; "gain", "gain_sigma", "residual_rms_sigma", "mu_eff_deg", "mu_eff_sigma_deg"}]."""
    seconds: float
    evaluations: int

    def curve(self, scan: int, receive_deg: F64) -> F64:
        """(N, C): the fitted model at other receive angles of one scan, in its plane of incidence."""

    def mu_eff_deg(self, turn_deg: F64) -> F64:
        """(N,) half width of the fitted lobe along the plane of incidence at each turn of the sample."""

def parse_scans(text: str, name: str = "text", settings: Mapping[str, str] = {}) -> ScanSet:
    """The text of one scan file. settings: header keys that stand in for what the file does not say.
    InputError names line and column."""

def read_scans(paths: list[str], settings: Mapping[str, str] = {}) -> list[ScanSet]:
    """Files from disk, joined by part, ji first: each set goes into one fit."""

def simulation_defaults() -> dict[str, Any]:
    """Options of simulate_scan with their defaults (cpp_core/scan/simulate_scan.hpp): protocol ("a" or "b"),
    incidences_deg, turns_deg, azimuths_deg, receive_first_deg, receive_last_deg, step_deg, dense_within_deg,
    coarse_step_deg (None: as the protocol has it), quantity, calibration, channels, light, noise_relative,
    noise_floor, gain_error, source_aperture_deg, detector_aperture_deg, pedestal, tilt_t_deg, tilt_b_deg, receive_offset_deg,
    out_of_plane_deg, saturation, haze_share, haze_width, outlier_share, state_sigma, seed."""

def simulate_scan(
    material: Mapping[str, Any], part: str, options: Mapping[str, Any] = {}
) -> ScanSet:
    """What a goniometer would measure of the part ("ji" or "hamon") of a material, by the reference evaluation."""

def fit_defaults() -> dict[str, Any]:
    """Options of fit_scans with their defaults (cpp_core/fit/fit.hpp): metal, anisotropy and haze ("off", "on" or
    "auto"), aperture, tilt, gain, pedestal, gain_prior, tilt_prior_deg, receive_offset_prior_deg,
    out_of_plane_prior_deg, unseen_tilt_deg, outlier_sigma, starts, max_iterations."""

def fit_scans(
    scans: ScanSet,
    options: Mapping[str, Any] = {},
    *,
    progress: Callable[[float], Any] | None = None,
) -> Fit:
    """Fits the model to all scans of a set jointly. progress: called with the share done, in [0, 1]; what it raises
    passes through, and returning False cancels with InterruptedError."""

def fit_pictures(fit: Fit, scale: float = 1.0) -> dict[str, NDArray[np.uint8]]:
    """What was measured beside what the fitted model says, for people: (H, W, 3) in 8-bit sRGB, the top row first.
    "scans": intensity against receive angle with residuals, a panel for each scan (at most 24); "mu_eff": half width
    against the turn of the sample, polar. scale: 0.25 to 4 times 1600 and 1000 pixels across."""

def material_from_fits(
    fits: list[Fit], base: Mapping[str, Any] | None = None, name: str = ""
) -> dict[str, Any]:
    """The base material (default: the default material) with the fitted parts and their records (key "fit").
    An absolute weight makes the material's weights measured; a relative one stays in the record."""

# --- photographs: docs/capture.md, docs/capture_diffuse.md ------------------------------------------

class CaptureSetup:
    """Photographs under diffuse light and how they were taken (cpp_core/capture/diffuse_setup.hpp). Read-only."""

    file: str
    material: str
    surface: str  # "none", "plate", "plane" or "blade"
    camera: dict[str, Any] | None
    """{"kind", "width_px", "height_px", "scale" (px/mm, or focal length in px), "centre_px", "position_mm", "right",
    "down"} as in cpp_core/capture/camera.hpp; None: not stated."""
    camera_fit: dict[str, Any] | None  # as camera_from_landmarks, where it was found by landmarks
    landmarks: list[dict[str, Any]]  # [{"name", "point_mm", "pixel"}]
    files: list[str]  # of the photographs, absolute or relative to the working folder
    silhouette: str | None  # the picture on whose outline the camera is refined
    outline: dict[str, Any] | None
    """Where the camera was refined on it: {"rms_mm", "p90_mm", "before_rms_mm", "points" found of "outline"}."""

    def to_toml(self) -> str:
        """Text that parse_capture_setup reads back."""

def parse_capture_setup(text: str, name: str = "text") -> CaptureSetup:
    """The text of a set-up. name: where it came from; its folder is where pictures are looked for."""

def read_capture_setup(path: str) -> CaptureSetup:
    """A set-up's file (TOML). InputError names file, line and field."""

def refine_capture_camera(
    setup: CaptureSetup, read_picture: Callable[[str], tuple[F32, bool]]
) -> CaptureSetup:
    """The set-up with its camera refined on the outline in the picture that it names; as it is where it names none.
    read_picture: as capture_diffuse. InputError as camera_on_outline."""

def capture_diffuse_plan(setup: CaptureSetup, options: Mapping[str, Any] = {}) -> dict[str, Any]:
    """What the set-up can tell, before anything is photographed; no picture is read. {"mu_deg" (K), "mu_share" (K),
    "sigma_ln_mu" (K; inf: not at all), "w_share", "blind", "sentences", "photographs" [{"radiance" (K),
    "flat_at_deg"}], "picture" (H, W, 3) uint8}. options: as capture_diffuse."""

def capture_diffuse(
    setup: CaptureSetup,
    read_picture: Callable[[str], tuple[F32, bool]],
    options: Mapping[str, Any] = {},
    *,
    progress: Callable[[float], Any] | None = None,
) -> dict[str, Any]:
    """Maps of w and half widths from photographs under diffuse light.

    read_picture: path -> ((H, W) or (H, W, C) array, the top row first, full scale 1; whether the file holds whole
    numbers, which clip at 1). options, as those of `togishi capture diffuse`: material, hadori, no_geometry, spread,
    known_spread, model_error, max_sigma_w, max_sigma_ln_mu, border_px, threads. progress: called with the share done;
    returning False cancels with InterruptedError.
    {"maps" channel -> (H, W), row 0 the lowest; "quality" {"sigma.w", "sigma.ji.ln_mu_deg", "sigma.ha.ln_mu_deg",
    "sigma.h", "chi2", "mask"} and "usable" (H, W) bool, the top row first; "seen", "masked_w", "masked_mu" pixels,
    "masked" reason -> pixels, "mu_measured", "calibration", "source", "camera" (refined on the outline where
    the set-up names one), "outline" as the set-up's, "notes", "pictures" {"w"; "mu" where measured} (H, W, 3) uint8}."""

CAPTURE_CHANNELS: list[str]
"""N.X N.Y N.Z lobe.ln_mu_deg … flags: of a map from many known lights (docs/capture.md, "What comes out")."""

class CaptureTiles:
    """What capture_lights finished, kept on disk beside its target."""

    width: int
    height: int
    bands: int
    report: dict[str, Any]
    """{"reach" as capture_lights_plan, "lights", "pictures", "bands_resumed", "flagged", "inferred", "reasons" reason ->
    pixels, "calibration_rms_deg" or None, "seconds_reading", "seconds_fitting"}."""

    def read(self, band: int) -> F32:
        """(rows, width, CAPTURE_CHANNELS), the top row first."""

    def property_maps(self) -> dict[str, Any]:
        """{"maps", "usable"} as capture_project takes them, frame "image": ji and ha both have the measured lobe, w
        says by which model it was fitted."""

    def remove(self) -> None:
        """Deletes the file: what was read of it stands elsewhere."""

def capture_lights_plan(path: str, options: Mapping[str, Any] = {}) -> dict[str, Any]:
    """What a set-up of many known lights (.lp) can see; no picture is read. {"lights", "pictures" (paths, exposure by
    exposure), "spacing_deg", "reach_deg", "mu_sure_deg", "mu_mostly_deg", "mu_widest_deg", "sentence"}."""

def capture_lights(
    path: str,
    photographs: Any,
    target: str,
    options: Mapping[str, Any] = {},
    *,
    progress: Callable[[float], Any] | None = None,
) -> CaptureTiles:
    """Normal, lobe and albedo of each pixel from photographs under many known lights.

    photographs: an object with width, height, step (of quantisation, full scale 1; 0: floats), fingerprint (text: which
    files these are) and read(picture, begin, end) -> rows (N, W) or (N, W, C) as stored, in the order of
    capture_lights_plan's pictures, asked from several threads. target: the file that is to be written from the result;
    finished bands stay beside it. options, as those of `togishi capture lights`: positions, intensities, brackets
    [(path, ratio)], mm_per_pixel, origin_px, camera_distance_mm, view, normal, model, metal, light, light_error_deg,
    self_calibrate, transfer, black, clip, snr, read_noise, white_patch, white_reflectance, pedestal, haze_width, prior
    (mu_t, mu_b, rho), prior_sigma, effort, threads, memory_mib, band_rows. progress: called ten times a second with the
    share done; returning False stops with InterruptedError, and the same call goes on from there."""

def blade_landmarks(katana_parameters: Mapping[str, Any]) -> dict[str, tuple[float, float, float]]:
    """Places that every generated blade has (tip, ha_machi, mune_machi, …): name -> (x, y, z) in mm in its frame."""

def camera_from_landmarks(
    landmarks: list[Mapping[str, Any]],
    width_px: int,
    height_px: int,
    kind: str = "orthographic",
    facing: tuple[float, float, float] = (0, 1, 0),
    max_residual_mm: float = 2.0,
) -> dict[str, Any]:
    """The camera of a photograph from [{"name", "point_mm", "pixel"}] (pixels from the upper left corner): orthographic
    by 4 or more, pinhole by 6 or more not in one plane. {"camera", "residual_mm", "residual_px", "rms_mm"}. facing:
    from the blade to the camera, roughly (orthographic). InputError where they do not determine it, naming why."""

def camera_on_outline(
    katana_parameters: Mapping[str, Any],
    camera: Mapping[str, Any],
    picture: F32,
    landmarks: list[Mapping[str, Any]] = [],
    *,
    search_mm: float = 4.0,
    detail: float = 1.0,
) -> dict[str, Any]:
    """{"camera", "outline" as CaptureSetup's}: a camera refined on the blade's outline against a plain ground. picture:
    (H, W), the top row first. landmarks: those that gave the camera; they keep what an outline does not tell. InputError
    where the outline is not found within search_mm of where the camera puts it."""

def capture_project(
    katana_parameters: Mapping[str, Any],
    photographs: list[Mapping[str, Any]],
    width: int = 4096,
    height: int = 512,
    *,
    feather_px: float = 0.0,
    detail: float = 1.0,
    progress: Callable[[float], Any] | None = None,
) -> dict[str, Any]:
    """Maps of photographs onto the blade's own chart. photographs: [{"maps" (row 0 the lowest), "camera", "usable" (top
    row first, may be left out), "frame": "surface" or "image"}]. {"maps", "coverage" (H, W; 0: a hole), "on_blade" and
    "holes" texels}. feather_px: over which a photograph fades towards its border; 0: all of it. progress: called with
    the share done; returning False cancels with InterruptedError."""

# --- scanned swords: docs/scan_import.md -----------------------------------------------------------

class ScannedSword:
    """A scan that was measured. Where it is no whole blade (report["verdict"]["is_blade"]) there is no mesh, and its
    arrays raise InputError."""

    positions_mm: F64  # (V, 3), blade axes: mune-machi in the origin, tip on +x, back up
    corner_vertex: I32  # (C,)
    face_start: I32  # (F + 1,)
    face_part: NDArray[np.uint8]  # (F,) index into PART_NAMES
    corner_normal: F32  # (C, 3)
    corner_tangent: F32  # (C, 4)
    corner_uv: F32  # (C, 2)
    s_mm: F32  # (V,)
    t_mm: F32  # (V,)
    frame: dict[str, Any]  # {"frame": ...}, as steel_pattern takes it
    report: dict[str, Any]
    """verdict {is_blade, kind, text}, unit {mm_per_unit, text}, dimensions [{key, label, value, sigma, unit, inferred,
    note, points_mm}], mune, zukuri, notes, inferred, pose {rotation, origin_mm}, seconds by step."""
    maps: dict[
        str, Any
    ]  # normal (H, W, 3) unit, displacement_mm (H, W), colour (H, W, 4) where the scan has it
    painted: I32 | None  # (F,), -1 where nothing was painted
    aside: list[dict[str, Any]]  # {positions_mm, triangles, text} of pieces that are no blade

    def record(
        self,
        about: Mapping[str, str],
        inputs: list[Mapping[str, Any]],
        outputs: list[Mapping[str, Any]],
    ) -> str:
        """The record as JSON-LD. about: object_id, title, holder, rights, created_utc; files: name, role, sha256,
        bytes."""

def scan_import(
    positions: F32,
    triangles: I32,
    colours: NDArray[np.uint8] | None,
    origin: tuple[float, float, float] | F64,
    options: Mapping[str, Any],
    *,
    painted: Mapping[str, Any] | None = None,
    progress: Callable[[float], bool | None] | None = None,
) -> ScannedSword:
    """From a scan's arrays to a blade. positions (V, 3): told from origin, in the file's unit; triangles (F, 3); colours
    (V, 4) sRGB. options: mm_per_unit (0: by the length), error_mm (0: by the noise), close_holes_mm, texture_px (256 to
    32768), levels, replicates, swap_ends, swap_edge_and_back. painted: {origin_mm, positions_mm (told from it),
    triangles, part} in the scan's coordinates. progress: called with the share done; returning False cancels (InterruptedError)."""

def scan_import_file(
    path: str | os.PathLike[str],
    options: Mapping[str, Any],
    *,
    painted: Mapping[str, Any] | None = None,
    progress: Callable[[float], bool | None] | None = None,
) -> ScannedSword:
    """As scan_import(), from a PLY, OBJ or STL file, which is held to what it promises."""

def check_gltf(path: str | os.PathLike[str]) -> None:
    """Hold a glTF or GLB file to what it promises before another program reads it. InputError names what is wrong."""

# --- the shared formulas, for tests -------------------------------------------------------------

def formula_names() -> list[str]:
    """Names of the functions of shaders/shared that formulas() evaluates."""

def formulas(name: str, precision: str, inputs: F64) -> F64:
    """One function of shaders/shared on rows of numbers, as the core computes it. A test interface.

    precision: "f32" (inputs are rounded to float first) or "f64". inputs (N, K): the arguments, structs and
    vectors flattened in the order of declaration; result (N, M) likewise."""
