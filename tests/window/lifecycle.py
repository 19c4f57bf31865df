"""The extension's whole life, step by step, as a user lives it: the same script in a real window and without one.

In a window (tools/test_window.sh):
    blender --factory-startup --enable-event-simulate --python lifecycle.py -- --zip Z --out DIR --console FILE
Without (tests/package/test_lifecycle.py, in each bpy wheel):
    python lifecycle.py --zip Z --out DIR --console FILE

FILE is where this process's standard output and error go. After each step it must hold no line of trouble
(console.py). DIR gets lifecycle.json, without a window lifecycle-<version>.json.

**A new feature is exercised by one more function under @step**, at the place in the life where it is used. It runs
everywhere, or with @step(window=True) only in a window; without one it is then listed as left out. A step may
yield: `yield from life.shown()` lets Blender draw what changed, `yield from life.picture()` returns what it drew.
A step fails by an exception. References to Blender's data do not outlive undo or loading: get them anew.
"""

from __future__ import annotations

import importlib
import json
import os
import platform
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "blender")]

from console import Console, options  # noqa: E402

IN_BLENDER = "bpy" in sys.modules or Path(sys.argv[0]).name.startswith("blender")
EXTENSION = "bl_ext.user_default.togishi"
Steps = Iterator[float]


OPTIONS = options()
OPTIONS.out.mkdir(parents=True, exist_ok=True)
if not IN_BLENDER and "BLENDER_USER_RESOURCES" not in os.environ:
    sys.exit("lifecycle.py: BLENDER_USER_RESOURCES must name an empty folder")

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import screen  # noqa: E402
from stack import write_stack  # noqa: E402

WINDOW = not bpy.app.background


# --- the frame of the steps ---------------------------------------------------------------------


@dataclass
class Outcome:
    name: str
    seconds: float = 0.0
    ok: bool = True
    skipped: bool = False
    note: str = ""


@dataclass
class Life:
    """What the steps share."""

    console: Console
    out: Path
    outcomes: list[Outcome] = field(default_factory=list)
    rss_growth_mb_per_100_redraws: float | None = None
    install_to_picture_s: float | None = None
    installed_at: float = 0.0
    draws: Any = None
    shots: Any = None
    note: str = ""
    finished: bool = False
    _renderer: Any = None  # of pictures without a window

    @property
    def passed(self) -> bool:
        return self.finished and all(outcome.ok for outcome in self.outcomes)

    def write(self) -> None:
        version = bpy.app.version_string
        name = "lifecycle.json" if WINDOW else f"lifecycle-{version.split()[0]}.json"
        content = {
            "blender": version,
            "python": platform.python_version(),
            "window": WINDOW,
            "passed": self.passed,
            "install_to_picture_s": self.install_to_picture_s,
            "rss_growth_mb_per_100_redraws": self.rss_growth_mb_per_100_redraws,
            "steps": [asdict(outcome) for outcome in self.outcomes],
        }
        part = self.out / f"{name}.part"
        part.write_text(json.dumps(content, indent=1) + "\n")
        part.replace(self.out / name)

    def shown(self) -> Steps:
        """Blender draws what changed: in the window's views, or in our renderer without a window."""
        if WINDOW:
            yield from self.draws.shown()
            return
        yield from self.picture()

    def picture(self) -> Iterator[float]:
        """What the first rendered view shows: (H, W, 3) float32 in [0, 1] as on the screen; without a window
        the renderer's picture of the scene's camera. Rows from the bottom."""
        if not WINDOW:
            yield 0.0
            return self._drawn()
        shading = view_area().spaces.active.shading.type
        engine = bpy.context.window_manager.windows[0].scene.render.engine
        need((shading, engine) == ("RENDERED", "TOGISHI"), f"the view shows {shading} of {engine}")
        result: list[np.ndarray] = []
        # All samples are gathered, and what was drawn is on the screen.
        for _ in range(bpy.context.scene.togishi.viewport_samples + 1):
            yield from self.draws.shown()
        yield 0.2
        region = screen.region_of(view_area())
        yield from self.shots.region(region, "view", result)
        return result[0].astype(np.float32) / 255.0

    def _drawn(self) -> np.ndarray:
        if self._renderer is None:
            self._renderer = part("engine.renderer").Renderer()
        scene = bpy.context.scene
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        data = part("engine.scene_sync").SceneSync().update(depsgraph)
        return self._renderer.draw(data, camera_of(scene), SIZE).read()[..., :3]


SIZE = (160, 90)  # of pictures without a window


