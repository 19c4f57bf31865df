"""Photographs to maps in the add-on: plan, run, stop, landmarks, the camera, maps onto the blade, undo, refusals."""

from __future__ import annotations

import json
import time
import weakref
from types import SimpleNamespace

import bpy
import gpu
import mathutils
import numpy as np
import pytest
from blade_outline import against_the_light
from gpu_context import ensure_gpu_context
from ui_fixtures import add_katana, addon  # noqa: F401

pytestmark = pytest.mark.usefixtures("addon")

from togishi import blade_object, landmark_marks, map_files, photographs, properties  # noqa: E402
from togishi.core import landmarks, native  # noqa: E402
from togishi.core import photographs as files  # noqa: E402
from togishi.operators.landmarks import (  # noqa: E402
    PLACES,
    TOGISHI_OT_landmark_mark,
    TOGISHI_OT_landmark_pick,
    _Click,
)

WIDTH, HEIGHT, SCALE = 400, 40, 0.5  # px, px, px/mm
MIDDLE_MM = np.array([368.0, 0.0, -12.0])


def pixel_of(point_mm) -> tuple[float, float]:
    """An orthographic camera that faces omote: the tip is on the left."""
    x, _y, z = np.asarray(point_mm) - MIDDLE_MM
    return WIDTH / 2 - SCALE * x, HEIGHT / 2 - SCALE * z


def image_io():
    oiio = map_files.open_image_io()
    assert oiio is not None
    return oiio


CAMERA = f"""
[camera]
kind = "orthographic"
width_px = {WIDTH}
height_px = {HEIGHT}
"""
STATED = f"""scale_px_per_mm = {SCALE}
centre_px = [{WIDTH / 2}, {HEIGHT / 2}]
position_mm = {MIDDLE_MM.tolist()}
right = [-1.0, 0.0, 0.0]
down = [0.0, 0.0, -1.0]
"""
SETUP = """
[surface]
kind = "blade"
detail = 0.02

[[photograph]]
file = "left é.exr"
[photograph.source]
kind = "rectangle"
centre_mm = [368.0, 700.0, -120.0]
half_u_mm = [600.0, 0.0, 0.0]
half_v_mm = [0.0, 10.0, 60.0]

[[photograph]]
file = "right.exr"
[photograph.source]
kind = "rectangle"
centre_mm = [368.0, 700.0, 0.0]
half_u_mm = [600.0, 0.0, 0.0]
half_v_mm = [0.0, 0.0, 60.0]
"""
HEAD = "format = 1\nscale = 1.0\n[noise]\nsnr = 100.0\nread = 3e-4\nbits = 12\n"


def write_setup(folder, camera=STATED):
    for index, name in enumerate(("left é.exr", "right.exr")):
        picture = np.full((HEIGHT, WIDTH, 1), 0.1 + 0.1 * index, np.float32)
        files.write_planes(image_io(), folder / name, ["Y"], picture)
    path = folder / "setup.toml"
    path.write_text(HEAD + CAMERA + camera + SETUP, encoding="utf-8")
    return path


def write_stack(folder, count=16):
    """Flat steel of one wide lobe: the same picture value for lights that stand alike about the normal."""
    angle = 2.399963 * np.arange(count)
    zenith = np.radians(6.0 + 40.0 * np.sqrt((np.arange(count) + 0.5) / count))
    lines = [str(count)]
    for index in range(count):
        direction = (
            np.sin(zenith[index]) * np.cos(angle[index]),
            np.sin(zenith[index]) * np.sin(angle[index]),
            np.cos(zenith[index]),
        )
        signal = 0.8 * np.exp(-np.log(2.0) * (np.degrees(zenith[index]) / 2.0 / 8.0) ** 2)
        picture = np.full((HEIGHT, WIDTH, 1), signal, np.float32)
        files.write_planes(image_io(), folder / f"{index}.exr", ["Y"], picture)
        lines.append(f"{index}.exr " + " ".join(f"{v:.9f}" for v in direction))
    path = folder / "stack.lp"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def choose(path, **settings):
    assert bpy.ops.scene.togishi_photographs(filepath=str(path), **settings) == {"FINISHED"}
    return bpy.context.scene.togishi_photographs


