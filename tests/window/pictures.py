"""Pictures of all that Togishi shows in a window, for people to look at: panels as they first appear and opened,
the redo panel, dialogs, the menu entry, a bake and a fit under way, a fit and its plot, tooltips, the preferences.

    blender --factory-startup --enable-event-simulate --python pictures.py -- --zip Z --out DIR --console FILE
The window should be tall, so that long panels fit.
"""

from __future__ import annotations

import importlib
import os
import shutil
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import numpy as np
import screen
from console import Console, options
from screen import Steps
from stack import SHAPE, write_stack

EXTENSION = "bl_ext.user_default.togishi"
OPTIONS = options()
PARENTS: dict[type, str] = {}  # of panels, as they are in the source


def open_panels(tag: str, only: str = "") -> None:
    """As if each, or the one alone whose class is named, had been clicked open. Blender keeps a panel's state by its
    name, so they get others, which end in `tag`."""
    ui = importlib.import_module(f"{EXTENSION}.ui")
    ui.unregister()
    for module in ui._MODULES:
        for cls in module.CLASSES:
            if not issubclass(cls, bpy.types.Panel):
                continue
            closed = {"DEFAULT_CLOSED"} if only not in ("", cls.__name__) else set()
            cls.bl_options = set(getattr(cls, "bl_options", set())) - {"DEFAULT_CLOSED"} | closed
            cls.bl_idname = f"{cls.__name__}_{tag}"
            if hasattr(cls, "bl_parent_id"):
                cls.bl_parent_id = f"{PARENTS.setdefault(cls, cls.bl_parent_id)}_{tag}"
    ui.register()


def view() -> bpy.types.Area:
    return screen.areas("VIEW_3D")[0]


def settle(seconds: float = 0.7) -> Steps:
    for area in screen.window().screen.areas:
        area.tag_redraw()
    yield seconds


def properties_tab(shots: screen.Shots, tab: str, name: str) -> Steps:
    area = screen.areas("PROPERTIES")[0]
    try:
        area.spaces.active.context = tab
    except TypeError:
        print(f"no tab {tab} here")
        return
    # Panels slide to their places, a step a redraw.
    for _ in range(4):
        yield from settle(0.4)
    yield from shots.area(area, name)


def hover(
    shots: screen.Shots, name: str, region: bpy.types.Region, from_top: tuple[int, ...]
) -> Steps:
    """The tooltip in the middle of a region, so many px below its upper border: the first of these places that has
    one. One must come up."""
    window = screen.window()
    size = (window.width, window.height)
    for offset in from_top:
        at = (region.x + region.width // 2, region.y + region.height - offset)
        result: list[np.ndarray] = []
        window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=at[0] - 9, y=at[1])
        yield 0.2
        yield from shots.take(f"{name}_before", (0, 0), size, result)
        window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=at[0], y=at[1])
        yield 2.0
        yield from shots.take(name, (0, 0), size, result, keep=True)
        # The button under the mouse, which lights up, is smaller.
        changed = np.abs(result[1].astype(int) - result[0]).max(axis=2) > 8
        if int(changed.sum()) > 4000:
            return
    raise AssertionError(f"{name}: no tooltip {from_top} px below the region's border")


def baking(shots: screen.Shots) -> Steps:
    """A bake under way: its share in the status bar, the button greyed, and why."""
    pattern = bpy.context.active_object.active_material.togishi.pattern
    kept = (pattern.width_px, pattern.height_px)
    pattern.width_px, pattern.height_px = 16384, 4096
    with screen.override(view()):
        bpy.ops.material.togishi_pattern_bake("INVOKE_DEFAULT")
    jobs = importlib.import_module(f"{EXTENSION}.background_job")
    yield from screen.until(
        lambda: any(job.share > 0.02 for job in jobs.running()), 60.0, "the bake's share"
    )
    yield from hover(shots, "baking", screen.region_of(view(), "UI"), BAKE_BUTTON_PX)
    yield from screen.press("ESC", screen.centre(view()))
    yield from screen.until(lambda: not jobs._running, 60.0, "the end of the bake")
    pattern.width_px, pattern.height_px = kept
    yield from settle(0.5)