@dataclass(frozen=True)
class Step:
    name: str
    run: Callable[[Life], Any]
    window: bool


STEPS: list[Step] = []


def step(name: str, window: bool = False) -> Callable[[Callable[[Life], Any]], Any]:
    """Add a function to the life. window: it cannot be done without one."""

    def add(function: Callable[[Life], Any]) -> Callable[[Life], Any]:
        STEPS.append(Step(name, function, window))
        return function

    return add


def live(life: Life) -> Steps:
    """All steps in turn. Stops at the first one that raises: what follows would only repeat it."""
    for number, one in enumerate(STEPS):
        outcome = Outcome(one.name)
        life.outcomes.append(outcome)
        if one.window and not WINDOW:
            outcome.skipped, outcome.note = True, "needs a window"
            continue
        print(f"--- {number + 1}/{len(STEPS)} {one.name}", flush=True)
        life.write()  # a crash leaves this step as the last
        life.note = ""
        started = time.monotonic()
        try:
            made = one.run(life)
            if made is not None:
                yield from made
            yield 0.0
        except Exception as error:
            outcome.ok = False
            outcome.note = f"{type(error).__name__}: {error}"
            traceback.print_exc()
        outcome.seconds = round(time.monotonic() - started, 3)
        if outcome.ok:
            outcome.note = life.note
            found = life.console.new_problems()
            if found:
                outcome.ok = False
                outcome.note = "console: " + " | ".join(found)
        else:
            break
    life.finished = len(life.outcomes) == len(STEPS)
    life.write()


# --- what steps ask for -------------------------------------------------------------------------


def part(name: str) -> ModuleType:
    """A module of the installed extension."""
    return importlib.import_module(f"{EXTENSION}.{name}")


def camera_of(scene: bpy.types.Scene) -> Any:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera
    projection = camera.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1])
    camera_type = part("core.scene_data").Camera
    view = np.linalg.inv(np.array(camera.matrix_world, np.float64))
    return camera_type(view, np.array(projection, np.float64))


def blade() -> bpy.types.Object:
    return next(obj for obj in bpy.context.scene.objects if obj.togishi.katana_json)


def steel() -> bpy.types.Material:
    return blade().active_material


def lamp() -> bpy.types.Object:
    return next(obj for obj in bpy.context.scene.objects if obj.type == "LIGHT")


def view_area() -> Any:
    return screen.areas("VIEW_3D")[0]


def as_user(area_kind: str = "VIEW_3D") -> Any:
    """Context as if the mouse were over an area; without a window the context as it is."""
    return screen.override(screen.areas(area_kind)[0]) if WINDOW else bpy.context.temp_override()


def need(condition: bool, sentence: str) -> None:
    if not condition:
        raise AssertionError(sentence)


def changed(before: np.ndarray, after: np.ndarray, what: str) -> None:
    """The picture must not be the same."""
    need(np.isfinite(after).all(), f"{what}: the picture holds values that are no numbers")
    need(before.shape == after.shape, f"{what}: the picture changed its size")
    need(float(np.abs(after - before).max()) > 0.02, f"{what}: the picture did not change")


def same(before: np.ndarray, after: np.ndarray, what: str) -> None:
    """The picture must be the same."""
    need(before.shape == after.shape, f"{what}: the picture changed its size")
    difference = float(np.abs(before - after).max())
    if difference > 1.5 / 255.0:
        for name, picture in (("before", before), ("after", after)):
            screen.write_ppm(OPTIONS.out / f"failed_{name}.ppm", picture)
        raise AssertionError(f"{what}: the picture changed, by {difference:.4f}; see failed_*.ppm")


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1.0e6


# --- the life -----------------------------------------------------------------------------------


@step("install and enable")
def install(life: Life) -> Steps:
    preferences = bpy.context.preferences
    if not WINDOW:
        bpy.ops.wm.read_factory_settings(use_empty=True)
    life.installed_at = time.monotonic()
    bpy.ops.extensions.package_install_files(
        filepath=str(OPTIONS.zip), repo="user_default", enable_on_install=True
    )
    need(EXTENSION in preferences.addons, "the extension is not enabled")
    need(not part("core.native").problem(), part("core.native").problem())
    module = Path(part("core.native").core().__file__)
    need(".local" in module.parts, f"the native module is not the extension's: {module}")
    life.note = module.name
    if WINDOW:
        life.draws, life.shots = screen.Draws(), screen.Shots(life.out)
        screen.region_of(view_area())
    yield 0.2