def mark(names) -> None:
    """Adds landmarks by name and marks each where the camera sees it."""
    kept = bpy.context.scene.togishi_photographs
    for name in names:
        assert bpy.ops.scene.togishi_landmark_add(place=name) == {"FINISHED"}
        pixel = pixel_of(kept.landmarks[kept.active_landmark].point_mm)
        assert bpy.ops.image.togishi_landmark_mark(pixel=pixel) == {"FINISHED"}


FOUR = ("tip", "ha_machi", "mune_machi", "yokote_edge")


def test_places_are_the_cores():
    places = native.core().blade_landmarks(native.core().katana_defaults())
    assert [name for name, _label, _tip in PLACES] == list(places)


def test_diffuse_plan_run_apply_and_undo(tmp_path):
    bpy.context.preferences.edit.use_global_undo = True
    material = blade_object.blade_material(add_katana()).name
    kept = choose(write_setup(tmp_path))
    # What it can see is said before anything is evaluated.
    assert kept.plan and not kept.found
    assert kept.plan_image.size[0] == 1200
    assert tuple(kept.photograph.size) == (WIDTH, HEIGHT)
    assert json.loads(kept.camera_json)["scale"] == SCALE
    assert not bpy.ops.scene.togishi_photographs_apply.poll()
    assert bpy.ops.scene.togishi_photographs_run() == {"FINISHED"}
    assert "w is told on" in kept.found and "μ is told on" in kept.found
    for image in (kept.w_image, kept.mu_image):
        assert tuple(image.size) == (WIDTH, HEIGHT) and image.packed_file is not None
    maps = map_files.load(tmp_path / "setup-maps.exr")
    assert maps["w"].shape == (HEIGHT, WIDTH)
    usable = files.read_plane(image_io(), tmp_path / "setup-maps-quality.exr", "usable")
    mask = files.read_plane(image_io(), tmp_path / "setup-maps-quality.exr", "mask")
    assert ((usable > 0.5) <= ((mask.astype(int) & 1) == 0)).all()
    bpy.ops.ed.undo_push(message="before")
    usable[:] = (mask.astype(int) & 1) == 0
    files.write_planes(
        image_io(), tmp_path / "setup-maps-quality.exr", ["usable"], usable[..., None]
    )
    assert bpy.ops.scene.togishi_photographs_apply() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="applied")
    settings = bpy.data.materials[material].togishi
    assert tuple(settings.lobes_image.size) == photographs.MAP_SIZE
    bpy.ops.ed.undo()
    assert bpy.data.materials[material].togishi.lobes_image is None


def test_photographs_are_blended(tmp_path, monkeypatch):
    monkeypatch.setattr(photographs, "MAP_SIZE", (256, 32))
    material = blade_object.blade_material(add_katana()).togishi
    covered = []

    def project() -> tuple[float, float]:
        """The job's last report of progress, and how much of the blade is covered."""
        own = {"blade": native.core().katana_defaults(), "detail": 0.02, "size": (256, 32)}
        job = photographs.ProjectJob({**photographs.state_of(kept), **own})
        job.start()
        found = job.result()
        return job.share, 1 - found["holes"] / found["on_blade"]

    # One camera sees the half towards the tip, the other the half towards the machi.
    for name, shift in (("one", 0.0), ("two", 100.0)):
        folder = tmp_path / name
        folder.mkdir()
        camera = STATED.replace(f"[{WIDTH / 2},", f"[{WIDTH / 2 + shift},")
        kept = choose(write_setup(folder, camera))
        assert bpy.ops.scene.togishi_photographs_run() == {"FINISHED"}
        usable = np.ones((HEIGHT, WIDTH, 1), np.float32)
        files.write_planes(image_io(), folder / "setup-maps-quality.exr", ["usable"], usable)
        share, cover = project()
        assert share == 1.0
        covered.append(cover)
    assert [one.filepath for one in kept.earlier] == [str(tmp_path / "one" / "setup.toml")]
    assert bpy.ops.scene.togishi_photographs_apply() == {"FINISHED"}
    assert material.lobes_image is not None
    # Both cover more than the second alone.
    kept.earlier[0].use = False
    assert not photographs.state_of(kept)["earlier"]
    assert covered[1] > project()[1] + 0.05
    # Chosen again, it is the present one and no earlier one.
    choose(tmp_path / "one" / "setup.toml")
    assert [one.filepath for one in kept.earlier] == [str(tmp_path / "two" / "setup.toml")]


