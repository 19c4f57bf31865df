"""Photographs in a scene: their set-up, landmarks and what was found in them. The maps lie in files beside the
set-up; pictures of them are kept in the .blend."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from numpy.typing import NDArray

from . import data_blocks, map_files
from .background_job import BackgroundJob, running
from .core import photographs as files
from .core.photographs import is_light_file

MAP_SIZE = (4096, 512)


class PhotographJob(BackgroundJob):
    """Work on photographs, away from Blender's data: `state` is a copy of what the scene has."""

    thread_name = "togishi-photographs"

    def __init__(self, state: Mapping[str, Any]) -> None:
        super().__init__()
        self._state = dict(state)
        self._oiio: Any = map_files.open_image_io()
        self._path = Path(state["path"])

    def _read(self, path: str) -> tuple[NDArray[np.float32], bool]:
        return files.read_picture(self._oiio, path)

    def _setup(self) -> Any:
        text = self._path.read_text(encoding="utf-8-sig")
        text += files.landmark_tables(self._state["landmarks"])
        return self._core.parse_capture_setup(text, str(self._path))

    @property
    def _lights(self) -> bool:
        return is_light_file(self._path)


class PlanJob(PhotographJob):
    """What the set-up can see. Result: sentences, a picture or None, the camera or None."""

    def _compute(self) -> dict[str, Any]:
        options = self._state["options"]
        if self._lights:
            plan = self._core.capture_lights_plan(str(self._path), options)
            return {"sentences": [plan["sentence"]], "picture": None, "camera": None}
        setup = self._setup()
        self._progress(0.2)
        plan = self._core.capture_diffuse_plan(setup, options)
        sentences = list(plan["sentences"])
        if setup.silhouette is not None:
            sentences.append(
                f"The camera is refined on the outline in {Path(setup.silhouette).name} when maps are found"
            )
        return {
            "sentences": sentences,
            "picture": plan["picture"],
            "camera": setup.camera,
            "fit": setup.camera_fit,
            "offset": len(setup.landmarks) - len(self._state["landmarks"]),
        }


class RunJob(PhotographJob):
    """The evaluation. Result: sentences, pictures, the camera or None, frame; the maps are in files."""

    def _compute(self) -> dict[str, Any]:
        return self._many_lights() if self._lights else self._diffuse()

    def _keep(self, maps: Mapping[str, Any], planes: Mapping[str, Any]) -> None:
        target = maps_path(self._path)
        map_files.save(maps, target)
        pixels = np.stack([np.asarray(plane, np.float32) for plane in planes.values()], axis=-1)
        files.write_planes(self._oiio, quality_path(self._path), list(planes), pixels)

    def _diffuse(self) -> dict[str, Any]:
        setup = self._setup()
        found = self._core.capture_diffuse(
            setup, self._read, self._state["options"], progress=self._progress
        )
        self._keep(found["maps"], {**found["quality"], "usable": found["usable"]})
        seen = max(int(found["seen"]), 1)
        sentences = [
            f"w is told on {1 - found['masked_w'] / seen:.0%} of what is seen, calibrated by "
            f"{found['calibration']}",
        ]
        if found["mu_measured"]:
            sentences.append(f"μ is told on {1 - found['masked_mu'] / seen:.0%} of it")
        sentences += found["notes"]
        return {
            "sentences": sentences,
            "pictures": found["pictures"],
            "camera": found["camera"],
            "outline": found["outline"],
            "frame": "surface",
        }

    def _many_lights(self) -> dict[str, Any]:
        options = self._state["options"]
        plan = self._core.capture_lights_plan(str(self._path), options)
        photographs = files.Photographs(self._oiio, plan["pictures"])
        try:
            target = self._path.with_name(f"{self._path.stem}-lights.exr")
            tiles = self._core.capture_lights(
                str(self._path), photographs, str(target), options, progress=self._progress
            )
        finally:
            photographs.close()
        channels = self._core.CAPTURE_CHANNELS
        shown = channels.index("lobe.ln_mu_deg")
        ln_mu = np.empty((tiles.height, tiles.width), np.float32)

        def bands() -> Iterator[NDArray[np.float32]]:
            begin = 0
            for band in range(tiles.bands):
                rows = tiles.read(band)
                ln_mu[begin : begin + len(rows)] = rows[..., shown]
                begin += len(rows)
                yield rows

        files.write_bands(self._oiio, target, channels, ln_mu.shape, bands())
        found = tiles.property_maps()
        self._keep(found["maps"], {"usable": found["usable"]})
        tiles.remove()
        return {
            "sentences": [
                f"{tiles.width} x {tiles.height} pixels, "
                f"{1 - found['usable'].mean():.1%} of them flagged"
            ],
            "pictures": {"mu": grey_picture(ln_mu, found["usable"])},
            "camera": None,
            "outline": None,
            "frame": "image",
        }


