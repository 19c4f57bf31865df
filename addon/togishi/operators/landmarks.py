"""Landmarks: picked on the blade in the 3-D view, marked in the photograph in the Image Editor, solved for the camera."""

from __future__ import annotations

import json

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from bpy_extras import view3d_utils

from .. import blade_object, map_files, photographs, properties
from ..core import native
from ..core import photographs as files
from ..core.landmarks import edge_points, snapped
from .photographs import (
    NEEDS_GENERATED,
    NEEDS_POSE,
    NEEDS_SETUP,
    at_rest,
    can_read,
    generated_blade,
)
from .poll import allowed

NEEDS_PHOTOGRAPH = "No photograph to mark places in; 'Photographs to Maps' chooses one"
NEEDS_LANDMARK = "No landmark is chosen; 'Add Landmark' or 'Pick on Blade' makes one"

# Named in cpp_core/capture/camera_pose.hpp; a test compares them.
PLACES = (
    ("tip", "Tip", "The very point"),
    ("ha_machi", "Ha-machi", "The notch of the edge"),
    ("mune_machi", "Mune-machi", "The notch of the back"),
    ("yokote_ridge", "Yokote at the mune", "Where the kissaki begins, on the back"),
    ("yokote_edge", "Yokote at the edge", "Where the kissaki begins, on the edge"),
    ("omote_machi_shinogi", "Shinogi at the machi, omote", "On omote's ridge"),
    ("ura_machi_shinogi", "Shinogi at the machi, ura", "On ura's ridge"),
    ("omote_yokote_shinogi", "Shinogi at the yokote, omote", "Ko-shinogi's foot on omote"),
    ("ura_yokote_shinogi", "Shinogi at the yokote, ura", "Ko-shinogi's foot on ura"),
    ("omote_machi_corner", "Mune's corner at the machi, omote", "Beside the mune"),
    ("ura_machi_corner", "Mune's corner at the machi, ura", "Beside the mune"),
    ("omote_yokote_corner", "Mune's corner at the yokote, omote", "Beside the mune"),
    ("ura_yokote_corner", "Mune's corner at the yokote, ura", "Beside the mune"),
)
LABELS = {name: label for name, label, _tip in PLACES}


def active(kept: photographs.TogishiPhotographs) -> photographs.TogishiLandmark | None:
    if 0 <= kept.active_landmark < len(kept.landmarks):
        return kept.landmarks[kept.active_landmark]
    return None


def forget_camera(kept: photographs.TogishiPhotographs) -> None:
    """A camera that was solved by other landmarks is none any more."""
    kept.camera_json = ""
    photographs.keep_fit(kept, None)


def add(kept: photographs.TogishiPhotographs, name: str, point_mm: object) -> None:
    """A landmark with a place; one of that name is moved."""
    found = kept.landmarks.find(name)
    if found < 0:
        kept.landmarks.add().name = name
        found = len(kept.landmarks) - 1
    kept.landmarks[found].point_mm = tuple(float(v) for v in np.asarray(point_mm))
    kept.landmarks[found].has_point = True
    kept.active_landmark = found
    forget_camera(kept)


class _Click:
    """An operator that waits for one click in its editor. It says in where() what the place under the mouse is."""

    def where(
        self, context: bpy.types.Context, region: bpy.types.Region, at: tuple[int, int]
    ) -> bool:
        """Sets the operator's properties from a place in the region; False where nothing is there, said."""
        raise NotImplementedError

    def begin(self, context: bpy.types.Context) -> set[str]:
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("CROSSHAIR")
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"}:
            context.window.cursor_modal_restore()
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        context.window.cursor_modal_restore()
        region = next((r for r in context.area.regions if r.type == "WINDOW"), None)
        if region is None:
            return {"CANCELLED"}
        if not self.where(context, region, (event.mouse_x - region.x, event.mouse_y - region.y)):
            return {"CANCELLED"}
        return self.execute(context)


