"""The settings that Togishi keeps in a .blend, and plain functions that read them.

| where | what |
|---|---|
| material.togishi | metal, weights, lobes per part, map images, pattern recipe |
| light.togishi, world.togishi | spectrum |
| scene.togishi | samples, passes, observer, adaptation |
| object.togishi | the recipe of a generated blade |

Angles are degrees, as people read them; names carry the unit. Nothing here loads the native module
except the lists behind the menus.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import blender_versions
from .core import fit_apply, native, spectrum_spec

MATERIAL_FORMAT = 1

# The parts that have a lobe, in the order in which panels show them: name, label, and which
# measured constant the part's weight is (docs: chi for the smooth model, beta for the rough one).
LOBE_PARTS = (
    ("ji", "Ji", "chi"),
    ("ha", "Ha (hamon)", "beta"),
    ("hadori", "Hadori", "beta"),
    ("shinogi_ji", "Shinogi-ji", "chi"),
    ("mune", "Mune", "chi"),
    ("kissaki", "Kissaki", "chi"),
    ("nakago", "Nakago", ""),
)

# Called with the material after an edit; the node group subscribes here.
material_edited: list[Callable[[bpy.types.Material], None]] = []

_updates_held = 0


class held_updates:
    """Within it, edits do not notify; for setting many values at once. Notify once afterwards."""

    def __enter__(self) -> None:
        global _updates_held
        _updates_held += 1

    def __exit__(self, *_: object) -> None:
        global _updates_held
        _updates_held -= 1


def notify(material: bpy.types.Material) -> None:
    """Tell the subscribers that a material changed."""
    if not _updates_held:
        for callback in material_edited:
            callback(material)


def _edited(self: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    if isinstance(self.id_data, bpy.types.Material):
        notify(self.id_data)


def _normal_image_chosen(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Files come as sRGB; a direction is no colour. An image with unsaved pixels would lose them by the change."""
    image = self.normal_image
    own = image is not None and image.library is None and not image.is_dirty
    if own and not image.colorspace_settings.is_data:
        image.colorspace_settings.name = "Non-Color"
    _edited(self, context)