@step("add a katana")
def add_katana(life: Life) -> Steps:
    for obj in list(bpy.data.objects):  # the factory file's cube, light and camera
        bpy.data.objects.remove(obj)
    with as_user():
        bpy.ops.mesh.togishi_katana_add("INVOKE_DEFAULT" if WINDOW else "EXEC_DEFAULT")
    yield 0.1
    scene = bpy.context.scene
    need(len(blade().data.polygons) > 10000, "the blade is coarse")
    need(steel().togishi.lobes_image is not None, "the blade has no maps")
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.4, 1.5, 0.0), (np.pi / 2, 0.0, np.pi)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = 320, 180
    # Maps of the usual size were baked now; what follows is about something else.
    steel().togishi.pattern.width_px, steel().togishi.pattern.height_px = 1024, 128
    life.note = f"{len(blade().data.vertices)} vertices"


@step("normals are exact")
def normals(life: Life) -> None:
    """What the engine is given, against the core's: .7° of rounding would be as wide as a polished lobe."""
    core = part("core.native").core()
    expected = core.katana(json.loads(blade().togishi.katana_json), blade().togishi.detail)
    bpy.context.view_layer.update()
    mesh = blade().evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    given = part("blender_versions").corner_normals(mesh).astype(np.float64)
    exact = np.asarray(expected.corner_normal, np.float64)
    sine = np.linalg.norm(np.cross(given, exact), axis=1)
    worst_deg = float(np.degrees(np.arcsin(np.clip(sine, 0.0, 1.0)).max()))
    life.note = f"worst {worst_deg:.1e} degrees"
    need(worst_deg < 0.01 and bool((given * exact).sum(axis=1).min() > 0.0), life.note)


@step("choose the engine; first picture")
def first_picture(life: Life) -> Steps:
    scene = bpy.context.scene
    scene.render.engine = "TOGISHI"
    scene.togishi.viewport_samples = 2
    with as_user():
        bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")
    if WINDOW:
        screen.clear_view(view_area())
        space = view_area().spaces.active
        space.shading.type = "RENDERED"
        space.region_3d.view_perspective = "CAMERA"
    else:
        importlib.import_module("gpu_context").ensure_gpu_context()
    picture = yield from life.picture()
    life.install_to_picture_s = round(time.monotonic() - life.installed_at, 2)
    need(float(picture.max()) > 0.1, "the picture is black")
    life.note = f"{life.install_to_picture_s} s after the installation began"


# The window shows 8 bits of half floats: half a step of rounding each, of values up to 1.
PIXEL_TOLERANCE = 1.0 / 255.0
FRAME_PX = 40  # of a view: rounded corners, and arrows that bring hidden headers back


@step("the viewport's pixels are the renderer's", window=True)
def pixels(life: Life) -> Steps:
    """view_draw against the same matrices drawn offscreen, with the view transform out of the way."""
    scene = bpy.context.scene
    kept = (scene.view_settings.view_transform, scene.render.dither_intensity)
    scene.view_settings.view_transform, scene.render.dither_intensity = "Raw", 0.0
    notes = []
    for perspective in ("CAMERA", "PERSP", "ORTHO"):
        view_area().spaces.active.region_3d.view_perspective = perspective
        view_area().spaces.active.region_3d.view_camera_zoom = 60.0  # its frame is out of sight
        for samples in (1, 4):
            scene.togishi.viewport_samples = samples
            shown = yield from life.picture()
            expected = np.clip(_offscreen(samples), 0.0, 1.0)
            need(shown.shape == expected.shape, f"{shown.shape} shown, {expected.shape} drawn")
            inner = (slice(FRAME_PX, -FRAME_PX),) * 2
            shown, expected = shown[inner], expected[inner]
            need(float(expected.max() - expected.min()) > 0.2, "nothing to compare: a flat picture")
            worst = float(np.abs(shown - expected).max())
            notes.append(f"{perspective.lower()} {samples}: {worst * 255.0:.2f}/255")
            need(worst <= PIXEL_TOLERANCE, f"worst difference of {notes[-1]}")
    scene.view_settings.view_transform, scene.render.dither_intensity = kept
    scene.togishi.viewport_samples = 2
    view_area().spaces.active.region_3d.view_perspective = "CAMERA"
    view_area().spaces.active.region_3d.view_camera_zoom = 0.0
    life.note = "worst difference: " + ", ".join(notes)