def test_a_stack_of_many_lights_runs(tmp_path):
    kept = choose(write_stack(tmp_path), light_error_deg=0.2)
    assert "half vectors" in kept.plan
    assert bpy.ops.scene.togishi_photographs_run() == {"FINISHED"}
    assert "flagged" in kept.found
    spec = image_io().ImageInput.open(str(tmp_path / "stack-lights.exr")).spec()
    assert set(spec.channelnames) == set(native.core().CAPTURE_CHANNELS)
    found = files.read_plane(image_io(), tmp_path / "stack-lights.exr", "lobe.ln_mu_deg")
    # The pictures' half width over the half vector is 8 degrees.
    assert np.exp(np.median(found)) == pytest.approx(8.0, rel=0.15)
    # Nothing of the run is left beside the maps.
    assert not list(tmp_path.glob(".*"))


def test_bands_are_written_one_by_one(tmp_path):
    image = np.random.default_rng(3).normal(size=(70, 33, 2)).astype(np.float32)
    alive = []

    def bands():
        for begin in range(0, 70, 16):
            assert len(alive) <= 1  # those before the last were let go
            band = image[begin : begin + 16].copy()
            weakref.finalize(band, alive.remove, begin)
            alive.append(begin)
            yield band
            del band

    path = tmp_path / "é bands.exr"
    files.write_bands(image_io(), path, ["A", "B"], (70, 33), bands())
    found = files.read_planes(image_io(), path)
    for index, name in enumerate("AB"):
        assert np.array_equal(found[name], image[..., index])

    def breaks():
        yield image[:16]
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        files.write_bands(image_io(), path, ["A", "B"], (70, 33), breaks())
    assert np.array_equal(files.read_plane(image_io(), path, "A"), image[..., 0])
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def test_stopping_keeps_the_scene(tmp_path):
    kept = choose(write_stack(tmp_path))
    job = photographs.RunJob(photographs.state_of(kept))
    job.cancel()
    job.start()
    with pytest.raises(InterruptedError):
        job.result()
    assert not photographs.is_running()
    assert not kept.found and not (tmp_path / "stack-lights.exr").exists()


def test_a_run_leaves_the_main_thread_free(tmp_path):
    kept = choose(write_stack(tmp_path))
    job = photographs.RunJob(photographs.state_of(kept))
    job.start()
    turns = 0
    while not job.done:
        turns += 1
        time.sleep(0.001)
    assert turns > 5
    assert job.result()["frame"] == "image"


def test_landmarks_give_the_camera(tmp_path):
    add_katana()
    kept = choose(write_stack(tmp_path))
    mark(FOUR)
    assert bpy.ops.scene.togishi_camera_solve() == {"FINISHED"}
    camera = json.loads(kept.camera_json)
    assert camera["scale"] == pytest.approx(SCALE, rel=1e-3)
    assert kept.rms_mm < 0.01
    assert all(0.0 <= one.residual_mm < 0.05 for one in kept.landmarks)
    # A mark that is 1 mm off is seen in its residual.
    kept.active_landmark = 0
    x, y = pixel_of(kept.landmarks[0].point_mm)
    bpy.ops.image.togishi_landmark_mark(pixel=(x, y + 1.0 * SCALE))
    assert not kept.camera_json and kept.rms_mm < 0.0
    bpy.ops.scene.togishi_landmark_add(place="yokote_ridge")
    bpy.ops.image.togishi_landmark_mark(pixel=pixel_of(kept.landmarks[4].point_mm))
    bpy.ops.scene.togishi_camera_solve()
    assert 0.05 < kept.rms_mm < 1.0
    # They are saved with the file.
    before = [(one.name, tuple(one.pixel), one.residual_mm) for one in kept.landmarks]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "marks.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "marks.blend"))
    kept = bpy.context.scene.togishi_photographs
    assert [(one.name, tuple(one.pixel), one.residual_mm) for one in kept.landmarks] == before
    bpy.ops.scene.togishi_landmark_remove()
    assert len(kept.landmarks) == 4 and not kept.camera_json