def measurement(shots: screen.Shots) -> Steps:
    """Scans are chosen and fitted; the panel with the fits, and a plot."""
    core = importlib.import_module(f"{EXTENSION}.core.native").core()
    files = []
    for part in ("ji", "hamon"):
        scans = core.simulate_scan(core.default_material(), part, {"step_deg": 0.1})
        files.append(OPTIONS.out / f"scan_{part}.csv")
        files[-1].write_text(scans.to_text(), encoding="utf-8")
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    with screen.override(view()):
        bpy.ops.scene.togishi_measurement_fit("INVOKE_DEFAULT", filepath=f"{OPTIONS.out}/")
    yield from screen.until(lambda: bool(screen.areas("FILE_BROWSER")), 30.0, "the file browser")
    yield from settle(2.0)
    yield from shots.everything("fit_files")
    browser = screen.areas("FILE_BROWSER")[0]
    yield from screen.press("ESC", screen.centre(browser))
    yield from settle(1.0)
    with screen.override(view()):
        bpy.ops.scene.togishi_measurement_fit(
            filepath=str(files[0]),
            directory=str(OPTIONS.out),
            files=[{"name": file.name} for file in files],
        )
    kept = bpy.context.scene.togishi_measurement
    yield from screen.until(lambda: len(kept.fits) == len(files), 120.0, "the fits")
    open_panels("fit", only="TOGISHI_PT_view_measurement")
    for _ in range(4):
        yield from settle(0.4)
    yield from shots.region(screen.region_of(view(), "UI"), "sidebar_fit", [], keep=True)
    open_panels("again")
    for plot in ("scans", "mu_eff"):
        with screen.override(view()):
            bpy.ops.scene.togishi_measurement_show(index=0, plot=plot)
        yield from settle(1.5)
        yield from shots.everything(f"fit_plot_{plot}")
        for other in list(bpy.context.window_manager.windows)[1:]:
            with bpy.context.temp_override(window=other):
                bpy.ops.wm.window_close()
        yield from settle(0.5)
    for file in files:
        file.unlink()


def landmarks(kept: bpy.types.PropertyGroup) -> None:
    """Five of them, on the blade and in the photograph, as a far camera that faces omote shows it: the tip on the left."""
    for place in ("tip", "ha_machi", "mune_machi", "yokote_ridge", "omote_machi_shinogi"):
        bpy.ops.scene.togishi_landmark_add(place=place)
    points = np.array([tuple(one.point_mm) for one in kept.landmarks])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    for index, (x, _y, z) in enumerate(points - middle):
        kept.active_landmark = index
        at = (SHAPE[1] / 2 - 0.5 * x, SHAPE[0] / 2 - 0.5 * z)
        bpy.ops.image.togishi_landmark_mark(pixel=at)
    bpy.ops.scene.togishi_camera_solve()


def photographs(shots: screen.Shots) -> Steps:
    """A stack is chosen and fitted and its landmarks marked; the panel beside the blade and beside a map."""
    image_io = importlib.import_module(f"{EXTENSION}.map_files").open_image_io()
    written = importlib.import_module(f"{EXTENSION}.core.photographs")
    stack = write_stack(OPTIONS.out / ".photographs", image_io, written)
    kept = bpy.context.scene.togishi_photographs
    open_panels("photographs", only="TOGISHI_PT_view_photographs")
    yield from settle(0.5)
    yield from shots.region(screen.region_of(view(), "UI"), "sidebar_photographs_first", [], True)
    with screen.override(view()):
        bpy.ops.scene.togishi_photographs(filepath=str(stack))
    yield from screen.until(lambda: bool(kept.plan), 60.0, "what the stack can see")
    with screen.override(view()):
        bpy.ops.scene.togishi_photographs_run("INVOKE_DEFAULT")
    yield from screen.until(lambda: bool(kept.found), 120.0, "the stack's maps")
    with screen.override(view()):
        landmarks(kept)
    for _ in range(4):
        yield from settle(0.4)
    yield from shots.region(screen.region_of(view(), "UI"), "sidebar_photographs", [], True)
    open_panels("again")
    area = view()
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = kept.mu_image
    area.spaces.active.show_region_ui = True
    yield from settle(1.0)
    screen.region_of(area, "UI").active_panel_category = "Togishi"
    with screen.override(area):
        bpy.ops.image.view_all(fit_view=True)
    yield from settle(1.0)
    yield from shots.area(area, "photographs_map")
    area.type = "VIEW_3D"
    yield from settle(0.7)
    shutil.rmtree(stack.parent)


def expanded(area: bpy.types.Area) -> Steps:
    """The extension's entry, opened. While a preview is rendered in another thread Blender refuses operators."""
    for last in (False,) * 20 + (True,):
        try:
            with screen.override(area):
                bpy.ops.preferences.addon_expand(module=EXTENSION)
            return
        except RuntimeError as error:
            if last or "drawing/rendering" not in str(error):
                raise
        yield 0.3


# Below the upper border of their regions, with all panels open; nothing below them has a tooltip of its own.
BAKE_BUTTON_PX, LOBE_PX = (466, 442, 418), (412, 386)


def tooltips(shots: screen.Shots) -> Steps:
    area = screen.areas("PROPERTIES")[0]
    area.spaces.active.context = "MATERIAL"
    yield from settle()
    yield from hover(shots, "tooltip", screen.region_of(area), LOBE_PX)