class TOGISHI_OT_landmark_add(bpy.types.Operator):
    """Add a place that this blade has by name; then mark it in the photograph"""

    bl_idname = "scene.togishi_landmark_add"
    bl_label = "Add Landmark"
    bl_options = {"REGISTER", "UNDO"}

    place: EnumProperty(name="Place", description="Which place of the blade", items=PLACES)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, *can_read(), (generated_blade(context), NEEDS_GENERATED))

    def execute(self, context: bpy.types.Context) -> set[str]:
        blade = generated_blade(context)
        assert blade is not None
        places = native.core().blade_landmarks(properties.katana_parameters(blade))
        add(context.scene.togishi_photographs, self.place, places[self.place])
        return {"FINISHED"}


class TOGISHI_OT_landmark_pick(_Click, bpy.types.Operator):
    """Click a place on the blade: it snaps to named places and to the edge within 4 mm. Esc ends"""

    bl_idname = "view3d.togishi_landmark_pick"
    bl_label = "Pick on Blade"
    bl_options = {"REGISTER", "UNDO"}

    point_mm: FloatVectorProperty(
        name="Place (mm)", description="In the blade's frame, in mm", size=3
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, *can_read(), (generated_blade(context), NEEDS_GENERATED))

    def execute(self, context: bpy.types.Context) -> set[str]:
        blade = generated_blade(context)
        assert blade is not None
        parameters = properties.katana_parameters(blade)
        places = native.core().blade_landmarks(parameters)
        mesh = blade_object.make(parameters, blade.togishi.detail)
        edge = edge_points(mesh.positions_mm, mesh.s_mm, mesh.t_mm)
        name, point = snapped(np.array(self.point_mm, np.float64), places, edge)
        add(context.scene.togishi_photographs, name, point)
        self.report({"INFO"}, f"Landmark: {LABELS.get(name, name)}")
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if context.area is None or context.area.type != "VIEW_3D":
            self.report({"ERROR"}, "A place on the blade is picked in the 3-D view")
            return {"CANCELLED"}
        return self.begin(context)

    def where(
        self, context: bpy.types.Context, region: bpy.types.Region, at: tuple[int, int]
    ) -> bool:
        blade = generated_blade(context)
        if blade is None:
            return False
        view = context.space_data.region_3d
        to_blade = blade.matrix_world.inverted()
        origin = to_blade @ view3d_utils.region_2d_to_origin_3d(region, view, at)
        direction = to_blade.to_3x3() @ view3d_utils.region_2d_to_vector_3d(region, view, at)
        hit, point, _normal, _face = blade.ray_cast(origin, direction)
        if not hit:
            self.report({"WARNING"}, "No blade is there")
            return False
        unit_m = context.scene.unit_settings.scale_length or 1.0
        self.point_mm = tuple(v * unit_m / blade_object.MM for v in point)
        return True