def test_a_set_up_takes_its_camera_from_landmarks(tmp_path):
    add_katana()
    kept = choose(write_setup(tmp_path, camera=""))
    assert "landmarks" in kept.plan and not kept.camera_json
    mark(FOUR)
    assert bpy.ops.scene.togishi_photographs_plan() == {"FINISHED"}
    assert json.loads(kept.camera_json)["scale"] == pytest.approx(SCALE, rel=1e-3)
    assert 0.0 <= kept.rms_mm < 0.01
    assert kept.landmarks[0].residual_mm >= 0.0


def write_outline(folder) -> None:
    """The blade against the light, from where the stated camera stands."""
    camera = native.core().parse_capture_setup(HEAD + CAMERA + STATED + SETUP).camera
    mesh = native.core().katana(native.core().katana_defaults(), 0.02)
    outline = against_the_light(camera, mesh)[..., None]
    files.write_planes(image_io(), folder / "outline.exr", ["Y"], outline)


# A millimetre and a half off, both ways.
OFF = STATED.replace(f"[{WIDTH / 2}, {HEIGHT / 2}]", f"[{WIDTH / 2 + 0.8}, {HEIGHT / 2 - 0.8}]")


def test_a_set_ups_camera_is_refined_on_the_outline(tmp_path, monkeypatch):
    monkeypatch.setattr(photographs, "MAP_SIZE", (256, 32))
    material = blade_object.blade_material(add_katana())
    write_outline(tmp_path)
    kept = choose(write_setup(tmp_path, 'silhouette = "outline.exr"\n' + OFF))
    assert "the outline in outline.exr" in kept.plan
    stated = json.loads(kept.camera_json)
    assert stated["centre_px"][0] == WIDTH / 2 + 0.8 and kept.outline_mm < 0.0
    assert bpy.ops.scene.togishi_photographs_run() == {"FINISHED"}
    assert 0.0 <= kept.outline_mm < 0.8
    refined = json.loads(kept.camera_json)
    assert refined != stated
    # A camera of before the refinement is refined where the maps are applied.
    kept.camera_json, kept.outline_mm = json.dumps(stated), -1.0
    usable = np.ones((HEIGHT, WIDTH, 1), np.float32)
    files.write_planes(image_io(), tmp_path / "setup-maps-quality.exr", ["usable"], usable)
    assert bpy.ops.scene.togishi_photographs_apply() == {"FINISHED"}
    assert json.loads(kept.camera_json) == refined and kept.outline_mm >= 0.0
    assert material.togishi.lobes_image is not None
    (tmp_path / "outline.exr").unlink()
    with pytest.raises(RuntimeError, match=r"The photographs tell nothing yet.*outline\.exr"):
        bpy.ops.scene.togishi_photographs_run()