def pictures() -> Steps:
    bpy.ops.extensions.package_install_files(
        filepath=str(OPTIONS.zip), repo="user_default", enable_on_install=True
    )
    shots = screen.Shots(OPTIONS.out)
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    yield 0.3
    area = view()
    with screen.override(area):
        bpy.ops.wm.call_menu("INVOKE_DEFAULT", name="VIEW3D_MT_mesh_add")
    yield from settle(0.5)
    yield from shots.everything("add_menu")
    yield from screen.press("ESC", screen.centre(area))

    space = view().spaces.active
    space.show_region_ui = True
    yield from settle(0.6)
    screen.region_of(view(), "UI").active_panel_category = "Togishi"
    yield from settle()
    yield from shots.everything("empty_scene")

    with screen.override(view()):
        bpy.ops.mesh.togishi_katana_add("INVOKE_DEFAULT", True)
    yield from settle(0.8)
    yield from shots.everything("added_katana")
    hud = screen.region_of(view(), "HUD")
    print("HUD region", hud.x, hud.y, hud.width, hud.height)
    if hud.height > 1:
        yield from screen.press("LEFTMOUSE", (hud.x + 40, hud.y + hud.height - 12))
        yield from settle(0.8)
        yield from shots.everything("redo_panel")
        yield from screen.press("LEFTMOUSE", (hud.x + 40, hud.y + hud.height - 12))

    scene = bpy.context.scene
    scene.render.engine = "TOGISHI"
    blade = bpy.context.active_object
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.4, 1.5, 0.0), (1.5708, 0.0, 3.14159)
    camera.data.display_size = 0.05
    scene.collection.objects.link(camera)
    scene.camera = camera
    with screen.override(view()):
        bpy.ops.object.togishi_light_preset(preset="MUSEUM_SPOT")
    bpy.context.view_layer.objects.active = blade
    blade.select_set(True)
    view().spaces.active.shading.type = "RENDERED"
    with screen.override(view()):
        bpy.ops.view3d.view_axis(type="BACK")
        bpy.ops.view3d.view_selected()
    yield from settle(3.0)
    yield from shots.everything("viewport")

    view().spaces.active.shading.type = "SOLID"  # quicker
    with screen.override(screen.areas("OUTLINER")[0]):
        bpy.ops.screen.area_close()
    yield from settle()

    # The tab beside the view: as it first appears, and with everything open.
    yield from shots.region(screen.region_of(view(), "UI"), "sidebar_first", [], keep=True)
    for tab in ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "DATA", "MATERIAL"):
        yield from properties_tab(shots, tab, f"first_{tab.lower()}")
    for tab in ("PARTICLES", "PHYSICS", "CONSTRAINT", "MODIFIER"):
        yield from properties_tab(shots, tab, f"first_{tab.lower()}")

    # Properties as tall as the window, all our panels open.
    open_panels("open")
    yield from settle(0.5)
    yield from shots.region(screen.region_of(view(), "UI"), "sidebar_open", [], keep=True)
    for tab in ("RENDER", "VIEW_LAYER", "WORLD", "MATERIAL"):
        yield from properties_tab(shots, tab, f"open_{tab.lower()}")
    with screen.override(view()):
        bpy.ops.material.togishi_nodes_connect(spectrum="A")
    blade.active_material.togishi.weights = "measured"
    blade.active_material.togishi.metal_choice = "file"
    yield from properties_tab(shots, "MATERIAL", "open_material_measured")
    blade.active_material.togishi.weights = "normalised"
    blade.active_material.togishi.metal_choice = "iron_johnson_christy"

    light = next(obj for obj in scene.objects if obj.type == "LIGHT")
    bpy.context.view_layer.objects.active = light
    for choice in ("D65", "blackbody", "line", "csv"):
        light.data.togishi.choice = choice
        yield from properties_tab(shots, "DATA", f"light_{choice.lower()}")
    yield from shots.region(screen.region_of(view(), "UI"), "sidebar_light", [], keep=True)
    light.data.togishi.choice = "automatic"
    for kind in ("POINT", "SUN", "AREA"):
        light.data.type = kind
        yield from properties_tab(shots, "DATA", f"light_{kind.lower()}")
    light.data.type = "SPOT"
    bpy.context.view_layer.objects.active = camera
    yield from properties_tab(shots, "DATA", "camera")
    bpy.context.view_layer.objects.active = blade

    yield from baking(shots)
    screen.window().event_simulate(
        type="MOUSEMOVE", value="NOTHING", x=screen.window().width // 2, y=700
    )
    yield 0.2
    with screen.override(view()):
        bpy.ops.object.togishi_katana_edit("INVOKE_DEFAULT")
    yield from settle(0.8)
    yield from shots.everything("edit_dialog")
    yield from screen.press("ESC", screen.centre(view()))
    yield from measurement(shots)
    yield from photographs(shots)
    yield from tooltips(shots)

    # Preferences, in the place of the view.
    area = view()
    area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Togishi"
    yield from settle()
    yield from expanded(area)
    yield from settle(0.8)
    yield from shots.area(area, "preferences")
    area.type = "VIEW_3D"
    yield from settle(1.0)


def main() -> None:
    console = Console(OPTIONS.console)

    def ended(error: BaseException | None) -> None:
        if error is not None:
            traceback.print_exception(error)
        found = console.new_problems()
        if error is not None or found:
            print("\n".join(found))
            sys.stdout.flush()
            os._exit(1)
        bpy.ops.wm.quit_blender()

    screen.run_in_window(pictures(), ended)


main()