class ProjectJob(PhotographJob):
    """Maps onto the chart of the blade, those of `earlier` set-ups too. Result: as togishi_core.capture_project, and "camera" and "outline" where the
    camera was refined here."""

    def _refined(self) -> Any:
        """The set-up on the outline that it names, where the run's camera is not that one already; else None."""
        if self._lights or self._state["on_outline"]:
            return None
        setup = self._setup()
        if setup.silhouette is None:
            return None
        return self._core.refine_capture_camera(setup, self._read)

    def _compute(self) -> Any:
        refined = self._refined()
        camera = self._state["camera"] if refined is None else refined.camera
        mine = {"path": self._path, "camera": camera, "frame": self._state["frame"]}
        every = [
            {
                "maps": map_files.load(maps_path(Path(one["path"]))),
                "usable": files.read_plane(self._oiio, quality_path(Path(one["path"])), "usable")
                > 0.5,
                "camera": one["camera"],
                "frame": one["frame"],
            }
            for one in (*self._state["earlier"], mine)
        ]
        width, height = self._state["size"]
        found = self._core.capture_project(
            self._state["blade"],
            every,
            width,
            height,
            detail=self._state["detail"],
            progress=self._progress,
        )
        found["camera"] = None if refined is None else refined.camera
        found["outline"] = None if refined is None else refined.outline
        return found


def is_running() -> bool:
    return any(isinstance(job, PhotographJob) for job in running())


def maps_path(setup: Path) -> Path:
    return setup.with_name(f"{setup.stem}-maps.exr")


def quality_path(setup: Path) -> Path:
    return setup.with_name(f"{setup.stem}-maps-quality.exr")