def _offscreen(samples: int) -> np.ndarray:
    renderers = part("engine.renderer")
    space = view_area().spaces.active
    region = screen.region_of(view_area())
    size = (region.width, region.height)
    scene = bpy.context.scene
    data = (
        part("engine.scene_sync").SceneSync().update(bpy.context.evaluated_depsgraph_get(), space)
    )
    camera = part("engine.camera_read").region_camera(space.region_3d)
    renderer = renderers.Renderer()
    if samples == 1:
        return renderer.draw(data, camera, size).read()[..., :3]
    gathering = renderers.Gathering(renderer, size)
    for number in range(samples):
        offset = gathering.offset(samples, scene.render.filter_size)
        bias = renderers.lod_bias_of(samples) if number else 0.0
        gathering.add(renderer.draw(data, camera, size, jitter=offset, lod_bias=bias))
    return gathering.read()[..., :3] / samples


@step("all light presets")
def light_presets(life: Life) -> Steps:
    presets = part("core.light_presets").PRESETS
    pictures = []
    for preset in presets:
        with as_user():
            bpy.ops.object.togishi_light_preset(preset=preset.identifier)
        pictures.append((yield from life.picture()))
    for preset, one, other in zip(presets[1:], pictures, pictures[1:], strict=False):
        changed(one, other, preset.label)
    life.note = ", ".join(preset.label for preset in presets)


@step("move a light")
def move_light(life: Life) -> Steps:
    before = yield from life.picture()
    # A person moves it in many small steps, each of which is drawn.
    for _ in range(8):
        lamp().location.x += 0.1
        lamp().location.z -= 0.05
        yield from life.shown()
    after = yield from life.picture()
    changed(before, after, "moving a light")


@step("give a light a size")
def size_light(life: Life) -> Steps:
    """A lamp of a size has programs of its own; taken away again, the picture is the former."""
    before = yield from life.picture()
    data, kept = lamp().data, lamp().data.shadow_soft_size
    data.shadow_soft_size = 0.3
    changed(before, (yield from life.picture()), "a lamp's radius")
    data.shadow_soft_size = kept
    again = yield from life.picture()
    need(bool(np.allclose(before, again, atol=2e-3)), "the lamp's radius left a trace")


@step("change a light's spectrum")
def change_spectrum(life: Life) -> Steps:
    with as_user():
        bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")
    settings = lamp().data.togishi
    before = yield from life.picture()
    for choice in ("A", "HPS", "LED-B3", "daylight", "line", "blackbody"):
        settings.choice = choice
        yield from life.shown()
    for kelvin in range(2000, 3200, 100):
        settings.blackbody_k = kelvin
        yield from life.shown()
    for obj in bpy.context.scene.objects:
        if obj.type == "LIGHT":
            obj.data.togishi.choice = "LPS"
    after = yield from life.picture()
    changed(before, after, "sodium light")
    with as_user():
        bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")


@step("edit the material")
def edit_material(life: Life) -> Steps:
    before = yield from life.picture()
    for metal in ("gold_johnson_christy", "copper_johnson_christy"):
        steel().togishi.metal_choice = metal
        yield from life.shown()
    gold = yield from life.picture()
    changed(before, gold, "another metal")
    with as_user():
        bpy.ops.material.togishi_maps_clear()
    constants = yield from life.picture()
    changed(gold, constants, "removing the maps")
    for mu_deg in (0.5, 2.0, 8.0):
        steel().togishi.ji.mu_t_deg = steel().togishi.ji.mu_b_deg = mu_deg
        yield from life.shown()
    rough = yield from life.picture()
    changed(constants, rough, "μ of the ji")
    steel().togishi.ji.rho_deg, steel().togishi.ji.mu_b_deg = 45.0, 1.0
    yield from life.shown()
    steel().togishi.metal_choice = "iron_johnson_christy"
    steel().togishi.ji.mu_t_deg = steel().togishi.ji.mu_b_deg = 0.8


@step("cancel a bake by Esc", window=True)
def cancel_bake(life: Life) -> Steps:
    steel().togishi.pattern.width_px = 4096  # some seconds
    yield from begin_bake()
    yield 0.3
    need(baking(), "the bake does not run beside the window")
    yield from screen.press("ESC", screen.centre(view_area()))
    yield from screen.until(lambda: not baking(), 5.0, "Esc")
    need(steel().togishi.lobes_image is None, "a cancelled bake left a map")
    yield 5.0  # the thread ends by itself, and nobody takes its result
    need(steel().togishi.lobes_image is None, "a cancelled bake left a map later")
    steel().togishi.pattern.width_px = 1024


