"""From Blender's evaluated dependency graph to scene data, reading again only what changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import bpy
import numpy as np

from .. import blender_versions, properties
from ..core import native
from ..core.materials import blade_material
from ..core.scene_data import (
    BladeMaterial,
    ColourSettings,
    Instance,
    Light,
    MapData,
    Material,
    MeshData,
    NormalMapData,
    PlainMaterial,
    SceneData,
)
from .emission_read import Emission, KnownPictures, lamps_of, read_emission, rectangle_of
from .environment_read import KnownEnvironment
from .image_maps import MapError, image_key, read_maps, read_normal_map
from .light_read import read_light, read_world
from .material_read import read_plain
from .mesh_read import read_mesh

_Data = TypeVar("_Data", MapData, NormalMapData)

_NO_MATERIAL = "no material"
_GENERATED = "generated "  # keys of meshes that no data-block stands for


def matrix_array(matrix: object) -> np.ndarray:
    return np.array(matrix, np.float64)


class SceneSync:
    """Keeps what it read of one depsgraph. One belongs to each viewport and each final render."""

    def __init__(self) -> None:
        self.messages: list[str] = []  # what the user should know of the last update
        self._scene: SceneData | None = None
        self._meshes: dict[str, tuple[frozenset[int], MeshData]] = {}
        self._mesh_users: dict[str, set[int]] = {}  # mesh key -> session uids that it came from
        self._materials: dict[str, tuple[int, Material, str]] = {}
        self._maps: dict[tuple[object, ...], MapData | str] = {}
        self._normal_maps: dict[tuple[object, ...], NormalMapData | str] = {}
        self._emissions: dict[str, Emission] = {}  # by material's key
        self._pictures = KnownPictures()
        self._shining: list[Light] = []  # rectangles of the last reading
        self._light_objects: list[int] = []
        self._instanced_lights = False
        self._environment = KnownEnvironment()
        self._light_notes: list[str] = []
        self._other_notes: list[str] = []

    def update(
        self, depsgraph: bpy.types.Depsgraph, view3d: bpy.types.SpaceView3D | None = None
    ) -> SceneData:
        """The scene now. Meshes, materials and maps that did not change are the objects of the last time."""
        if self._scene is None:
            self._scene = self._read_all(depsgraph, view3d)
        else:
            only_lights = self._forget_changed(depsgraph)
            only_lights = only_lights and self._lamps(depsgraph, view3d) == set(self._light_objects)
            if only_lights and not self._instanced_lights:
                self._scene = self._read_lights(depsgraph, view3d, self._scene)
            else:
                self._scene = self._read_all(depsgraph, view3d)
        self.messages = [*self._other_notes, *self._light_notes]
        return self._scene

    @staticmethod
    def _lamps(depsgraph: bpy.types.Depsgraph, view3d: bpy.types.SpaceView3D | None) -> set[int]:
        """Session uids of the lamps that are seen now: a driver switches one on without a word in the updates."""
        return {
            obj.original.session_uid
            for obj in depsgraph.objects
            if obj.type == "LIGHT"
            and (view3d is None or obj.original.visible_in_viewport_get(view3d))
        }

    # --- what changed ---------------------------------------------------------------------------

    def _forget_changed(self, depsgraph: bpy.types.Depsgraph) -> bool:
        """Drop what an update touched. Whether nothing but lamps, world and their trees changed."""
        only_lights = True
        for update in depsgraph.updates:
            changed = update.id
            if isinstance(changed, bpy.types.Light | bpy.types.World):
                continue
            if isinstance(changed, bpy.types.Object) and changed.type == "LIGHT":
                continue
            if isinstance(changed, bpy.types.ShaderNodeTree) and changed.is_embedded_data:
                # A material's own tree comes together with its material.
                continue
            only_lights = False
            uid = changed.original.session_uid
            if update.is_updated_geometry:
                for key in [k for k, users in self._mesh_users.items() if uid in users]:
                    self._meshes.pop(key, None)
                    del self._mesh_users[key]
            if isinstance(changed, bpy.types.Material):
                for name in [k for k, known in self._materials.items() if known[0] == uid]:
                    del self._materials[name]
            if isinstance(changed, bpy.types.Image):
                for known in (self._maps, self._normal_maps):
                    for key in [k for k in known if uid in _uids(k)]:
                        del known[key]
                self._materials.clear()
                self._environment.key = ()
        return only_lights

    # --- reading --------------------------------------------------------------------------------

    def _read_all(
        self, depsgraph: bpy.types.Depsgraph, view3d: bpy.types.SpaceView3D | None
    ) -> SceneData:
        self._light_objects, self._instanced_lights = [], False
        self._light_notes, self._other_notes = [], []
        self._shining = []
        self._meshes = {k: v for k, v in self._meshes.items() if not k.startswith(_GENERATED)}
        lights: list[Light] = []
        instances: list[Instance] = []
        meshes: dict[str, MeshData] = {}
        materials: dict[str, Material] = {}
        for item in depsgraph.object_instances:
            if not item.show_self:
                continue
            obj = item.object
            owner = item.parent if item.is_instance else obj
            if (
                view3d is not None
                and owner is not None
                and not owner.original.visible_in_viewport_get(view3d)
            ):
                continue
            if obj.type == "LIGHT":
                if item.is_instance:
                    self._instanced_lights = True
                else:
                    self._light_objects.append(obj.original.session_uid)
                lights.append(read_light(obj.data, matrix_array(item.matrix_world)))
            elif obj.type == "MESH":
                # Curves, texts, surfaces and metaballs come a second time, as instances of their meshes.
                keys = self._object_materials(obj, materials)
                key, mesh = self._mesh(obj, item.is_instance, keys)
                if mesh is not None and mesh.groups:
                    meshes[key] = mesh
                    instance = Instance(
                        key,
                        matrix_array(item.matrix_world),
                        keys,
                        casts=bool(obj.visible_shadow),
                        mirrored=bool(obj.visible_glossy),
                    )
                    instances.append(instance)
                    self._read_shining(obj, instance, materials)
        self._meshes = {key: known for key, known in self._meshes.items() if key in meshes}
        for name in materials:
            note = self._materials[name][2]
            if note:
                self._other_notes.append(note)
        self._other_notes = list(dict.fromkeys(self._other_notes))
        world, note = read_world(depsgraph.scene_eval.world, self._environment)
        if note:
            self._light_notes.append(note)
        return SceneData(
            meshes=meshes,
            instances=tuple(instances),
            materials=materials,
            lights=(*lights, *self._shining),
            world=world,
            colour=self._colour(depsgraph),
            transparent=depsgraph.scene_eval.render.film_transparent,
            filtered=self._setting(depsgraph, "filter_highlights"),
            mirror_things=self._setting(depsgraph, "mirror_things"),
        )

    def _read_lights(
        self,
        depsgraph: bpy.types.Depsgraph,
        view3d: bpy.types.SpaceView3D | None,
        scene: SceneData,
    ) -> SceneData:
        """Only the lamps and the world again."""
        wanted = set(self._light_objects)
        self._light_notes = []
        lights: list[Light] = []
        for obj in depsgraph.objects:
            if obj.type != "LIGHT" or obj.original.session_uid not in wanted:
                continue
            if view3d is not None and not obj.original.visible_in_viewport_get(view3d):
                continue
            lights.append(read_light(obj.data, matrix_array(obj.matrix_world)))
        lights += self._shining
        world, note = read_world(depsgraph.scene_eval.world, self._environment)
        if note:
            self._light_notes.append(note)
        return SceneData(
            meshes=scene.meshes,
            instances=scene.instances,
            materials=scene.materials,
            lights=tuple(lights),
            world=world,
            colour=self._colour(depsgraph),
            transparent=depsgraph.scene_eval.render.film_transparent,
            filtered=self._setting(depsgraph, "filter_highlights"),
            mirror_things=self._setting(depsgraph, "mirror_things"),
        )

    @staticmethod
    def _setting(depsgraph: bpy.types.Depsgraph, name: str) -> bool:
        """A switch of the render settings, on where there are none."""
        settings = getattr(depsgraph.scene_eval, "togishi", None)
        return bool(getattr(settings, name, True))

    @staticmethod
    def _colour(depsgraph: bpy.types.Depsgraph) -> ColourSettings:
        settings = getattr(depsgraph.scene_eval, "togishi", None)
        return ColourSettings(
            observer=getattr(settings, "observer", "cie1931_2"),
            space=blender_versions.working_space(),
            adaptation=getattr(settings, "adaptation", "none"),
            white=properties.adapted_white(depsgraph.scene_eval),
        )

    def _object_materials(
        self, obj: bpy.types.Object, materials: dict[str, Material]
    ) -> tuple[str, ...]:
        keys = []
        for slot in obj.material_slots:
            material = slot.material
            key = _NO_MATERIAL if material is None else f"{material.original.session_uid}"
            keys.append(key)
            materials[key] = self._material(key, material)
        if not keys:
            keys.append(_NO_MATERIAL)
            materials[_NO_MATERIAL] = self._material(_NO_MATERIAL, None)
        return tuple(keys)

    def _material(self, key: str, material: bpy.types.Material | None) -> Material:
        known = self._materials.get(key)
        if known is not None:
            return known[1]
        note = ""
        data: Material = read_plain(material)
        self._emissions[key] = Emission()
        if material is not None and properties.is_blade(material):
            try:
                maps, note = self._material_maps(material)
                normal_map, normal_note = self._material_normal_map(material)
                note = " ".join(text for text in (note, normal_note) if text)
                data = blade_material(properties.material_dict(material), maps, normal_map)
            except (native.CoreMissingError, ValueError) as error:
                note = f"Material {material.name!r}: {error}"
        if isinstance(data, PlainMaterial):
            self._emissions[key] = read_emission(material)
            note = self._emissions[key].note
            data = replace(data, shine=self._emissions[key].radiance)
        uid = -1 if material is None else material.original.session_uid
        self._materials[key] = (uid, data, note)
        return data

    def _read_shining(
        self,
        obj: bpy.types.Object,
        instance: Instance,
        materials: dict[str, Material],
    ) -> None:
        """The lamps that an object is which shines."""
        for key in dict.fromkeys(instance.materials):
            emission, material = self._emissions[key], materials[key]
            if emission.dark or not isinstance(material, PlainMaterial):
                continue
            rectangle = rectangle_of(obj.data)
            lamps = (
                [] if rectangle is None else lamps_of(rectangle, instance, emission, self._pictures)
            )
            self._shining += lamps
            if lamps:
                materials[key] = replace(material, picture=lamps[0].picture)
                continue
            self._other_notes.append(
                f"Object {obj.name!r} shines but is no single rectangle: it is drawn bright and lights nothing."
            )
            if emission.image is not None:
                whole = self._pictures.picture(emission.image, (0.5, 0.0, 0.5), (0.0, 0.5, 0.5))
                mean = 1.0 if whole is None else whole.pixels.mean(axis=(0, 1))
                shine = np.asarray(emission.radiance) * mean
                materials[key] = replace(material, shine=tuple(shine.tolist()))

    def _material_maps(self, material: bpy.types.Material) -> tuple[MapData | None, str]:
        lobes, shape = properties.blade_images(material)
        if lobes is None:
            return None, ""
        key = (image_key(lobes), None if shape is None else image_key(shape))
        return _read_once(self._maps, key, material, lambda: read_maps(lobes, shape))

    def _material_normal_map(
        self, material: bpy.types.Material
    ) -> tuple[NormalMapData | None, str]:
        image = material.togishi.normal_image
        if image is None:
            return None, ""
        key = (image_key(image),)
        return _read_once(self._normal_maps, key, material, lambda: read_normal_map(image))

    def _mesh(
        self, obj: bpy.types.Object, is_instance: bool, keys: tuple[str, ...]
    ) -> tuple[str, MeshData | None]:
        blade_slots = frozenset(
            slot
            for slot, key in enumerate(keys)
            if key in self._materials and isinstance(self._materials[key][1], BladeMaterial)
        )
        original, data = obj.original, obj.data
        users = {original.session_uid}
        if original.data is not None:
            users.add(original.data.session_uid)
        shared = (
            obj.type == "MESH"
            and not obj.modifiers
            and original.mode == "OBJECT"
            and data.shape_keys is None
            and original.data is not None
            and not original.data.is_editmode
        )
        if shared:
            key = f"mesh {original.data.session_uid} {sorted(blade_slots)}"
        elif is_instance and not (data.is_evaluated and data.original == original.data):
            # Geometry made by nodes has no identifier of its own; its address is one during this reading only.
            key = f"{_GENERATED}{data.as_pointer()} {sorted(blade_slots)}"
        else:
            key = f"object {original.session_uid}"
        known = self._meshes.get(key)
        if known is not None and known[0] == blade_slots:
            return key, known[1]
        mesh = self._read_geometry(obj, blade_slots)
        if mesh is not None:
            self._meshes[key] = (blade_slots, mesh)
            self._mesh_users[key] = users
        return key, mesh

    @staticmethod
    def _read_geometry(obj: bpy.types.Object, blade_slots: frozenset[int]) -> MeshData | None:
        original = obj.original.data
        if not (isinstance(original, bpy.types.Mesh) and original.is_editmode):
            return read_mesh(obj.data, blade_slots)
        # In Edit Mode the evaluated mesh may be a wrapper without vertices.
        mesh = obj.to_mesh()
        if mesh is None:
            return None
        try:
            return read_mesh(mesh, blade_slots)
        finally:
            obj.to_mesh_clear()


def _read_once(
    known: dict[tuple[object, ...], _Data | str],
    key: tuple[object, ...],
    material: bpy.types.Material,
    read: Callable[[], _Data],
) -> tuple[_Data | None, str]:
    """What `read` makes of a material's images, kept by their keys; or None and why there is nothing."""
    found = known.get(key)
    if found is None:
        try:
            found = read()
        except MapError as error:
            found = str(error)
        # Other revisions of the same images are not asked for again.
        for old in [k for k in known if _uids(k) == _uids(key)]:
            del known[old]
        known[key] = found
    if isinstance(found, str):
        return None, f"Material {material.name!r}: {found}"
    return found, ""


def _uids(key: tuple[object, ...]) -> set[object]:
    return {image[0] for image in key if isinstance(image, tuple)}