def grey_picture(values: NDArray[np.float32], usable: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """(H, W, 3) in 8-bit sRGB: dark is low, bright high between the 2nd and 98th percentile; red is not usable."""
    good = usable & np.isfinite(values)
    low, high = np.percentile(values[good], [2, 98]) if good.any() else (0.0, 1.0)
    share = np.clip((np.nan_to_num(values) - low) / max(float(high - low), 1e-6), 0.0, 1.0)
    picture = np.repeat((20.0 + 220.0 * share).astype(np.uint8)[..., None], 3, axis=-1)
    picture[~good] = (150, 40, 40)
    return picture


# --- what is kept -------------------------------------------------------------------------------


class TogishiLandmark(bpy.types.PropertyGroup):
    """A place on the blade, and where it is in the photograph."""

    point_mm: FloatVectorProperty(
        name="On the blade (mm)",
        description="Place in the blade's frame, in mm: x to the tip, y out of omote, z to the back",
        size=3,
    )
    pixel: FloatVectorProperty(
        name="In the photograph (px)",
        description="Pixels from the upper left corner, to the right and down",
        size=2,
    )
    has_point: BoolProperty(name="Picked on the blade", description="Whether its place is known")
    has_pixel: BoolProperty(
        name="Marked in the photograph", description="Whether it was marked in the photograph"
    )
    residual_mm: FloatProperty(
        name="Residual (mm)",
        description="How far the mark lies from where the camera sees the place, in mm; below 0: no camera yet",
        default=-1.0,
    )


class TogishiEarlier(bpy.types.PropertyGroup):
    """A set-up whose maps were found before, from where another photograph of the blade was taken."""

    filepath: StringProperty(name="Set-up", subtype="FILE_PATH")
    camera_json: StringProperty(name="Camera", options={"HIDDEN"})
    frame: StringProperty(name="Frame", options={"HIDDEN"})
    use: BoolProperty(
        name="Use", description="Whether 'Apply to Blade' blends its maps in", default=True
    )


class TogishiPhotographs(bpy.types.PropertyGroup):
    """The photographs that this scene's blade was taken from."""

    filepath: StringProperty(
        name="Set-up", description="The set-up (.toml) or light file (.lp)", subtype="FILE_PATH"
    )
    options_json: StringProperty(name="Options", default="{}", options={"HIDDEN"})
    plan: StringProperty(name="Plan", description="What the set-up can see", options={"HIDDEN"})
    found: StringProperty(name="Found", description="What was found", options={"HIDDEN"})
    frame: StringProperty(name="Frame", options={"HIDDEN"})
    camera_json: StringProperty(name="Camera", options={"HIDDEN"})
    rms_mm: FloatProperty(
        name="Residual (mm)", description="Root mean square of the landmarks, in mm", default=-1.0
    )
    outline_mm: FloatProperty(
        name="Outline (mm)",
        description="Root mean square from the blade's outline to the picture's, in mm; below 0: not refined on it",
        default=-1.0,
    )
    camera_kind: EnumProperty(
        name="Camera",
        description="How the camera sees",
        items=(
            ("orthographic", "Far", "From so far that it has no perspective; 4 landmarks or more"),
            ("pinhole", "Near", "With perspective; 6 landmarks or more, not in one plane"),
        ),
    )
    side: EnumProperty(
        name="Side",
        description="Which side of the blade faces the camera",
        items=(("omote", "Omote", "The blade's +y side"), ("ura", "Ura", "The blade's -y side")),
    )
    landmarks: CollectionProperty(type=TogishiLandmark)
    active_landmark: IntProperty(name="Landmark", description="Which landmark is marked next")
    earlier: CollectionProperty(type=TogishiEarlier)
    photograph: PointerProperty(
        type=bpy.types.Image,
        name="Photograph",
        description="The photograph that landmarks are marked in",
    )
    plan_image: PointerProperty(
        type=bpy.types.Image, name="Plan", description="Radiance against half width"
    )
    w_image: PointerProperty(type=bpy.types.Image, name="w", description="Where it is hamon")
    mu_image: PointerProperty(type=bpy.types.Image, name="μ", description="How wide the lobe is")


def setup_path(kept: TogishiPhotographs) -> Path:
    return Path(bpy.path.abspath(kept.filepath))


def marked(kept: TogishiPhotographs) -> list[dict[str, Any]]:
    """The landmarks that are on the blade and in the photograph, as the core takes them."""
    return [
        {"name": one.name, "point_mm": tuple(one.point_mm), "pixel": tuple(one.pixel)}
        for one in kept.landmarks
        if one.has_point and one.has_pixel
    ]


def state_of(kept: TogishiPhotographs) -> dict[str, Any]:
    """What a job starts from."""
    return {
        "path": str(setup_path(kept)),
        "options": json.loads(kept.options_json),
        "landmarks": marked(kept),
        "camera": json.loads(kept.camera_json) if kept.camera_json else None,
        "on_outline": kept.outline_mm >= 0.0,
        "frame": kept.frame or "surface",
        "earlier": [
            {
                "path": bpy.path.abspath(one.filepath),
                "camera": json.loads(one.camera_json),
                "frame": one.frame,
            }
            for one in kept.earlier
            if one.use
        ],
    }


def keep_fit(kept: TogishiPhotographs, fit: Mapping[str, Any] | None, offset: int = 0) -> None:
    """Residuals to their landmarks; offset: how many the set-up itself has before ours."""
    kept.outline_mm = -1.0
    for one in kept.landmarks:
        one.residual_mm = -1.0
    kept.rms_mm = -1.0 if fit is None else float(fit["rms_mm"])
    if fit is None:
        return
    used = [one for one in kept.landmarks if one.has_point and one.has_pixel]
    for one, residual in zip(used, fit["residual_mm"][offset:], strict=False):
        one.residual_mm = float(residual)


def keep_earlier(kept: TogishiPhotographs, chosen: str) -> None:
    """What is known of the present set-up, before another is chosen: one whose maps were found is blended in later."""
    for index in reversed(range(len(kept.earlier))):
        if kept.earlier[index].filepath in (chosen, kept.filepath):
            kept.earlier.remove(index)
    if kept.found and kept.camera_json and kept.filepath != chosen:
        one = kept.earlier.add()
        one.filepath, one.camera_json = kept.filepath, kept.camera_json
        one.frame = kept.frame


def keep_camera(
    kept: TogishiPhotographs,
    camera: Mapping[str, Any] | None,
    outline: Mapping[str, Any] | None,
) -> None:
    """A camera that a job found, and how near it brings the outline, where it looked."""
    if camera is None:
        return
    kept.camera_json = json.dumps(camera)
    kept.outline_mm = -1.0 if outline is None else float(outline["rms_mm"])


def keep_picture(
    name: str, existing: bpy.types.Image | None, pixels: NDArray[np.uint8]
) -> bpy.types.Image:
    """(H, W, 3), the top row first, as a packed image."""
    own = existing is not None and existing.library is None
    return data_blocks.write_picture(name, existing if own else None, pixels)


_CLASSES = (TogishiLandmark, TogishiEarlier, TogishiPhotographs)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.togishi_photographs = PointerProperty(type=TogishiPhotographs)


def unregister() -> None:
    del bpy.types.Scene.togishi_photographs
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