def baking() -> bool:
    running = screen.window().modal_operators
    return any(operator.bl_idname == "MATERIAL_OT_togishi_pattern_bake" for operator in running)


def begin_bake() -> Steps:
    with as_user():
        result = bpy.ops.material.togishi_pattern_bake("INVOKE_DEFAULT")
    need(result == {"RUNNING_MODAL"}, f"baking: {result}")
    yield 0.0


@step("bake the pattern")
def bake(life: Life) -> Steps:
    steel().togishi.pattern.hamon = "choji"
    before = yield from life.picture()
    if WINDOW:
        yield from begin_bake()
        steel_name = steel().name
        yield from screen.until(
            lambda: bpy.data.materials[steel_name].togishi.lobes_image is not None, 120.0, "baking"
        )
    else:
        bpy.ops.material.togishi_pattern_bake()
    first = yield from life.picture()
    changed(before, first, "the first bake")
    # Again, into the same images: the engine must see that their pixels are new.
    steel().togishi.pattern.hamon = "suguha"
    name = steel().togishi.lobes_image.name
    bpy.ops.material.togishi_pattern_bake()
    need(steel().togishi.lobes_image.name == name, "baking again made another image")
    second = yield from life.picture()
    changed(first, second, "the second bake")


@step("fit a measurement")
def fit_measurement(life: Life) -> Steps:
    core = part("core.native").core()
    options = {"channels": ["intensity_550nm"], "step_deg": 0.5}
    scans = core.simulate_scan(core.default_material(), "hamon", options)
    file = life.out / "scans.csv"
    file.write_text(scans.to_text(), encoding="utf-8")
    with as_user():
        result = bpy.ops.scene.togishi_measurement_fit(filepath=str(file))
    need(result == {"FINISHED"}, f"fitting: {result}")
    yield from screen.until(
        lambda: len(bpy.context.scene.togishi_measurement.fits) == 1, 60.0, "fitting"
    )
    fit = bpy.context.scene.togishi_measurement.fits[0]
    need(fit.scans_image.size[0] == 1600, "the fit's plot is missing")
    yield from life.shown()
    before = steel().togishi.hadori.mu_t_deg
    with as_user():
        bpy.ops.scene.togishi_measurement_apply(part="hadori")
    need(steel().togishi.hadori.mu_t_deg != before, "the fit did not reach the material")


@step("photographs to maps")
def photographs(life: Life) -> None:
    """A stack under sixteen lights; in a build without OpenImageIO the button says that it is missing."""
    image_io = part("map_files").open_image_io()
    if image_io is None:
        need(not bpy.ops.scene.togishi_photographs.poll(), "photographs without OpenImageIO")
        life.note = "no OpenImageIO in this build"
        return
    stack = write_stack(OPTIONS.out / "photographs", image_io, part("core.photographs"))
    with as_user():
        bpy.ops.scene.togishi_photographs(filepath=str(stack))
        bpy.ops.scene.togishi_photographs_run()
    found = bpy.context.scene.togishi_photographs.found
    need("flagged" in found, f"the photographs gave no maps: {found!r}")
    need(stack.with_name("stack-lights.exr").stat().st_size > 0, "no file of maps")


@step("edit the blade's dimensions")
def edit_blade(life: Life) -> Steps:
    before = yield from life.picture()
    with as_user():
        bpy.context.view_layer.objects.active = blade()
        bpy.ops.object.togishi_katana_edit(nagasa_mm=600.0, sori_mm=25.0)
    after = yield from life.picture()
    changed(before, after, "the blade's length")


@step("connect the node groups")
def connect_nodes(life: Life) -> Steps:
    with as_user():
        bpy.ops.material.togishi_nodes_connect(spectrum="A")
        need(steel().togishi.node_spectrum == "A", "the groups are for another light")
        bpy.ops.material.togishi_nodes_bake_for_scene()
    need(any("Togishi Steel" in group.name for group in bpy.data.node_groups), "no node group")
    yield from life.shown()