def _shown(self: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Scripts' edits reach the viewports too. Without an update function Blender tells them of edits in panels only."""
    self.id_data.update_tag()


def _passes_changed(self: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """The compositor's Render Layers gets a socket for a pass, or loses it."""
    scene = self.id_data
    scene.update_tag()
    for layer in scene.view_layers:
        layer.update_render_passes()


# --- menus over text ----------------------------------------------------------------------------
# A dynamic enum keeps a number in the file, which means another entry when the list changes. So the
# file keeps the name, and the menu reads and writes it.


def _menu(
    target: str, entries: Callable[[], list[tuple[str, str, str]]], name: str, description: str
) -> Any:
    """An enum property over the text property `target`. entries() -> (identifier, label, tooltip)."""
    kept: list[tuple[str, str, str, int]] = []  # Blender keeps no copy of the strings

    def items(self: Any, _context: Any) -> list[tuple[str, str, str, int]]:
        value = getattr(self, target)
        rows = entries()
        if value not in {row[0] for row in rows}:
            rows = [*rows, (value, value or "None", "Not in this version's list")]
        numbered = [(*row, index) for index, row in enumerate(rows)]
        if numbered != kept:
            kept[:] = numbered
        return kept

    def get(self: Any) -> int:
        value = getattr(self, target)
        return next(row[3] for row in items(self, None) if row[0] == value)

    def put(self: Any, index: int) -> None:
        setattr(self, target, items(self, None)[index][0])

    return EnumProperty(items=items, get=get, set=put, name=name, description=description)


FILE_CHOICE = "file"


def _metal_entries() -> list[tuple[str, str, str]]:
    if native.problem():
        return []
    rows = [(m["name"], m["title"], m["source"]) for m in native.core().metals()]
    return [*rows, (FILE_CHOICE, "From a file…", "A file of wavelength, n and k of your own")]


def _light_entries() -> list[tuple[str, str, str]]:
    automatic = (
        spectrum_spec.AUTOMATIC,
        "Automatic",
        "A blackbody at the light's own temperature where that is in use, else daylight D65",
    )
    built_in = (
        []
        if native.problem()
        else [
            # A closed menu shows the beginning only; the name says "CIE" to whom it does.
            (s["name"], f"{s['name']}: {s['title'].split(', CIE')[0]}", s["source"])
            for s in native.core().lights()
        ]
    )
    return [
        automatic,
        *built_in,
        (spectrum_spec.BLACKBODY, "Blackbody…", "An incandescent body at a temperature in K"),
        (spectrum_spec.DAYLIGHT, "Daylight…", "A phase of daylight by colour temperature in K"),
        (spectrum_spec.LINE, "Single line…", "Light of one wavelength, such as a laser"),
        (spectrum_spec.CSV, "From a file…", "A text file of wavelength in nm and power"),
    ]


# --- groups -------------------------------------------------------------------------------------


def _mu(name: str, default: float, description: str) -> Any:
    return FloatProperty(
        name=name,
        description=description,
        default=default,
        min=0.001,
        max=80.0,
        soft_min=0.05,
        soft_max=20.0,
        precision=3,
        step=5,
        update=_edited,
    )


class TogishiLobe(bpy.types.PropertyGroup):
    """The lobe of one part. Polishing strokes run at rho + 90 degrees."""

    mu_t_deg: _mu(
        "μ wide (°)",
        0.8,
        "Half width at half maximum of the facet angle along the lobe's wide axis, in degrees",
    )
    mu_b_deg: _mu(
        "μ narrow (°)",
        0.8,
        "Half width at half maximum across the wide axis, in degrees. Equal to the wide one: isotropic",
    )
    rho_deg: FloatProperty(
        name="ρ (°)",
        description=(
            "Direction of the wide axis in degrees, counter-clockwise from the blade's length. "
            "Strokes run at ρ + 90°, and highlights are long across the strokes"
        ),
        default=0.0,
        min=0.0,
        max=180.0,
        precision=1,
        step=100,
        update=_edited,
    )
    weight: FloatProperty(
        name="Measured weight (1/sr)",
        description=(
            "The measured constant: χ of the smooth parts, β of hamon and hadori. "
            "Used where the material's weights are measured"
        ),
        default=1.0,
        min=0.0,
        soft_max=1000.0,
        precision=4,
        update=_edited,
    )


def _amount(name: str, default: float, low: float, high: float, description: str) -> Any:
    return FloatProperty(
        name=name, description=description, default=default, min=low, max=high, precision=2, step=5
    )


class TogishiPattern(bpy.types.PropertyGroup):
    """The recipe of the steel pattern that fills the maps. Used when maps are baked.

    Every field but the size in texels has the name that togishi_core.steel_pattern takes."""

    hamon: EnumProperty(
        name="Hamon",
        description="Outline of the hardened edge",
        items=(
            ("suguha", "Suguha", "Straight", 0),
            ("notare", "Notare", "Slow waves", 1),
            ("gunome", "Gunome", "Semicircles", 2),
            ("choji", "Choji", "Clove buds", 3),
            ("ko_choji", "Ko-choji", "Small clove buds", 4),
            ("midare", "Midare", "Irregular", 5),
        ),
        default="gunome",
    )
    hada: EnumProperty(
        name="Hada",
        description="Grain of the folded steel",
        items=(
            ("itame", "Itame", "Wood grain, irregular", 0),
            ("masame", "Masame", "Straight grain along the blade", 1),
            ("mokume", "Mokume", "Burl grain", 2),
            ("ayasugi", "Ayasugi", "Regular waves", 3),
            ("nashiji", "Nashiji", "Fine, like the skin of a pear", 4),
            ("muji", "Muji", "None to be seen", 5),
        ),
        default="itame",
    )
    boshi: EnumProperty(
        name="Boshi",
        description="The hamon in the point",
        items=(
            ("komaru", "Ko-maru", "A small round turn-back", 0),
            ("omaru", "O-maru", "A large round turn-back", 1),
            ("midare_komi", "Midare-komi", "The hamon's pattern goes on into the point", 2),
            ("yakizume", "Yakizume", "No turn-back", 3),
        ),
        default="komaru",
    )
    seed: IntProperty(
        name="Seed",
        description="Another number gives another blade of the same styles",
        default=1,
        min=0,
        max=2**31 - 1,
    )
    hamon_height_mm: _amount(
        "Height (mm)", 8.0, 0.5, 40.0, "Mean height of the hamon over the edge at the machi, in mm"
    )
    hamon_amplitude: _amount(
        "Amplitude", 1.0, 0.0, 3.0, "Height of the waves, relative to the style's own"
    )
    hamon_scale: _amount(
        "Wave length",
        1.0,
        0.25,
        4.0,
        "Length of the waves along the blade, relative to the style's own",
    )
    yakidashi_mm: _amount(
        "Yakidashi (mm)", 35.0, 0.0, 300.0, "Length of the calm start over the ha-machi, in mm"
    )
    asymmetry: _amount("Asymmetry", 0.35, 0.0, 1.0, "0: both sides equal; 1: nothing in common")
    nioiguchi_mm: _amount("Nioiguchi (mm)", 0.45, 0.05, 5.0, "Width of the misty line in mm")
    nioiguchi: _amount("Nioiguchi", 0.6, 0.0, 1.0, "How much the misty line stands out of the ha")
    nie: _amount("Nie", 0.5, 0.0, 1.0, "Amount of visible grains")
    ashi: _amount("Ashi", 0.6, 0.0, 1.0, "Legs from the hamon's valleys towards the edge")
    yo: _amount("Yo", 0.4, 0.0, 1.0, "Leaves: spots within the ha")
    sunagashi: _amount(
        "Sunagashi", 0.5, 0.0, 1.0, "Swept-sand lines in the ha, and the bright kinsuji among them"
    )
    utsuri: _amount("Utsuri", 0.25, 0.0, 1.0, "Misty reflection in the ji")
    boshi_kaeri_mm: _amount(
        "Kaeri (mm)", 7.0, 0.0, 100.0, "Length of the boshi's turn-back along the mune, in mm"
    )
    hada_scale: _amount(
        "Grain size", 1.0, 0.2, 5.0, "Size of the grain, relative to the style's own"
    )
    hada_strength: _amount(
        "Grain strength", 0.5, 0.0, 1.0, "How much the grain changes the roughness"
    )
    hadori: _amount(
        "Hadori", 0.4, 0.0, 1.0, "Whiteness of the polisher's hadori; 0: sashikomi polish"
    )
    hadori_margin_mm: _amount(
        "Hadori margin (mm)",
        0.3,
        0.0,
        10.0,
        "Outline of the hadori above the hamon's crests, in mm",
    )
    hadori_smoothing_mm: _amount(
        "Hadori smoothing (mm)",
        4.5,
        0.5,
        30.0,
        "How far along the blade the hadori's outline ignores the hamon's detail, in mm",
    )
    hadori_softness_mm: _amount(
        "Hadori softness (mm)",
        3.5,
        0.1,
        20.0,
        "Width in mm over which the hadori fades towards the ji",
    )
    stroke_wander_deg: _amount(
        "Stroke wander (°)",
        3.0,
        0.0,
        20.0,
        "Standard deviation of the polishing strokes' direction, in degrees",
    )
    width_px: IntProperty(
        name="Width",
        description="Texels along the blade. 8192 gives 9 texels per mm on a katana",
        default=4096,
        min=16,
        max=16384,
        subtype="PIXEL",
    )
    height_px: IntProperty(
        name="Height",
        description="Texels across the blade, omote and ura together",
        default=512,
        min=16,
        max=4096,
        subtype="PIXEL",
    )


def _lobe_pointer(label: str) -> Any:
    return PointerProperty(type=TogishiLobe, name=label)


class TogishiMaterial(bpy.types.PropertyGroup):
    """A blade material."""

    is_blade: BoolProperty(
        name="Blade steel",
        description="Togishi shades this material as polished steel, from its spectra and lobes",
        default=False,
        update=_edited,
    )
    title: StringProperty(
        name="Name",
        description="The material's name in its file",
        default="",
    )
    source: StringProperty(
        name="Source",
        description="Where the material's values come from: measurement, place, date",
        default="",
    )
    licence: StringProperty(
        name="Licence",
        description="Licence of the material's values, such as CC0-1.0",
        default="",
    )
    metal: StringProperty(
        name="Metal",
        description="A built-in metal's name",
        default="iron_johnson_christy",
        update=_edited,
    )
    metal_choice: _menu(
        "metal",
        _metal_entries,
        "Metal",
        "Measured refractive index that the steel's colour comes from",
    )
    metal_path: StringProperty(
        name="File",
        description="A file of wavelength in nm, n and k",
        default="",
        subtype="FILE_PATH",
        options={"ANIMATABLE"} | blender_versions.RELATIVE_PATH,
        update=_edited,
    )
    weights: EnumProperty(
        name="Weights",
        description="What sets how much the lobes reflect",
        items=(
            (
                "normalised",
                "Normalised",
                "The energy stays when the roughness changes; a smooth blade mirrors a room exactly",
                0,
            ),
            ("measured", "Measured", "Constants χ and β as fitted to a measurement", 1),
        ),
        default="normalised",
        update=_edited,
    )
    fit_json: StringProperty(
        name="Fits",
        description="Records of the goniometer fits behind ji and ha, as JSON",
        default="",
        options={"HIDDEN"},
    )
    ji: _lobe_pointer("Ji")
    shinogi_ji: _lobe_pointer("Shinogi-ji")
    mune: _lobe_pointer("Mune")
    kissaki: _lobe_pointer("Kissaki")
    ha: _lobe_pointer("Ha")
    hadori: _lobe_pointer("Hadori")
    nakago: _lobe_pointer("Nakago")
    nakago_albedo: FloatVectorProperty(
        name="Nakago colour",
        description="Colour of the nakago's rust (linear RGB)",
        default=(0.035, 0.022, 0.016),
        min=0.0,
        max=1.0,
        size=3,
        subtype="COLOR",
        update=_edited,
    )
    nakago_ior: FloatProperty(
        name="Nakago index",
        description="Refractive index of the rust's surface",
        default=1.5,
        min=1.0,
        max=4.0,
        precision=3,
        update=_edited,
    )
    lobes_image: PointerProperty(
        type=bpy.types.Image,
        name="Lobes",
        description="Map of ln μ of the ji (R), ln μ of the ha (G), hamon w (B) and hadori h (A)",
        update=_edited,
    )
    shape_image: PointerProperty(
        type=bpy.types.Image,
        name="Shape",
        description="Map of the lobes' shapes: e1, e2 of the ji (R, G) and of the ha (B, A)",
        update=_edited,
    )
    normal_image: PointerProperty(
        type=bpy.types.Image,
        name="Normal Map",
        description=(
            "Fine shape that the mesh lacks: 0.5 + 0.5 n in the chart togishi_uv, red towards the tip, green along v"
        ),
        update=_normal_image_chosen,
    )
    pattern: PointerProperty(type=TogishiPattern, name="Pattern")
    node_spectrum: StringProperty(
        name="Baked light",
        description="Light spectrum that the Cycles and EEVEE node group is baked for",
        default="D65",
        update=_edited,
    )


class TogishiSpectrum(bpy.types.PropertyGroup):
    """The spectrum of a light or a world. It is a shape: Blender's power sets the amount."""

    kind: StringProperty(
        name="Spectrum",
        description="Name of the spectrum",
        default=spectrum_spec.AUTOMATIC,
        update=_shown,
    )
    choice: _menu("kind", _light_entries, "Spectrum", "Which colours the light consists of")
    blackbody_k: FloatProperty(
        name="Temperature (K)",
        description="Temperature of the blackbody, in kelvin. A tungsten lamp has 2700 to 3200",
        default=2856.0,
        min=500.0,
        max=25000.0,
        soft_min=1500.0,
        soft_max=10000.0,
        step=5000,
        precision=0,
        update=_shown,
    )
    daylight_k: FloatProperty(
        name="Colour temperature (K)",
        description="Correlated colour temperature of the daylight, in kelvin",
        default=5500.0,
        min=4000.0,
        max=25000.0,
        soft_max=10000.0,
        step=5000,
        precision=0,
        update=_shown,
    )
    line_nm: FloatProperty(
        name="Wavelength (nm)",
        description="Wavelength of the line, in nm. Sodium has 589.3",
        default=589.3,
        min=400.0,
        max=700.0,
        step=100,
        precision=2,
        update=_shown,
    )
    csv_path: StringProperty(
        name="File",
        description="Text file with a wavelength in nm and a power in each line",
        default="",
        subtype="FILE_PATH",
        options={"ANIMATABLE"} | blender_versions.RELATIVE_PATH,
        update=_shown,
    )


class TogishiScene(bpy.types.PropertyGroup):
    """Render settings."""

    samples: IntProperty(
        name="Render samples",
        description="Samples per pixel of the final render",
        default=16,
        min=1,
        max=64,
        update=_shown,
    )
    viewport_samples: IntProperty(
        name="Viewport samples",
        description="Samples per pixel that the viewport gathers while nothing moves",
        default=8,
        min=1,
        max=64,
        update=_shown,
    )
    mirror_things: BoolProperty(
        name="Mirror Objects",
        description="The blade mirrors the stand, the cloth and whatever else is near it. Off saves time",
        default=True,
        update=_shown,
    )
    filter_highlights: BoolProperty(
        name="Filter Highlights",
        description=(
            "Take the mean of each highlight over a pixel: narrow ones on curved steel keep their light and do not "
            "flicker when something moves"
        ),
        default=True,
        update=_shown,
    )
    use_pass_depth: BoolProperty(
        name="Depth",
        description="Write the distance to the camera",
        default=False,
        update=_passes_changed,
    )
    use_pass_part: BoolProperty(
        name="Part id",
        description="Write which part of the blade a pixel shows (1 ji, 2 shinogi-ji, 3 ha, …)",
        default=False,
        update=_passes_changed,
    )
    observer: EnumProperty(
        name="Observer",
        description="Colour matching functions of the standard observer",
        items=(
            ("cie1931_2", "CIE 1931 2°", "For small fields; the usual one", 0),
            ("cie1964_10", "CIE 1964 10°", "For fields over 4°", 1),
        ),
        default="cie1931_2",
        update=_shown,
    )
    adaptation: EnumProperty(
        name="Adaptation",
        description="What the eye's adaptation to the light does to its colour",
        items=(
            ("none", "None", "Colours as they are: tungsten light looks orange", 0),
            ("cat16", "CAT16", "The light adapted to appears white (CAT16)", 1),
            ("bradford", "Bradford", "The light adapted to appears white (Bradford)", 2),
        ),
        default="none",
        update=_shown,
    )
    adapted_to: EnumProperty(
        name="Adapted To",
        description="Which light the eye is adapted to",
        items=(
            ("each", "Each Lamp", "Every lamp for itself: all of them appear white", 0),
            (
                "room",
                "Room's Light",
                "One light, as a visitor of the room: others keep their tint",
                1,
            ),
        ),
        default="each",
        update=_shown,
    )
    white: PointerProperty(type=TogishiSpectrum, name="Room's Light")


def _kept(name: str, description: str) -> Any:
    return StringProperty(name=name, description=description, default="", options={"HIDDEN"})


class TogishiScan(bpy.types.PropertyGroup):
    """Where a scanned blade came from and what was found; written by the import, read by panels."""

    filepath: _kept("File", "The scan's file")
    sha256: _kept("SHA-256", "Of the scan's file when it was imported")
    report_json: _kept("Found", "Verdict, dimensions and steps of the import, as JSON")
    options_json: _kept("Options", "How the scan was imported, as JSON")
    about_json: _kept("About", "Object, holder and rights as they were given, as JSON")
    unit_m: FloatProperty(
        name="Unit",
        description="Metres per unit of the blade's mesh: the scene's unit when it was made",
        default=1.0,
        options={"HIDDEN"},
    )
    record: PointerProperty(type=bpy.types.Text, name="Record")
    normal_image: PointerProperty(type=bpy.types.Image, name="Normals")
    displacement_image: PointerProperty(type=bpy.types.Image, name="Displacement")
    colour_image: PointerProperty(type=bpy.types.Image, name="Colours")
    show_dimensions: BoolProperty(
        name="Show Dimensions",
        description="Draw what was measured over the blade, in views with overlays",
        default=True,
    )


class TogishiObject(bpy.types.PropertyGroup):
    """What a blade is made from: dimensions where it was generated, its chart where it was scanned."""

    katana_json: StringProperty(
        name="Dimensions",
        description="Dimensions of the generated blade in mm, as JSON; empty for other objects",
        default="",
        options={"HIDDEN"},
    )
    detail: FloatProperty(
        name="Detail",
        description="Density of the generated mesh",
        default=1.0,
        min=0.02,
        max=16.0,
    )
    frame_json: _kept("Chart", "Outline of a scanned blade in its chart, as JSON")
    scan: PointerProperty(type=TogishiScan, name="Scan")


# --- plain readers ------------------------------------------------------------------------------


def is_blade(material: bpy.types.Material | None) -> bool:
    """Whether the material is shaded as polished steel."""
    return material is not None and material.togishi.is_blade


def metal_spec(material: bpy.types.Material) -> str:
    """Name of the built-in metal, or the absolute path of the user's file."""
    settings = material.togishi
    if settings.metal == FILE_CHOICE:
        # A file that was not chosen yet gives the default, as with lights.
        if not settings.metal_path:
            return str(settings.bl_rna.properties["metal"].default)
        return bpy.path.abspath(settings.metal_path, library=material.library)
    return str(settings.metal)


def lobe_dict(lobe: TogishiLobe) -> dict[str, float]:
    """mu_t_deg >= mu_b_deg and rho_deg in [0, 180): a lobe entered the other way round is turned."""
    mu_t, mu_b, rho = float(lobe.mu_t_deg), float(lobe.mu_b_deg), float(lobe.rho_deg)
    if mu_b > mu_t:
        mu_t, mu_b, rho = mu_b, mu_t, rho + 90.0
    # Single precision as a person typed it: .8 is to read .8 in a file, not .800000011920929.
    return {
        "mu_t_deg": float(spectrum_spec.number(mu_t)),
        "mu_b_deg": float(spectrum_spec.number(mu_b)),
        "rho_deg": float(spectrum_spec.number(rho % 180.0)),
    }


def material_dict(material: bpy.types.Material, with_fits: bool = False) -> dict[str, Any]:
    """The material in the schema of togishi_core.default_material(); where asked for, with the records of the fits
    behind it."""
    settings = material.togishi
    parts: dict[str, dict[str, Any]] = {}
    for name, _label, constant in LOBE_PARTS:
        lobe = getattr(settings, name)
        parts[name] = lobe_dict(lobe)
        if settings.weights == "measured" and constant:
            parts[name][constant] = float(spectrum_spec.number(lobe.weight))
    parts["nakago"]["albedo_rgb"] = [
        float(spectrum_spec.number(channel)) for channel in settings.nakago_albedo
    ]
    parts["nakago"]["ior"] = float(spectrum_spec.number(settings.nakago_ior))
    values = {
        "format": MATERIAL_FORMAT,
        "name": settings.title or material.name,
        "metal": metal_spec(material),
        "weights": settings.weights,
        "source": settings.source,
        "licence": settings.licence,
        "parts": parts,
    }
    if with_fits and settings.fit_json:
        fits = fit_apply.records_that_hold(json.loads(settings.fit_json), parts)
        if fits:
            values["fit"] = fits
    return values


def set_material_dict(material: bpy.types.Material, values: dict[str, Any]) -> None:
    """Take the values of a material dict (as load_material returns) into the settings."""
    settings = material.togishi
    with held_updates():
        settings.title = values["name"]
        settings.source = values.get("source", "")
        settings.licence = values.get("licence", "")
        known = {entry[0] for entry in _metal_entries()}
        if values["metal"] in known:
            settings.metal = values["metal"]
        else:
            settings.metal = FILE_CHOICE
            settings.metal_path = values["metal"]
        settings.weights = values["weights"]
        settings.fit_json = json.dumps(values["fit"]) if values.get("fit") else ""
        for name, _label, constant in LOBE_PARTS:
            lobe, part = getattr(settings, name), values["parts"][name]
            lobe.mu_t_deg = part["mu_t_deg"]
            lobe.mu_b_deg = part["mu_b_deg"]
            lobe.rho_deg = part["rho_deg"]
            if constant and constant in part:
                lobe.weight = part[constant]
        settings.nakago_albedo = values["parts"]["nakago"]["albedo_rgb"]
        settings.nakago_ior = values["parts"]["nakago"]["ior"]
    notify(material)


def set_pattern_dict(material: bpy.types.Material, values: dict[str, Any]) -> None:
    """Take a recipe (as steel_defaults returns) into the settings."""
    pattern = material.togishi.pattern
    for name, value in values.items():
        setattr(pattern, name, value)


def blade_images(
    material: bpy.types.Material,
) -> tuple[bpy.types.Image | None, bpy.types.Image | None]:
    """The map images (lobes, shape), each None where the material has none."""
    settings = material.togishi
    return settings.lobes_image, settings.shape_image


def _settings(group: TogishiSpectrum, library: Any) -> spectrum_spec.SpectrumSettings:
    path = bpy.path.abspath(group.csv_path, library=library) if group.csv_path else ""
    return spectrum_spec.SpectrumSettings(
        kind=group.kind,
        blackbody_k=group.blackbody_k,
        daylight_k=group.daylight_k,
        line_nm=group.line_nm,
        csv_path=path,
    )


def light_spectrum(light: bpy.types.Light) -> str:
    """Spec string of the light's spectrum. A spectrum that was chosen replaces the light's own
    temperature; "automatic" follows it."""
    own = blender_versions.light_temperature_k(light)
    return spectrum_spec.spec(_settings(light.togishi, light.library), own)


def world_spectrum(world: bpy.types.World | None) -> str:
    """Spec string of the surroundings' spectrum."""
    if world is None:
        return spectrum_spec.DEFAULT
    return spectrum_spec.spec(_settings(world.togishi, world.library))


def adapted_white(scene: bpy.types.Scene) -> str:
    """Spec string of the light that a visitor is adapted to; "" where each lamp has its own white."""
    settings = getattr(scene, "togishi", None)
    if settings is None or settings.adaptation == "none" or settings.adapted_to == "each":
        return ""
    return spectrum_spec.spec(_settings(settings.white, scene.library))


def blade_recipe(obj: bpy.types.Object) -> dict[str, Any] | None:
    """What togishi_core.steel_pattern lays a pattern over: dimensions of a generated blade, or a scanned one's
    chart; None for other objects."""
    if obj.togishi.frame_json:
        chart: dict[str, Any] = json.loads(obj.togishi.frame_json)
        return chart
    return katana_parameters(obj)


def katana_parameters(obj: bpy.types.Object) -> dict[str, Any] | None:
    """Dimensions of a generated blade as togishi_core.katana takes them; None for other objects."""
    text = obj.togishi.katana_json
    if not text:
        return None
    values: dict[str, Any] = json.loads(text)
    return values


# --- registration -------------------------------------------------------------------------------

CLASSES = (
    TogishiLobe,
    TogishiPattern,
    TogishiMaterial,
    TogishiSpectrum,
    TogishiScene,
    TogishiScan,
    TogishiObject,
)

_POINTERS = (
    (bpy.types.Material, TogishiMaterial),
    (bpy.types.Light, TogishiSpectrum),
    (bpy.types.World, TogishiSpectrum),
    (bpy.types.Scene, TogishiScene),
    (bpy.types.Object, TogishiObject),
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for owner, group in _POINTERS:
        owner.togishi = PointerProperty(type=group)


def unregister() -> None:
    for owner, _group in _POINTERS:
        del owner.togishi
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