class TOGISHI_OT_landmark_mark(_Click, bpy.types.Operator):
    """Click where the chosen landmark is in the photograph. Esc ends"""

    bl_idname = "image.togishi_landmark_mark"
    bl_label = "Mark in Photograph"
    bl_options = {"REGISTER", "UNDO"}

    pixel: FloatVectorProperty(
        name="Pixel", description="From the upper left corner, to the right and down", size=2
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        kept = context.scene.togishi_photographs
        return allowed(
            cls,
            at_rest(),
            (kept.photograph, NEEDS_PHOTOGRAPH),
            (active(kept), NEEDS_LANDMARK),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        kept = context.scene.togishi_photographs
        landmark = active(kept)
        assert landmark is not None
        width, height = kept.photograph.size
        if not (0 <= self.pixel[0] <= width and 0 <= self.pixel[1] <= height):
            self.report({"WARNING"}, "The photograph is not there")
            return {"CANCELLED"}
        landmark.pixel = self.pixel
        landmark.has_pixel = True
        forget_camera(kept)
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        kept = context.scene.togishi_photographs
        editor = context.space_data
        if editor is None or editor.type != "IMAGE_EDITOR" or editor.image != kept.photograph:
            self.report({"ERROR"}, "Places are marked in an Image Editor that shows the photograph")
            return {"CANCELLED"}
        return self.begin(context)

    def where(
        self, context: bpy.types.Context, region: bpy.types.Region, at: tuple[int, int]
    ) -> bool:
        u, v = region.view2d.region_to_view(*at)
        width, height = context.scene.togishi_photographs.photograph.size
        self.pixel = (u * width, (1.0 - v) * height)
        return True


class TOGISHI_OT_landmark_remove(bpy.types.Operator):
    """Remove the chosen landmark"""

    bl_idname = "scene.togishi_landmark_remove"
    bl_label = "Remove Landmark"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        kept = context.scene.togishi_photographs
        return allowed(cls, at_rest(), (active(kept), NEEDS_LANDMARK))

    def execute(self, context: bpy.types.Context) -> set[str]:
        kept = context.scene.togishi_photographs
        kept.landmarks.remove(kept.active_landmark)
        kept.active_landmark = min(kept.active_landmark, max(len(kept.landmarks) - 1, 0))
        forget_camera(kept)
        return {"FINISHED"}


class TOGISHI_OT_camera_solve(bpy.types.Operator):
    """Find the photograph's camera by the marked landmarks, and how far each lies off, in mm"""

    bl_idname = "scene.togishi_camera_solve"
    bl_label = "Solve Camera"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        kept = context.scene.togishi_photographs
        return allowed(
            cls,
            *can_read(),
            (kept.filepath, NEEDS_SETUP),
            (kept.photograph, NEEDS_PHOTOGRAPH),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        kept = context.scene.togishi_photographs
        width, height = kept.photograph.size
        facing = (0.0, 1.0 if kept.side == "omote" else -1.0, 0.0)
        forget_camera(kept)
        try:
            fit = native.core().camera_from_landmarks(
                photographs.marked(kept), width, height, kept.camera_kind, facing
            )
        except native.core().InputError as error:
            self.report({"ERROR"}, f"The camera cannot be found: {error}")
            return {"CANCELLED"}
        photographs.keep_camera(kept, fit["camera"], None)
        photographs.keep_fit(kept, fit)
        self.report(
            {"INFO"}, f"Camera found: the landmarks lie within {fit['rms_mm']:.2f} mm (rms)"
        )
        return {"FINISHED"}


class TOGISHI_OT_camera_outline(bpy.types.Operator):
    """Move the camera until the blade's outline lies on that in a photograph with a plain ground. A set-up that names
    such a picture needs no click"""

    bl_idname = "scene.togishi_camera_outline"
    bl_label = "Refine on Outline"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(
        name="Picture",
        description="The blade against a plain ground, from the same place; empty: the photograph itself",
        subtype="FILE_PATH",
    )
    search_mm: FloatProperty(
        name="Search (mm)",
        description="How far the outline may lie from where the camera puts it, in mm",
        default=4.0,
        min=0.1,
        max=100.0,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        kept = context.scene.togishi_photographs
        return allowed(
            cls,
            *can_read(),
            (kept.photograph, NEEDS_PHOTOGRAPH),
            (kept.camera_json, NEEDS_POSE),
            (generated_blade(context), NEEDS_GENERATED),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        kept = context.scene.togishi_photographs
        blade = generated_blade(context)
        assert blade is not None
        path = bpy.path.abspath(self.filepath or kept.photograph.filepath)
        try:
            picture, _whole = files.read_picture(map_files.open_image_io(), path)
            found = native.core().camera_on_outline(
                properties.katana_parameters(blade),
                json.loads(kept.camera_json),
                picture.mean(axis=-1),
                photographs.marked(kept) if kept.rms_mm >= 0.0 else [],
                search_mm=self.search_mm,
                detail=blade.togishi.detail,
            )
        except (native.core().InputError, OSError) as error:
            self.report({"ERROR"}, f"The camera cannot be found: {error}")
            return {"CANCELLED"}
        photographs.keep_camera(kept, found["camera"], found["outline"])
        self.report(
            {"INFO"}, f"Camera refined: the outline lies within {kept.outline_mm:.2f} mm (rms)"
        )
        return {"FINISHED"}


CLASSES = (
    TOGISHI_OT_landmark_add,
    TOGISHI_OT_landmark_pick,
    TOGISHI_OT_landmark_mark,
    TOGISHI_OT_landmark_remove,
    TOGISHI_OT_camera_solve,
    TOGISHI_OT_camera_outline,
)