@step("F12")
def final_render(life: Life) -> Steps:
    scene = bpy.context.scene
    scene.togishi.samples = 4
    done: list[str] = []

    def completed(*_: object) -> None:
        done.append("complete")

    def cancelled(*_: object) -> None:
        done.append("cancelled")

    bpy.app.handlers.render_complete.append(completed)
    bpy.app.handlers.render_cancel.append(cancelled)
    try:
        if WINDOW:
            bpy.context.preferences.view.render_display_type = "WINDOW"
            yield from screen.press("F12", screen.centre(view_area()))
            yield from screen.until(lambda: bool(done), 120.0, "F12")
            yield 1.0
        else:
            bpy.ops.render.render()
    finally:
        bpy.app.handlers.render_complete.remove(completed)
        bpy.app.handlers.render_cancel.remove(cancelled)
    need(done == ["complete"], f"the render ended as {done}")
    pixels = saved_render(life)
    need(np.isfinite(pixels).all() and float(pixels[..., :3].max()) > 0.05, "F12 is black")
    if WINDOW:
        extra = [w for w in bpy.context.window_manager.windows if w != screen.window()]
        for other in extra:
            with bpy.context.temp_override(window=other):
                bpy.ops.wm.window_close()
        yield 0.3
        life.note = f"{len(extra)} window opened and closed"


def saved_render(life: Life) -> np.ndarray:
    scene = bpy.context.scene
    settings = scene.render.image_settings
    part("blender_versions").set_file_format(settings, "OPEN_EXR")
    path = life.out / "f12.exr"
    image = next(i for i in bpy.data.images if i.type == "RENDER_RESULT")
    image.save_render(str(path), scene=scene)
    loaded = bpy.data.images.load(str(path), check_existing=False)
    width, height = loaded.size
    need((width, height) == (320, 180), f"F12 gave {width} x {height}")
    pixels = np.empty(width * height * loaded.channels, np.float32)
    loaded.pixels.foreach_get(pixels)
    bpy.data.images.remove(loaded)
    path.unlink()
    return pixels.reshape(height, width, -1)


@step("save and reopen")
def save_and_reopen(life: Life) -> Steps:
    before = yield from life.picture()
    expected = part("properties").material_dict(steel())
    path = life.out / "lifecycle.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    bpy.ops.wm.read_homefile(use_empty=not WINDOW, use_factory_startup=True)
    yield 0.5
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=True)
    yield 0.5
    if WINDOW:
        life.draws = screen.Draws()  # a new file has views of its own
        # Blender opens every file in solid shading.
        view_area().spaces.active.shading.type = "RENDERED"
    need(part("properties").material_dict(steel()) == expected, "the material came back otherwise")
    after = yield from life.picture()
    same(before, after, "save and reopen")
    path.unlink()


# Without a window Blender keeps no undo stack.
@step("undo and redo 50 times", window=True)
def undo_redo(life: Life) -> Steps:
    bpy.context.preferences.edit.undo_steps = 128  # 32 from the factory
    first = yield from life.picture()

    def state() -> tuple[float, float]:
        return round(lamp().data.energy, 3), round(steel().togishi.ha.mu_t_deg, 3)

    states = [state()]
    bpy.ops.ed.undo_push(message="before")
    for number in range(50):
        lamp().data.energy += 1.0
        steel().togishi.ha.mu_t_deg = 3.0 + 0.1 * number
        if number == 25:
            with as_user():
                bpy.ops.object.togishi_light_preset(preset="SUN")
        bpy.ops.ed.undo_push(message=f"edit {number}")
        states.append(state())
        if number % 10 == 0:
            yield from life.shown()
    last = yield from life.picture()
    for expected in states[-2::-1]:
        with as_user():
            bpy.ops.ed.undo()
        need(state() == expected, f"undo gave {state()}, not {expected}")
        yield from life.shown()
    undone = yield from life.picture()
    for expected in states[1:]:
        with as_user():
            bpy.ops.ed.redo()
        need(state() == expected, f"redo gave {state()}, not {expected}")
        yield from life.shown()
    redone = yield from life.picture()
    same(first, undone, "undo")
    same(last, redone, "redo")


@step("undo and redo an added blade", window=True)
def undo_operators(life: Life) -> Steps:
    count = len(bpy.data.objects)
    with as_user():
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.mesh.togishi_katana_add(preset="TANTO")
        bpy.ops.ed.undo_push(message="tanto")
    yield from life.shown()
    need(len(bpy.data.objects) == count + 1, "no second blade")
    with as_user():
        bpy.ops.ed.undo()
    yield from life.shown()
    need(len(bpy.data.objects) == count, "undo left the second blade")
    with as_user():
        bpy.ops.ed.redo()
    yield from life.shown()
    need(len(bpy.data.objects) == count + 1, "redo did not bring the second blade back")
    with as_user():
        bpy.ops.ed.undo()
    yield from life.shown()


