"""A goniometer's scans and their fit in a scene: the result is kept in the .blend, with its plots.

The fit itself needs no Blender data, so that it can run beside the user interface."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import CollectionProperty, PointerProperty, StringProperty
from numpy.typing import NDArray

from . import data_blocks
from .background_job import BackgroundJob, running


class FitJob(BackgroundJob):
    """Reading and fitting. Its result: the fits with their pictures, ji first."""

    thread_name = "togishi-fit"

    def __init__(self, paths: Sequence[str], options: Mapping[str, Any]) -> None:
        super().__init__()
        self._paths, self._options = list(paths), dict(options)

    def _compute(self) -> list[tuple[Any, dict[str, NDArray[np.uint8]]]]:
        sets = self._core.read_scans(self._paths)
        fits = []
        for index, scans in enumerate(sets):

            def progress(share: float, done: int = index) -> bool:
                return self._progress((done + share) / len(sets))

            fit = self._core.fit_scans(scans, self._options, progress=progress)
            fits.append((fit, self._core.fit_pictures(fit)))
        return fits


def is_running() -> bool:
    return any(isinstance(job, FitJob) for job in running())


# --- what is kept -------------------------------------------------------------------------------


class TogishiFit(bpy.types.PropertyGroup):
    """The fit of one part."""

    record_json: StringProperty(
        name="Record",
        description="What was found, and how sure it is (docs/measurement.md), as JSON",
        options={"HIDDEN"},
    )
    scans_image: PointerProperty(
        type=bpy.types.Image, name="Scans", description="Measured and modelled intensity"
    )
    mu_eff_image: PointerProperty(
        type=bpy.types.Image,
        name="Half width",
        description="Half width against the turn of the sample",
    )


class TogishiMeasurement(bpy.types.PropertyGroup):
    """The last measurement that was fitted in this scene."""

    title: StringProperty(name="Measurement", description="Names of the files")
    fits: CollectionProperty(type=TogishiFit)


def _others_have(image: bpy.types.Image, scene: bpy.types.Scene) -> bool:
    """Whether another scene's measurement has the plot too, as after copying a scene."""
    return any(
        image in (fit.scans_image, fit.mu_eff_image)
        for other in bpy.data.scenes
        if other != scene
        for fit in other.togishi_measurement.fits
    )


def _write(
    name: str,
    existing: bpy.types.Image | None,
    pixels: NDArray[np.uint8],
    scene: bpy.types.Scene,
) -> bpy.types.Image:
    image = existing
    if image is not None and (image.library or _others_have(image, scene)):
        image = None
    return data_blocks.write_picture(name, image, pixels)


def keep(
    scene: bpy.types.Scene,
    paths: Sequence[str],
    result: Sequence[tuple[Any, dict[str, NDArray[np.uint8]]]],
) -> None:
    """Put a FitJob's result into the scene, instead of the measurement that was there."""
    kept = scene.togishi_measurement
    old = [(fit.scans_image, fit.mu_eff_image) for fit in kept.fits]
    kept.fits.clear()
    kept.title = ", ".join(Path(path).name for path in paths)
    for index, (fit, pictures) in enumerate(result):
        scans_image, mu_eff_image = old[index] if index < len(old) else (None, None)
        record = fit.record
        item = kept.fits.add()
        item.name = record["model"]
        item.record_json = json.dumps(record)
        item.scans_image = _write(
            f"Fit of {record['model']}", scans_image, pictures["scans"], scene
        )
        item.mu_eff_image = _write(
            f"Fit of {record['model']}, half width", mu_eff_image, pictures["mu_eff"], scene
        )
    for images in old[len(result) :]:
        for image in images:
            if image is not None and image.users == 0:
                bpy.data.images.remove(image)


_CLASSES = (TogishiFit, TogishiMeasurement)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.togishi_measurement = PointerProperty(type=TogishiMeasurement)


def unregister() -> None:
    del bpy.types.Scene.togishi_measurement
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
