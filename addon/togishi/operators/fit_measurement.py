"""Fit a goniometer's scans, look at the fit, and put it into a part of a blade material."""

from __future__ import annotations

import json
from pathlib import Path

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from .. import blade_object, data_blocks, measurement, properties
from ..core import fit_apply, fit_table, native
from .modal_job import ModalJob
from .poll import allowed, editable

NEEDS_FIT = "Nothing has been fitted in this scene yet; 'Fit Measurement' does"


PART_ITEMS = tuple(
    (name, label, f"The fitted lobe of the {model} becomes this part's")
    for model, (names, _constant) in fit_table.TARGETS.items()
    for name, label, _ in properties.LOBE_PARTS
    if name in names
)
FIT_INDEX = IntProperty(
    name="Fit", description="Which of the measurement's fits, ji first", default=0, min=0
)


def chosen_fit(
    operator: bpy.types.Operator, context: bpy.types.Context
) -> measurement.TogishiFit | None:
    """The fit that the operator's index means; None is reported."""
    fits = context.scene.togishi_measurement.fits
    if operator.index < len(fits):
        return fits[operator.index]
    operator.report({"ERROR"}, f"Fit {operator.index}: the measurement has {len(fits)}")
    return None


class TOGISHI_OT_measurement_fit(bpy.types.Operator, ImportHelper):
    """Find the material's constants in scans of a goniometer, with their uncertainty. Esc cancels"""

    bl_idname = "scene.togishi_measurement_fit"
    bl_label = "Fit Measurement"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".csv"
    filter_glob: StringProperty(default="*.csv;*.tsv;*.txt", options={"HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN"})
    metal: EnumProperty(
        name="Metal",
        description="Whose refractive index the fit uses",
        items=(
            (
                "file",
                "As the file says",
                "The metal that the file names; by evidence where it does not",
            ),
            ("auto", "By evidence", "The built-in metal that fits best; the others are listed"),
        ),
        default="file",
    )
    haze: EnumProperty(
        name="Second lobe",
        description="A wider, lower lobe around the first",
        items=(
            ("auto", "Where the data ask for it", "Decided by an information criterion (BIC)"),
            ("off", "Never", "One lobe"),
            ("on", "Always", "Two lobes"),
        ),
        default="auto",
    )

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return allowed(
            cls,
            (
                native.problem() or not measurement.is_running(),
                "A measurement is being fitted. Esc in the 3-D view cancels it",
            ),
        )

    def _paths(self) -> list[str]:
        named = [str(Path(self.directory) / file.name) for file in self.files if file.name]
        return [bpy.path.abspath(path) for path in named or [self.filepath]]

    def execute(self, context: bpy.types.Context) -> set[str]:
        options = {"haze": self.haze, **({} if self.metal == "file" else {"metal": self.metal})}
        paths = self._paths()
        if not bpy.app.background:
            # The file browser, which calls this, ends with it; what runs on is an operator of its own.
            return bpy.ops.scene.togishi_measurement_run(
                "INVOKE_DEFAULT", paths_json=json.dumps(paths), options_json=json.dumps(options)
            ) & {"CANCELLED"} or {"FINISHED"}
        job = measurement.FitJob(paths, options)
        job.start()
        return finish(self, context.scene, paths, job)


def finish(
    operator: bpy.types.Operator,
    scene: bpy.types.Scene,
    paths: list[str],
    job: measurement.FitJob,
) -> set[str]:
    """Take a job's result into the scene, and say what came of it."""
    try:
        result = job.result()
    except InterruptedError:
        operator.report({"INFO"}, "The fit was cancelled; nothing was changed")
        return {"CANCELLED"}
    except (native.core().InputError, OSError) as error:
        operator.report({"ERROR"}, f"Nothing was fitted: {error}")
        return {"CANCELLED"}
    measurement.keep(scene, paths, result)
    for fit, _pictures in result:
        record = fit.record
        for sentence in fit_table.undetermined(record):
            operator.report({"WARNING"}, f"{record['model']}: {sentence}")
        operator.report(
            {"INFO"},
            f"{record['model']}: {record['readings']} readings fitted in {fit.seconds:.2f} s, "
            f"reduced χ² {record['chi2_reduced']:.2f}",
        )
    return {"FINISHED"}


