"""A goniometer's scans and their fit in a scene: the result is kept in the .blend, with its plots.

The fit itself needs no Blender data, so that it can run beside the user interface."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import CollectionProperty, PointerProperty, StringProperty
from numpy.typing import NDArray

from .core import native


class FitJob:
    """Reading and fitting in a thread of its own."""

    def __init__(self, paths: Sequence[str], options: Mapping[str, Any]) -> None:
        self._paths, self._options = list(paths), dict(options)
        self._core = native.core()
        self.share = 0.0  # of the work that is done
        self.cancelled = False
        self._fits: list[Any] = []
        self._pictures: list[dict[str, NDArray[np.uint8]]] = []
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="togishi-fit", daemon=True)

    def _run(self) -> None:
        try:
            sets = self._core.read_scans(self._paths)
            for index, scans in enumerate(sets):

                def progress(share: float, done: int = index) -> bool:
                    self.share = (done + share) / len(sets)
                    return not self.cancelled

                fit = self._core.fit_scans(scans, self._options, progress=progress)
                self._pictures.append(self._core.fit_pictures(fit))
                self._fits.append(fit)
        except Exception as error:  # handed to the main thread, which raises it again
            self._error = error
        finally:
            _running.discard(self)

    def start(self) -> None:
        _running.add(self)
        self._thread.start()

    def cancel(self) -> None:
        """End it at its next report of progress. There is no result then."""
        self.cancelled = True

    def wait(self) -> None:
        self._thread.join()

    @property
    def done(self) -> bool:
        return not self._thread.is_alive()

    def result(self) -> list[tuple[Any, dict[str, NDArray[np.uint8]]]]:
        """The fits with their pictures, ji first; waits for them. Raises what the work raised; InterruptedError
        after cancel()."""
        self.wait()
        if self._error is not None:
            raise self._error
        return list(zip(self._fits, self._pictures, strict=True))


_running: set[FitJob] = set()


def is_running() -> bool:
    return any(not job.cancelled for job in _running)


def stop_all() -> None:
    """Cancel what runs and wait for it: no thread outlives the add-on, or Blender."""
    for job in list(_running):
        job.cancel()
        job.wait()


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


def _write(
    name: str, existing: bpy.types.Image | None, pixels: NDArray[np.uint8]
) -> bpy.types.Image:
    height, width = pixels.shape[:2]
    image = existing
    if image is None or tuple(image.size) != (width, height):
        if image is not None and image.users <= 1:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(name, width, height, alpha=False)
    rgba = np.ones((height, width, 4), np.float32)
    # Blender's rows run upwards.
    rgba[..., :3] = pixels[::-1].astype(np.float32) / 255.0
    image.pixels.foreach_set(rgba.reshape(-1))
    image.update()
    image.pack()
    return image


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
        item.scans_image = _write(f"Fit of {record['model']}", scans_image, pictures["scans"])
        item.mu_eff_image = _write(
            f"Fit of {record['model']}, half width", mu_eff_image, pictures["mu_eff"]
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
    stop_all()
    del bpy.types.Scene.togishi_measurement
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
