"""Photographs to maps: choose a set-up, see what it can tell, run, look, apply to the blade."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from .. import blade_object, data_blocks, map_files, map_images, photographs, properties
from ..core import native
from ..core import photographs as files
from ..core.map_channels import MapError
from .modal_job import ModalJob
from .poll import allowed, editable

NEEDS_SETUP = "No photographs yet; 'Photographs to Maps' chooses their set-up"
NEEDS_MAPS = "Nothing was found in photographs yet; 'Find Maps' does"
NEEDS_POSE = "The camera is not known; mark landmarks, then 'Solve Camera'"
NEEDS_GENERATED = "Needs a blade that was made by 'Add Katana'"


def at_rest() -> tuple[object, str]:
    return (
        native.problem() or not photographs.is_running(),
        "Photographs are being evaluated. Esc in the 3-D view cancels it",
    )


def can_read() -> tuple[tuple[object, str], ...]:
    """The conditions of everything that reads photographs."""
    return (
        (
            map_files.open_image_io() is not None,
            "This Blender has no OpenImageIO, which reads the photographs; the official builds have",
        ),
        at_rest(),
    )


def generated_blade(context: bpy.types.Context) -> bpy.types.Object | None:
    blade = blade_object.find_blade(context)
    return blade if blade is not None and blade.togishi.katana_json else None


class _Work(ModalJob):
    """An operator whose work is a job: at once without a window, else beside the user interface."""

    cancelled = "The photographs' evaluation was cancelled; finished parts are kept"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        kept = context.scene.togishi_photographs
        return allowed(cls, *can_read(), (kept.filepath, NEEDS_SETUP))

    def job(self, context: bpy.types.Context) -> photographs.PhotographJob:
        raise NotImplementedError

    def keep(self, context: bpy.types.Context, scene: bpy.types.Scene, result: Any) -> None:
        raise NotImplementedError

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        self._scene = context.scene.session_uid
        return self.begin(context, self.job(context))

    def execute(self, context: bpy.types.Context) -> set[str]:
        self._scene = context.scene.session_uid
        job = self.job(context)
        job.start()
        return self.take(context, job)

    def take(self, context: bpy.types.Context, job: photographs.PhotographJob) -> set[str]:
        scene = data_blocks.by_uid(bpy.data.scenes, self._scene)
        try:
            result = job.result()
        except InterruptedError:
            self.report({"INFO"}, self.cancelled)
            return {"CANCELLED"}
        except (native.core().InputError, MapError, OSError, UnicodeDecodeError) as error:
            self.report({"ERROR"}, f"The photographs tell nothing yet: {error}")
            return {"CANCELLED"}
        if scene is None:
            self.report({"WARNING"}, "The scene is gone; what was found was not kept")
            return {"CANCELLED"}
        self.keep(context, scene, result)
        return {"FINISHED"}


class TOGISHI_OT_photographs(bpy.types.Operator, ImportHelper):
    """Choose the set-up of photographs under diffuse light (.toml) or the light file of a stack (.lp), and see which
    polishes it can tell"""

    bl_idname = "scene.togishi_photographs"
    bl_label = "Photographs to Maps"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ""
    filter_glob: StringProperty(default="*.toml;*.lp", options={"HIDDEN"})
    hadori: BoolProperty(
        name="Hadori",
        description="Diffuse light: the blade has hadori, whose lobe of the material is a third one",
    )
    transfer: EnumProperty(
        name="Values",
        description="Light file: what the pictures' numbers are",
        items=(
            ("linear", "Linear", "In proportion to the light, as developed RAW files"),
            ("srgb", "sRGB", "As cameras write JPEG"),
        ),
    )
    model: EnumProperty(
        name="Surface",
        description="Light file: which form of the model the lobe has",
        items=(
            ("hamon", "Rough", "Fresnel at the half vector, as on the hamon"),
            ("ji", "Smooth", "Fresnel at the light's angle, as on the ji"),
        ),
    )
    light_error_deg: FloatProperty(
        name="Light error (°)",
        description="Light file: how well the lights' directions are known, in degrees (rms)",
        default=0.5,
        min=0.0,
        max=20.0,
    )
    self_calibrate: BoolProperty(
        name="Calibrate the lights",
        description="Light file: correct the lights' directions by what the pixels agree on",
    )
    snr: FloatProperty(
        name="Signal to noise",
        description="Light file: signal over noise at full scale",
        default=100.0,
        min=1.0,
        max=1e6,
    )
    bracket: StringProperty(
        name="Second exposure",
        description="Light file: name of another .lp file beside it, with the same lights and another exposure",
    )
    bracket_ratio: FloatProperty(
        name="Its light",
        description="Light of the second exposure over that of the first, e.g. 0.03125 for 5 stops less",
        default=0.03125,
        min=1e-6,
        max=1e6,
        precision=5,
    )

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return allowed(cls, *can_read())

    def _options(self, path: Path) -> dict[str, Any]:
        if not files.is_light_file(path):
            return {"hadori": self.hadori}
        names = ("transfer", "model", "light_error_deg", "self_calibrate", "snr")
        options = {name: getattr(self, name) for name in names}
        if self.bracket:
            options["brackets"] = [[str(path.parent / self.bracket), self.bracket_ratio]]
        return options

    def execute(self, context: bpy.types.Context) -> set[str]:
        path = Path(bpy.path.abspath(self.filepath))
        kept = context.scene.togishi_photographs
        options = self._options(path)
        try:
            if files.is_light_file(path):
                plan = native.core().capture_lights_plan(str(path), options)
                photograph = Path(plan["pictures"][0])
            else:
                photograph = files.first_photograph(path)
        except (native.core().InputError, OSError, ValueError) as error:
            self.report({"ERROR"}, f"These photographs cannot be used: {error}")
            return {"CANCELLED"}
        photographs.keep_earlier(kept, str(path))
        before = kept.photograph
        kept.filepath = str(path)
        kept.options_json = json.dumps(options)
        kept.plan = kept.found = kept.frame = kept.camera_json = ""
        photographs.keep_fit(kept, None)
        kept.photograph = None
        if photograph is not None and photograph.is_file():
            kept.photograph = bpy.data.images.load(str(photograph), check_existing=True)
        if kept.photograph != before:
            for landmark in kept.landmarks:  # marks belong to one photograph, places to the blade
                landmark.has_pixel = False
        bpy.ops.scene.togishi_photographs_plan(
            "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        )
        return {"FINISHED"}


class TOGISHI_OT_photographs_plan(_Work, bpy.types.Operator):
    """Work out what the set-up can see, with the landmarks as they are now"""

    bl_idname = "scene.togishi_photographs_plan"
    bl_label = "What It Can See"
    bl_options = {"REGISTER", "UNDO"}

    doing = "Togishi works out what the photographs can tell"

    def job(self, context: bpy.types.Context) -> photographs.PlanJob:
        return photographs.PlanJob(photographs.state_of(context.scene.togishi_photographs))

    def take(self, context: bpy.types.Context, job: photographs.PhotographJob) -> set[str]:
        # A set-up whose landmarks are still to be picked is chosen all the same; the panel says what it lacks.
        try:
            job.result()
        except native.core().InputError as error:
            scene = data_blocks.by_uid(bpy.data.scenes, self._scene)
            if scene is not None:
                scene.togishi_photographs.plan = str(error)
            self.report({"WARNING"}, f"The set-up cannot be planned yet: {error}")
            return {"FINISHED"}
        except (InterruptedError, OSError):
            pass  # said by the common way
        return super().take(context, job)

    def keep(self, _context: bpy.types.Context, scene: bpy.types.Scene, result: Any) -> None:
        kept = scene.togishi_photographs
        kept.plan = "\n".join(result["sentences"])
        photographs.keep_camera(kept, result["camera"], None)
        if result.get("fit") is not None:
            photographs.keep_fit(kept, result["fit"], result["offset"])
        if result["picture"] is not None:
            kept.plan_image = photographs.keep_picture(
                "Photographs, plan", kept.plan_image, result["picture"]
            )


class TOGISHI_OT_photographs_run(_Work, bpy.types.Operator):
    """Find the maps in the photographs. They are written beside the set-up; a stopped stack goes on where it was"""

    bl_idname = "scene.togishi_photographs_run"
    bl_label = "Find Maps"
    bl_options = {"REGISTER", "UNDO"}

    doing = "Togishi evaluates the photographs"

    def job(self, context: bpy.types.Context) -> photographs.RunJob:
        return photographs.RunJob(photographs.state_of(context.scene.togishi_photographs))

    def keep(self, _context: bpy.types.Context, scene: bpy.types.Scene, result: Any) -> None:
        kept = scene.togishi_photographs
        kept.found = "\n".join(result["sentences"])
        kept.frame = result["frame"]
        photographs.keep_camera(kept, result["camera"], result["outline"])
        for name, picture in result["pictures"].items():
            field = f"{name}_image"
            image = photographs.keep_picture(
                f"Photographs, {'w' if name == 'w' else 'μ'}", getattr(kept, field), picture
            )
            setattr(kept, field, image)
        for sentence in result["sentences"]:
            self.report({"INFO"}, sentence)


class TOGISHI_OT_photographs_apply(_Work, bpy.types.Operator):
    """Bring the maps onto this blade's own chart and give them to its material, blended with those of earlier set-ups.
    Holes hold the nearest value"""

    bl_idname = "scene.togishi_photographs_apply"
    bl_label = "Apply to Blade"
    bl_options = {"REGISTER", "UNDO"}

    doing = "Togishi brings the maps onto the blade"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        kept = context.scene.togishi_photographs
        return allowed(
            cls,
            *can_read(),
            (kept.found, NEEDS_MAPS),
            (kept.camera_json, NEEDS_POSE),
            (generated_blade(context), NEEDS_GENERATED),
            *editable(blade_object.blade_material(generated_blade(context))),
        )

    def job(self, context: bpy.types.Context) -> photographs.ProjectJob:
        blade = generated_blade(context)
        assert blade is not None
        material = blade_object.blade_material(blade)
        assert material is not None
        self._material = material.session_uid
        state = photographs.state_of(context.scene.togishi_photographs)
        return photographs.ProjectJob(
            {
                **state,
                "blade": properties.katana_parameters(blade),
                "detail": blade.togishi.detail,
                "size": photographs.MAP_SIZE,
            }
        )

    def keep(self, _context: bpy.types.Context, scene: bpy.types.Scene, result: Any) -> None:
        photographs.keep_camera(scene.togishi_photographs, result["camera"], result["outline"])
        material = data_blocks.by_uid(bpy.data.materials, self._material)
        if material is None:
            self.report({"WARNING"}, "The material is gone; the maps were not applied")
            return
        map_images.assign(material, result["maps"])
        covered = 1 - result["holes"] / max(result["on_blade"], 1)
        self.report({"INFO"}, f"The photographs cover {covered:.0%} of the blade")


class TOGISHI_OT_photographs_show(bpy.types.Operator):
    """Show a picture of the photographs' evaluation in an Image Editor"""

    bl_idname = "scene.togishi_photographs_show"
    bl_label = "Show Picture"
    bl_options = {"REGISTER"}

    picture: EnumProperty(
        name="Picture",
        items=(
            ("photograph", "Photograph", "The photograph that landmarks are marked in"),
            ("plan_image", "Plan", "What the set-up can see: radiance against half width"),
            ("w_image", "w", "Where it is hamon; masked pixels in their colours"),
            ("mu_image", "μ", "Half width of the lobe; masked pixels in their colours"),
        ),
        default="w_image",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(
            cls,
            (context.scene.togishi_photographs.filepath, NEEDS_SETUP),
            (not bpy.app.background, "Needs a window"),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        image = getattr(context.scene.togishi_photographs, self.picture)
        if image is None:
            self.report({"ERROR"}, "There is no such picture in this file yet")
            return {"CANCELLED"}
        open_editors = [a for a in context.screen.areas if a.type == "IMAGE_EDITOR"]
        if open_editors:
            open_editors[0].spaces.active.image = image
            return {"FINISHED"}
        data_blocks.show_in_new_window(context, image)
        return {"FINISHED"}


CLASSES = (
    TOGISHI_OT_photographs,
    TOGISHI_OT_photographs_plan,
    TOGISHI_OT_photographs_run,
    TOGISHI_OT_photographs_apply,
    TOGISHI_OT_photographs_show,
)