def test_a_stacks_camera_is_refined_on_an_outline(tmp_path):
    blade = add_katana()
    blade.togishi.detail = 0.02
    write_outline(tmp_path)
    kept = choose(write_stack(tmp_path))
    assert not bpy.ops.scene.togishi_camera_outline.poll()
    off = native.core().parse_capture_setup(HEAD + CAMERA + OFF + SETUP).camera
    kept.camera_json = json.dumps(off)
    with pytest.raises(RuntimeError, match="plain ground"):  # a photograph without any
        bpy.ops.scene.togishi_camera_outline()
    assert json.loads(kept.camera_json)["centre_px"] == list(off["centre_px"])
    outline = str(tmp_path / "outline.exr")
    assert bpy.ops.scene.togishi_camera_outline(filepath=outline) == {"FINISHED"}
    assert 0.0 <= kept.outline_mm < 0.8
    assert json.loads(kept.camera_json) != json.loads(json.dumps(off))
    mark(FOUR[:1])  # another camera is to come
    assert kept.outline_mm < 0.0


def test_degenerate_landmarks_are_refused_with_the_cores_sentence(tmp_path):
    add_katana()
    choose(write_stack(tmp_path))
    mark(FOUR[:2])
    with pytest.raises(RuntimeError, match="The camera cannot be found: landmarks"):
        bpy.ops.scene.togishi_camera_solve()
    kept = bpy.context.scene.togishi_photographs
    for _ in range(2):
        bpy.ops.scene.togishi_landmark_remove()
    # Points of the edge that stand nearly on a line.
    for step in range(4):
        added = kept.landmarks.add()
        added.name, added.has_point, added.has_pixel = f"edge {step}", True, True
        added.point_mm = (100.0 * step, 0.0, 0.0)
        added.pixel = pixel_of(added.point_mm)
    with pytest.raises(RuntimeError, match="on a line"):
        bpy.ops.scene.togishi_camera_solve()
    assert not kept.camera_json