class TOGISHI_OT_measurement_run(ModalJob, bpy.types.Operator):
    """Fit scans beside the user interface"""

    bl_idname = "scene.togishi_measurement_run"
    bl_label = "Fit Measurement"
    bl_options = {"INTERNAL", "UNDO"}

    paths_json: StringProperty(options={"HIDDEN", "SKIP_SAVE"})
    options_json: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    doing = "Togishi fits the measurement"
    cancelled = "The fit was cancelled; nothing was changed"

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self._scene = context.scene.session_uid
        job = measurement.FitJob(json.loads(self.paths_json), json.loads(self.options_json))
        return self.begin(context, job)

    def take(self, _context: bpy.types.Context, job: measurement.FitJob) -> set[str]:
        scene = data_blocks.by_uid(bpy.data.scenes, self._scene)
        if scene is None:
            self.report({"WARNING"}, "The scene is gone; the fit was not kept")
            return {"CANCELLED"}
        return finish(self, scene, json.loads(self.paths_json), job)


class TOGISHI_OT_measurement_apply(bpy.types.Operator):
    """Put the fitted lobe into a part of the blade's material"""

    bl_idname = "scene.togishi_measurement_apply"
    bl_label = "Apply to Part"
    bl_options = {"REGISTER", "UNDO"}

    index: FIT_INDEX
    part: EnumProperty(
        name="Part",
        description="Part of the material that gets the fitted lobe",
        items=PART_ITEMS,
        default="ji",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(
            cls,
            (len(context.scene.togishi_measurement.fits), NEEDS_FIT),
            *editable(blade_object.edited_material(context)),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        material = blade_object.edited_material(context)
        assert material is not None
        fit = chosen_fit(self, context)
        if fit is None:
            return {"CANCELLED"}
        record = json.loads(fit.record_json)
        files = ", ".join(Path(entry["file"]).name for entry in record["input"])
        try:
            values = fit_apply.with_fit(
                properties.material_dict(material, with_fits=True),
                record,
                self.part,
                files or "scans",
            )
        except ValueError as error:
            self.report({"ERROR"}, f"The material was left as it is: {error}")
            return {"CANCELLED"}
        properties.set_material_dict(material, values)
        for sentence in fit_table.undetermined(record):
            self.report({"WARNING"}, sentence)
        if material.togishi.lobes_image is not None:
            self.report({"INFO"}, "Bake the pattern: the maps decide where there are maps")
        return {"FINISHED"}


class TOGISHI_OT_measurement_show(bpy.types.Operator):
    """Show a plot of the fit in a window of its own"""

    bl_idname = "scene.togishi_measurement_show"
    bl_label = "Show Plot"
    bl_options = {"REGISTER"}

    index: FIT_INDEX
    plot: EnumProperty(
        name="Plot",
        items=(
            ("scans", "Scans", "Intensity against receive angle, with residuals"),
            ("mu_eff", "Half Width", "Half width against the turn of the sample"),
        ),
        default="scans",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(
            cls,
            (len(context.scene.togishi_measurement.fits), NEEDS_FIT),
            (not bpy.app.background, "Needs a window"),
        )

    def execute(self, context: bpy.types.Context) -> set[str]:
        fit = chosen_fit(self, context)
        if fit is None:
            return {"CANCELLED"}
        image = getattr(fit, f"{self.plot}_image")
        if image is None:
            self.report({"ERROR"}, "The plot was removed from this file; fit again")
            return {"CANCELLED"}
        data_blocks.show_in_new_window(context, image)
        return {"FINISHED"}


CLASSES = (
    TOGISHI_OT_measurement_fit,
    TOGISHI_OT_measurement_run,
    TOGISHI_OT_measurement_apply,
    TOGISHI_OT_measurement_show,
)