@step("duplicate the scene")
def duplicate_scene(life: Life) -> Steps:
    first = bpy.context.scene.name
    before = yield from life.picture()
    bpy.context.preferences.edit.use_duplicate_material = True
    with as_user():
        bpy.ops.scene.new(type="FULL_COPY")
    scene = bpy.context.window.scene if bpy.context.window else bpy.context.scene
    need(scene.name != first, "no scene was copied")
    copied = yield from life.picture()
    same(before, copied, "the copied scene")
    # The copy's steel is its own.
    other = next(o for o in scene.objects if o.togishi.katana_json)
    original = next(o for o in bpy.data.scenes[first].objects if o.togishi.katana_json)
    need(other.active_material != original.active_material, "both scenes share one steel")
    other.active_material.togishi.metal_choice = "gold_johnson_christy"
    need(
        original.active_material.togishi.metal == "iron_johnson_christy",
        "editing the copy changed the original",
    )
    gold = yield from life.picture()
    changed(before, gold, "gold in the copied scene")
    # So are its maps, as soon as they are baked again.
    other.active_material.togishi.pattern.hamon = "midare"
    with as_user():
        bpy.ops.material.togishi_pattern_bake()
    need(
        other.active_material.togishi.lobes_image != original.active_material.togishi.lobes_image,
        "baking the copy wrote into the original's map",
    )
    bpy.data.scenes.remove(scene)
    yield from life.shown()
    after = yield from life.picture()
    same(before, after, "the first scene")


@step("two viewports at once")
def two_viewports(life: Life) -> Steps:
    if not WINDOW:
        # Two renderers of one scene, drawn in turn, do not disturb each other.
        scene = bpy.context.scene
        depsgraph = bpy.context.evaluated_depsgraph_get()
        sync, renderer = part("engine.scene_sync").SceneSync, part("engine.renderer").Renderer
        pairs = [(sync(), renderer()), (sync(), renderer())]
        pictures = [
            maker.draw(reader.update(depsgraph), camera_of(scene), SIZE).read()
            for _ in range(2)
            for reader, maker in pairs
        ]
        for other in pictures[1:]:
            need(np.array_equal(pictures[0], other), "two renderers, two pictures")
        return
    before = yield from life.picture()
    with as_user():
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield 0.5
    views = screen.areas("VIEW_3D")
    need(len(views) == 2, "the area was not split")
    for area in views:  # Blender makes the copy of a rendered view a solid one
        area.spaces.active.shading.type = "RENDERED"
    views[1].spaces.active.region_3d.view_perspective = "PERSP"
    for number in range(10):
        lamp().location.x += 0.05 * (-1) ** number
        views = screen.areas("VIEW_3D")
        views[1].spaces.active.region_3d.view_rotation.rotate(_turn(0.1))
        yield from life.shown()
    result: list[np.ndarray] = []
    for index, area in enumerate(screen.areas("VIEW_3D")):
        yield from life.shots.region(screen.region_of(area), f"view {index}", result)
    need(all(int(picture.max()) > 25 for picture in result), "one of two viewports is black")
    with screen.override(screen.areas("VIEW_3D")[1]):
        bpy.ops.screen.area_close()
    yield 0.5
    need(len(screen.areas("VIEW_3D")) == 1, "the second viewport is still there")
    yield from life.shown()
    after = yield from life.picture()
    need(after.shape == before.shape, "the first viewport did not come back")


def _turn(angle_rad: float) -> Any:
    from mathutils import Quaternion

    return Quaternion((0.0, 0.0, 1.0), angle_rad)


@step("switch shading and engine back and forth", window=True)
def switch_shading(life: Life) -> Steps:
    before = yield from life.picture()
    scene = bpy.context.scene
    for _ in range(5):
        view_area().spaces.active.shading.type = "SOLID"
        yield from life.shown()
        scene.render.engine = "BLENDER_WORKBENCH"
        view_area().spaces.active.shading.type = "RENDERED"
        yield from life.shown()
        scene.render.engine = "TOGISHI"
        yield from life.shown()
    after = yield from life.picture()
    same(before, after, "switching shading")


REDRAWS = 200
# Growth over so many redraws: less than a picture of the view is none that matters.
MOST_GROWTH_MB_PER_100_REDRAWS = 4.0


