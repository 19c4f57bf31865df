"""A scanned sword in a file: the work beside the user interface, and the objects that come of it."""

from __future__ import annotations

import datetime
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import bmesh
import bpy
import numpy as np

from . import blade_object, data_blocks, properties, scan_aside
from .background_job import BackgroundJob
from .core import scan_report
from .nodes import scan_images
from .scan_read import ScanArrays

# FACE attribute: the part that the user painted; NOT_PAINTED elsewhere.
PAINTED = "togishi_part_painted"
NOT_PAINTED = -1


class ScanJob(BackgroundJob):
    """From a scan to a blade. The result is a togishi_core.ScannedSword with what the record needs."""

    thread_name = "togishi-scan"

    def __init__(
        self,
        path: Path,
        scan: ScanArrays | None,
        options: Mapping[str, Any],
        painted: Mapping[str, Any] | None = None,
        sha256: str = "",
    ) -> None:
        """scan: None where the core reads the file itself. sha256: of the file that it has to be; empty: any."""
        super().__init__()
        self._sha256 = sha256
        self.path = path
        self.options = dict(options)
        self._painted = painted
        self._scan = scan

    def _compute(self) -> Any:
        scan, self._scan = self._scan, None  # the core may free what it has read
        self.source = scan_report.file_facts(self.path, "scan")
        if self._sha256 and self.source["sha256"] != self._sha256:
            raise self._core.InputError(
                f"{self.path} is not the file any more that this blade came from"
            )
        further = {"painted": self._painted, "progress": self._progress}
        if scan is None:
            return self._core.scan_import_file(self.path, self.options, **further)
        return self._core.scan_import(
            scan.positions, scan.triangles, scan.colours, scan.origin, self.options, **further
        )


def _collection(scene: bpy.types.Scene, name: str) -> bpy.types.Collection:
    collection = bpy.data.collections.new(name)
    scene.collection.children.link(collection)
    return collection


def _image(name: str, pixels: Any, is_data: bool) -> bpy.types.Image:
    """(H, W, C), rows from v = 0; colours 8 bits, data in floats."""
    height, width, channels = pixels.shape
    image = bpy.data.images.new(
        name, width, height, alpha=True, float_buffer=is_data, is_data=is_data
    )
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels if is_data else pixels.astype(np.float32) / 255.0
    image.pixels.foreach_set(rgba.reshape(-1))
    image.update()
    image.pack()
    return image


def _fill(obj: bpy.types.Object, sword: Any, unit_m: float) -> None:
    """The blade's mesh, in scene units, which the object remembers: the scene's may change."""
    blade_object.fill_mesh(obj.data, sword, unit_m)
    obj.togishi.scan.unit_m = unit_m


def record_text(job: ScanJob, sword: Any, about: Mapping[str, str]) -> str:
    """The JSON-LD record of this import."""
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return sword.record({**about, "created_utc": now}, [job.source], [])


def place(
    context: bpy.types.Context, job: ScanJob, sword: Any, about: Mapping[str, str]
) -> bpy.types.Object:
    """The blade with its material, and the pieces kept aside, in a collection named after the file."""
    scene = context.scene
    name = job.path.stem
    unit_m = scene.unit_settings.scale_length or 1.0
    collection = _collection(scene, name)
    mesh = bpy.data.meshes.new(name)
    obj = bpy.data.objects.new(name, mesh)
    _fill(obj, sword, unit_m)
    collection.objects.link(obj)
    material = blade_object.new_material(f"{name} steel")
    obj.data.materials.append(material)
    keep(obj, job, sword, about)
    scan_aside.put(obj, name, list(sword.aside), unit_m)
    blade_object.select_only(context, obj)
    return obj