def test_a_pick_snaps_to_places_and_to_the_edge():
    blade = add_katana()
    kept = bpy.context.scene.togishi_photographs
    parameters = properties.katana_parameters(blade)
    tip = np.array(native.core().blade_landmarks(parameters)["tip"])
    assert bpy.ops.view3d.togishi_landmark_pick(point_mm=np.add(tip, [-1.0, 0.5, 1.0])) == {
        "FINISHED"
    }
    assert kept.landmarks[0].name == "tip"
    np.testing.assert_allclose(kept.landmarks[0].point_mm, tip, atol=1e-3)
    mesh = blade_object.make(parameters, blade.togishi.detail)
    edge = landmarks.edge_points(mesh.positions_mm, mesh.s_mm, mesh.t_mm)
    middle = edge[len(edge) // 2]
    # The cutting edge: below the mune all along, in the blade's middle plane.
    assert len(edge) > 10 and (np.abs(edge[:, 1]) < 1e-3).all() and (np.diff(edge[:, 0]) > 0).all()
    bpy.ops.view3d.togishi_landmark_pick(point_mm=np.add(middle, [0.5, 1.0, 1.0]))
    assert kept.landmarks[1].name.startswith("edge at ")
    np.testing.assert_allclose(kept.landmarks[1].point_mm, middle, atol=1e-3)
    inside = np.add(middle, [0.0, 2.0, 12.0])
    bpy.ops.view3d.togishi_landmark_pick(point_mm=inside)
    np.testing.assert_allclose(kept.landmarks[2].point_mm, inside, atol=1e-3)


class Click(_Click):
    """What the click operators share, with what it is asked."""

    def __init__(self, hit: bool) -> None:
        self.hit, self.asked, self.cursors = hit, [], []
        window = SimpleNamespace(
            cursor_modal_set=self.cursors.append,
            cursor_modal_restore=lambda: self.cursors.append(None),
        )
        regions = [
            SimpleNamespace(type="HEADER", x=0, y=0),
            SimpleNamespace(type="WINDOW", x=30, y=40),
        ]
        self.context = SimpleNamespace(
            window=window,
            area=SimpleNamespace(regions=regions),
            window_manager=SimpleNamespace(modal_handler_add=self.asked.append),
        )

    def where(self, _context, region, at) -> bool:
        self.asked.append((region.type, at))
        return self.hit

    def execute(self, _context) -> set[str]:
        self.asked.append("done")
        return {"FINISHED"}

    def event(self, kind: str, value: str = "PRESS") -> set[str]:
        at = SimpleNamespace(type=kind, value=value, mouse_x=130, mouse_y=90)
        return self.modal(self.context, at)


def test_a_click_is_waited_for():
    click = Click(hit=True)
    assert click.begin(click.context) == {"RUNNING_MODAL"}
    assert click.asked == [click] and click.cursors == ["CROSSHAIR"]
    for kind, value in (
        ("MOUSEMOVE", "NOTHING"),
        ("LEFTMOUSE", "RELEASE"),
        ("WHEELUPMOUSE", "PRESS"),
    ):
        assert click.event(kind, value) == {"PASS_THROUGH"}  # the view still turns
    assert click.event("LEFTMOUSE") == {"FINISHED"}
    assert click.asked[1:] == [("WINDOW", (100, 50)), "done"]
    assert click.cursors == ["CROSSHAIR", None]
    for kind in ("ESC", "RIGHTMOUSE"):
        click = Click(hit=True)
        assert click.event(kind) == {"CANCELLED"} and not click.asked and click.cursors == [None]
    click = Click(hit=False)
    assert click.event("LEFTMOUSE") == {"CANCELLED"} and click.asked == [("WINDOW", (100, 50))]


def test_a_click_in_the_photograph_is_a_pixel(tmp_path):
    add_katana()
    choose(write_stack(tmp_path))
    # The editor's view: 2 screen pixels a picture pixel, its lower left corner at (10, 20).
    view = SimpleNamespace(
        region_to_view=lambda x, y: ((x - 10) / (2 * WIDTH), (y - 20) / (2 * HEIGHT))
    )
    click = SimpleNamespace()
    at = (10 + 2 * 100, 20 + 2 * 30)
    assert TOGISHI_OT_landmark_mark.where(click, bpy.context, SimpleNamespace(view2d=view), at)
    assert click.pixel == pytest.approx((100, HEIGHT - 30))


def test_a_click_on_the_blade_is_its_place():
    blade = add_katana()
    # From half a metre before omote, 1 mm a pixel; the middle of the view on the blade.
    mesh = blade_object.make(properties.katana_parameters(blade), blade.togishi.detail)
    z_mm = mesh.positions_mm[np.abs(mesh.positions_mm[:, 0] - 368) < 5, 2].mean()
    looking = blade.matrix_world @ mathutils.Matrix(
        ((-1, 0, 0, 0.368), (0, 0, 1, 0.5), (0, 1, 0, z_mm / 1000), (0, 0, 0, 1))
    )
    view = looking.inverted()
    span = mathutils.Matrix.Diagonal((2.0, 2.0, -0.01, 1.0))
    region = SimpleNamespace(width=1000, height=1000)
    space = SimpleNamespace(
        region_3d=SimpleNamespace(
            view_matrix=view,
            perspective_matrix=span @ view,
            is_perspective=False,
            view_perspective="ORTHO",
        )
    )
    said = []
    click = SimpleNamespace(report=lambda _kind, text: said.append(text))
    context = SimpleNamespace(
        scene=bpy.context.scene,
        space_data=space,
        object=blade,
        active_object=blade,
        selected_objects=[blade],
        view_layer=bpy.context.view_layer,
        evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
    )
    assert TOGISHI_OT_landmark_pick.where(click, context, region, (500, 500)), said
    np.testing.assert_allclose(click.point_mm[::2], (368, z_mm), atol=0.5)
    assert 0.0 < click.point_mm[1] < 5.0  # omote's skin
    assert TOGISHI_OT_landmark_pick.where(click, context, region, (480, 505))
    # x runs to the left from here.
    np.testing.assert_allclose(click.point_mm[::2], (388, z_mm + 5), atol=0.5)
    assert not TOGISHI_OT_landmark_pick.where(click, context, region, (500, 900))
    assert said == ["No blade is there"]


def test_landmarks_are_drawn_where_they_are(tmp_path):
    ensure_gpu_context()
    blade = add_katana()
    kept = choose(write_stack(tmp_path))
    mark(FOUR)
    view = SimpleNamespace(
        view_to_region=lambda u, v, clip: (10 + 2 * WIDTH * u, 20 + 2 * HEIGHT * v)
    )
    found = landmark_marks.in_photograph(kept, view, kept.photograph)
    assert [one.name for one in found] == list(FOUR)
    assert [one.chosen for one in found] == [False, False, False, True]
    for one, landmark in zip(found, kept.landmarks, strict=True):
        x, y = landmark.pixel
        assert (one.x, one.y) == pytest.approx((10 + 2 * x, 20 + 2 * (HEIGHT - y)), abs=1e-3)
    assert not landmark_marks.in_photograph(kept, view, None)
    # From above, 1 m across 1000 pixels: the blade's x to the right.
    region = SimpleNamespace(width=1000, height=1000)
    rv3d = SimpleNamespace(perspective_matrix=mathutils.Matrix.Diagonal((2.0, 2.0, 0.01, 1.0)))
    on = landmark_marks.on_blade(kept, blade, 1.0, region, rv3d)
    for one, landmark in zip(on, kept.landmarks, strict=True):
        world = blade.matrix_world @ (mathutils.Vector(landmark.point_mm) / 1000.0)
        assert (one.x, one.y) == pytest.approx(
            (500 + 1000 * world.x, 500 + 1000 * world.y), abs=0.1
        )
    kept.landmarks[0].has_point = False
    assert len(landmark_marks.on_blade(kept, blade, 1.0, region, rv3d)) == 3
    # A cross of one colour, another for the chosen one.
    offscreen = gpu.types.GPUOffScreen(64, 48)
    with offscreen.bind():
        gpu.state.active_framebuffer_get().clear(color=(0.0, 0.0, 0.0, 1.0))
        with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_matrix(mathutils.Matrix.Identity(4))
            window = mathutils.Matrix.Diagonal((2 / 64, 2 / 48, 1.0, 1.0))
            window.translation = (-1.0, -1.0, 0.0)
            gpu.matrix.load_projection_matrix(window)
            landmark_marks.draw(
                [
                    landmark_marks.Mark(12.5, 12.5, "", False),
                    landmark_marks.Mark(50.5, 30.5, "", True),
                ]
            )
        pixels = gpu.state.active_framebuffer_get().read_color(0, 0, 64, 48, 4, 0, "FLOAT")
    offscreen.free()
    image = np.array(pixels.to_list())
    for x, y, colour in ((12, 12, landmark_marks.PLAIN), (50, 30, landmark_marks.CHOSEN)):
        expected = np.array(colour[:3]) * colour[3]
        for at in ((y, x - 4), (y, x + 4), (y - 4, x), (y + 4, x)):
            np.testing.assert_allclose(image[at][:3], expected, atol=0.05)
    assert not image[40, 10][:3].any() and not image[12, 12 + 12][:3].any()


def test_bad_input_changes_nothing(tmp_path):
    kept = bpy.context.scene.togishi_photographs
    path = write_stack(tmp_path)
    text = path.read_text()
    path.write_text(text.replace("16\n", "17\n", 1))
    with pytest.raises(RuntimeError, match=r"These photographs cannot be used.*stack\.lp"):
        choose(path)
    assert not kept.filepath and not bpy.ops.scene.togishi_photographs_run.poll()
    path.write_text(text)
    choose(path)
    whole = (tmp_path / "7.exr").read_bytes()
    (tmp_path / "7.exr").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(RuntimeError, match=r"The photographs tell nothing yet.*7\.exr"):
        bpy.ops.scene.togishi_photographs_run()
    small = np.zeros((4, 4, 1), np.float32)
    files.write_planes(image_io(), tmp_path / "7.exr", ["Y"], small)
    with pytest.raises(RuntimeError, match=r"7\.exr: 4 x 4 pixels"):
        bpy.ops.scene.togishi_photographs_run()
    assert not kept.found
    with pytest.raises(RuntimeError, match=r"no such file|missing|No such file"):
        choose(tmp_path / "none.toml")