@step("memory over 200 redraws")
def memory(life: Life) -> Steps:
    """Redraws as when a light is dragged while the view turns: uploads, pictures, samples."""
    scene = bpy.context.scene
    scene.togishi.viewport_samples = 1
    frames: Callable[[int], Steps]
    if WINDOW:

        def frames(count: int) -> Steps:
            for number in range(count):
                lamp().location.x += 0.01 * (-1) ** number
                view_area().spaces.active.region_3d.view_camera_zoom = float(number % 2)
                yield from life.draws.shown()

    else:
        sync, renderer = part("engine.scene_sync").SceneSync(), part("engine.renderer").Renderer()
        camera = camera_of(scene)

        def updated(_scene: Any, depsgraph: Any) -> None:
            renderer.draw(sync.update(depsgraph), camera, SIZE).read()

        def frames(count: int) -> Steps:
            bpy.app.handlers.depsgraph_update_post.append(updated)
            try:
                for number in range(count):
                    lamp().location.x += 0.01 * (-1) ** number
                    bpy.context.view_layer.update()
                    yield 0.0
            finally:
                bpy.app.handlers.depsgraph_update_post.remove(updated)

    yield from frames(60)  # caches fill
    before = resident_mb()
    yield from frames(REDRAWS)
    growth = (resident_mb() - before) * 100.0 / REDRAWS
    life.rss_growth_mb_per_100_redraws = round(growth, 3)
    life.note = f"{growth:.2f} MB per 100 redraws, at {before:.0f} MB"
    need(growth <= MOST_GROWTH_MB_PER_100_REDRAWS, f"memory grows: {life.note}")


def drawn_without_it(life: Life) -> Steps:
    """The rendered view, now that its engine is gone. Blender falls back to EEVEE, whose own shaders take a software GPU
    minutes; Workbench draws at once."""
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    if WINDOW:
        yield from life.draws.shown()
    yield 0.2


@step("disable and enable again")
def disable_and_enable(life: Life) -> Steps:
    """With a rendered view open, as it happens."""
    before = yield from life.picture()
    kept = part("properties").material_dict(steel())
    name = steel().name
    ours_s = 0.0
    for _ in range(2):
        started = time.monotonic()
        bpy.ops.preferences.addon_disable(module=EXTENSION)
        ours_s += time.monotonic() - started
        need(not hasattr(bpy.types.Material, "togishi"), "properties are left behind")
        left = [name for name in dir(bpy.types) if name.startswith("TOGISHI_")]
        need(not left, f"classes are left behind: {left}")
        yield from drawn_without_it(life)
        started = time.monotonic()
        bpy.ops.preferences.addon_enable(module=EXTENSION)
        ours_s += time.monotonic() - started
        bpy.context.scene.render.engine = "TOGISHI"
        yield from life.shown()
    need(
        part("properties").material_dict(bpy.data.materials[name]) == kept,
        "the settings were lost while the extension was disabled",
    )
    after = yield from life.picture()
    same(before, after, "disabling and enabling")
    life.note = f"disabling and enabling, twice: {ours_s:.2f} s"


@step("disable while a bake runs", window=True)
def disable_while_baking(life: Life) -> Steps:
    steel().togishi.pattern.width_px = 4096
    yield from begin_bake()
    yield 0.3
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    left = [thread.name for thread in threading.enumerate() if "togishi" in thread.name]
    need(not left, f"a thread goes on without the extension: {left}")
    yield from drawn_without_it(life)
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    bpy.context.scene.render.engine = "TOGISHI"
    yield from life.shown()


@step("uninstall")
def uninstall(life: Life) -> Steps:
    repositories = bpy.context.preferences.extensions.repos
    index = next(i for i, repo in enumerate(repositories) if repo.module == "user_default")
    folder = Path(repositories[index].directory) / "togishi"
    need(folder.is_dir(), f"{folder} is not where the extension lies")
    bpy.ops.extensions.package_uninstall(repo_index=index, pkg_id="togishi")
    yield 0.3
    need(not folder.exists(), f"{folder} is left behind")
    need(EXTENSION not in bpy.context.preferences.addons, "it is still enabled")
    yield from drawn_without_it(life)
    bpy.ops.wm.read_factory_settings(use_empty=not WINDOW)
    yield 0.5


# --- start --------------------------------------------------------------------------------------


def main() -> None:
    life = Life(Console(OPTIONS.console), OPTIONS.out)
    if not WINDOW:
        for _ in live(life):
            pass
        sys.exit(0 if life.passed else 1)

    def ended(error: BaseException | None) -> None:
        if error is not None:
            traceback.print_exception(error)
        sys.stdout.flush()
        if not life.passed or error is not None:
            os._exit(1)
        bpy.ops.wm.quit_blender()

    screen.run_in_window(live(life), ended)


main()