def keep(obj: bpy.types.Object, job: ScanJob, sword: Any, about: Mapping[str, str]) -> None:
    """What the object remembers: its chart, what was found, the record, and how to do it again."""
    scan = obj.togishi.scan
    obj.togishi.frame_json = json.dumps(sword.frame, separators=(",", ":"))
    scan.filepath = str(job.path)
    scan.sha256 = job.source["sha256"]
    scan.report_json = json.dumps(sword.report)
    scan.options_json = json.dumps(job.options)
    scan.about_json = json.dumps(dict(about))
    if scan.record is None:
        scan.record = bpy.data.texts.new(f"{obj.name} record.jsonld")
    scan.record.clear()
    scan.record.write(record_text(job, sword, about))
    replaced = []
    for channel, pixels, is_data in (
        ("normal", sword.maps.get("normal"), True),
        ("displacement_mm", sword.maps.get("displacement_mm"), True),
        ("colour", sword.maps.get("colour"), False),
    ):
        before = getattr(scan, f"{channel.removesuffix('_mm')}_image")
        image = None
        if pixels is not None:
            pixels = pixels if pixels.ndim == 3 else pixels[..., None]
            if channel == "normal":
                pixels = 0.5 + 0.5 * pixels  # as a picture holds it
            image = _image(f"{obj.name} {channel}", pixels, is_data)
        setattr(scan, f"{channel.removesuffix('_mm')}_image", image)
        if channel == "normal":
            for material in obj.data.materials:
                if material is not None and material.togishi.normal_image in (None, before):
                    material.togishi.normal_image = image
        replaced.append(before)
    for material in obj.data.materials:
        if properties.is_blade(material):
            scan_images.put(material, scan.colour_image, scan.displacement_image, scan.unit_m)
    for image in replaced:
        if image is not None and image.users == 0:
            bpy.data.images.remove(image)


def paint_part(obj: bpy.types.Object, part: int) -> int:
    """Give the faces selected in Edit Mode a part, for good. Returns how many there are."""
    mesh = obj.data
    edited = bmesh.from_edit_mesh(mesh)
    layers = edited.faces.layers.int
    painted = layers.get(PAINTED)
    if painted is None:
        painted = layers.new(PAINTED)
        for face in edited.faces:
            face[painted] = NOT_PAINTED
    own = layers["togishi_part"]
    chosen = [face for face in edited.faces if face.select]
    for face in chosen:
        face[own] = face[painted] = part
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
    return len(chosen)


def painted(obj: bpy.types.Object, mm_per_unit: float = 0.0) -> dict[str, Any] | None:
    """The painted faces in the scan's own axes (mm, told from an origin), as togishi_core.scan_import takes them over;
    None where nothing was painted. mm_per_unit: of the scan's file as it is to be read now; 0: as it was read."""
    mesh = obj.data
    attribute = mesh.attributes.get(PAINTED)
    if attribute is None:
        return None
    part = np.empty(len(mesh.polygons), np.int32)
    attribute.data.foreach_get("value", part)
    if (part == NOT_PAINTED).all():
        return None
    report = report_of(obj)
    pose = report["pose"]
    was_mm = float(report["unit"]["mm_per_unit"])
    larger = (mm_per_unit or was_mm) / was_mm
    places = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", places)
    blade_mm = places.reshape(-1, 3).astype(float) * (obj.togishi.scan.unit_m / blade_object.MM)
    # Blade = rotation (scan - origin). Told from the origin, which may be 1e5 mm away, floats keep micrometres.
    from_origin_mm = blade_mm @ np.array(pose["rotation"], float) * larger
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    faces = np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    mesh.loop_triangles.foreach_get("polygon_index", faces)
    return {
        "origin_mm": [larger * v for v in pose["origin_mm"]],
        "positions_mm": from_origin_mm.astype(np.float32),
        "triangles": corners.reshape(-1, 3),
        "part": part[faces],
    }


def replace(context: bpy.types.Context, obj: bpy.types.Object, job: ScanJob, sword: Any) -> None:
    """The blade as it is understood now, in the same object. Material slots stay with their parts."""
    about = json.loads(obj.togishi.scan.about_json)
    unit_m = context.scene.unit_settings.scale_length or 1.0
    slots = blade_object.slot_of_part(obj.data)
    obj.data.clear_geometry()
    _fill(obj, sword, unit_m)
    scan_aside.put(obj, job.path.stem, list(sword.aside), unit_m)
    blade_object.set_slots(obj.data, slots)
    if sword.painted is not None:
        attribute = obj.data.attributes.new(PAINTED, "INT", "FACE")
        attribute.data.foreach_set("value", np.asarray(sword.painted, np.int32))
    keep(obj, job, sword, about)


def report_of(obj: bpy.types.Object | None) -> dict[str, Any]:
    """What the import of this object found; empty for other objects."""
    if obj is None or obj.type != "MESH" or not obj.togishi.scan.report_json:
        return {}
    found: dict[str, Any] = json.loads(obj.togishi.scan.report_json)
    return found


def scanned_blade(context: bpy.types.Context) -> bpy.types.Object | None:
    """The blade that the panels show, where it came from a scan."""
    blade = blade_object.find_blade(context)
    return blade if blade is not None and blade.togishi.scan.report_json else None


def by_uid(uid: int) -> bpy.types.Object | None:
    return data_blocks.by_uid(bpy.data.objects, uid)
