"""Add → Mesh → Katana."""

from __future__ import annotations

import contextlib
import json
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from .. import blade_object, pattern_baking
from ..core import native
from ..core.katana_presets import PRESETS, preset
from .poll import LINKED, NEEDS_OBJECT_MODE, allowed, local

# key, label, tooltip, default, lowest, highest. Ranges and defaults are the core's (a test compares them);
# the core still decides which combinations make a blade.
DIMENSIONS = (
    ("nagasa_mm", "Nagasa", "Straight line from the mune-machi to the tip", 736.0, 60.0, 2500.0),
    ("sori_mm", "Sori", "Greatest distance of that line to the mune", 18.0, 0.0, 200.0),
    ("motohaba_mm", "Motohaba", "Width at the machi, mune ridge to edge", 31.0, 8.0, 80.0),
    ("sakihaba_mm", "Sakihaba", "Width at the yokote", 20.0, 5.0, 80.0),
    ("motokasane_mm", "Motokasane", "Thickness at the machi", 6.8, 2.0, 20.0),
    ("sakikasane_mm", "Sakikasane", "Thickness at the yokote", 4.3, 1.0, 20.0),
    (
        "kissaki_mm",
        "Kissaki",
        "Straight line from the yokote on the mune to the tip",
        33.0,
        5.0,
        400.0,
    ),
    (
        "nakago_mm",
        "Nakago",
        "Straight line from the mune-machi to the nakago's end",
        212.0,
        20.0,
        800.0,
    ),
)


def _dimension(row: tuple[Any, ...]) -> Any:
    _key, label, description, default, low, high = row
    return FloatProperty(
        name=f"{label} (mm)",
        description=f"{description}, in mm",
        default=default,
        min=low,
        max=high,
        precision=1,
        step=100,
    )


def _preset_items(_self: Any, _context: Any) -> list[tuple[str, str, str]]:
    return _ITEMS


_ITEMS = [(row.identifier, row.label, row.description) for row in PRESETS]


def preset_parameters(identifier: str) -> dict[str, Any]:
    """Every parameter of a preset: the core's defaults of its zukuri with the preset's changes."""
    chosen = preset(identifier)
    return {**native.core().katana_defaults(chosen.zukuri), **chosen.changes}


def _take(self: Any, values: dict[str, Any]) -> None:
    for key, value in values.items():
        if hasattr(self, key):
            setattr(self, key, value)


def _preset_chosen(self: Any, _context: Any) -> None:
    if not native.problem():
        self.zukuri = preset(self.preset).zukuri
        _take(self, preset_parameters(self.preset))


class KatanaDimensions:
    """The dimensions as operator settings, with the preset that fills them in."""

    preset: EnumProperty(
        name="Preset",
        description="Fills in all dimensions",
        items=_ITEMS,
        default="KATANA",
        update=_preset_chosen,
    )
    zukuri: EnumProperty(
        name="Zukuri",
        description="Cross-section and point",
        items=(
            ("shinogi", "Shinogi", "Ridge, and a point divided off by the yokote", 0),
            ("hira", "Hira", "Flat sides without a ridge", 1),
            ("shobu", "Shobu", "Ridge that runs out into the point, no yokote", 2),
        ),
        default="shinogi",
    )
    sori_type: EnumProperty(
        name="Sori type",
        description="Where the curve lies",
        items=(
            ("torii", "Torii", "In the middle", 0),
            ("koshi", "Koshi", "Towards the nakago", 1),
            ("saki", "Saki", "Towards the point", 2),
            ("even", "Even", "An arc of a circle", 3),
        ),
        default="torii",
    )
    mune: EnumProperty(
        name="Mune",
        description="Shape of the back",
        items=(
            ("iori", "Iori", "Roof", 0),
            ("mitsu", "Mitsu", "Three faces", 1),
            ("maru", "Maru", "Round", 2),
            ("kaku", "Kaku", "Flat", 3),
        ),
        default="iori",
    )
    detail: FloatProperty(
        name="Detail",
        description="Number of vertices: 1 gives some 50,000",
        default=1.0,
        min=0.02,
        max=16.0,
        soft_min=0.1,
        soft_max=4.0,
    )
    __annotations__ |= {row[0]: _dimension(row) for row in DIMENSIONS}

    def parameters(self) -> dict[str, Any]:
        """What the core is asked for. A setting that was not touched takes the preset's value, so
        that preset="TANTO" alone, from a script, gives a whole tanto."""
        values = preset_parameters(self.preset)
        touched = self.properties.is_property_set
        if touched("zukuri") and self.zukuri != values["zukuri"]:
            values = native.core().katana_defaults(self.zukuri)
        for key in ("sori_type", "mune", *(row[0] for row in DIMENSIONS)):
            if touched(key):
                values[key] = getattr(self, key)
        return values

    def draw_dimensions(self, layout: bpy.types.UILayout) -> None:
        layout.use_property_split = True
        layout.use_property_decorate = False
        for key in ("preset", "zukuri", "sori_type", "mune"):
            layout.prop(self, key)
        column = layout.column(align=True)
        for row in DIMENSIONS:
            column.prop(self, row[0])
        layout.prop(self, "detail")


class TOGISHI_OT_katana_add(KatanaDimensions, bpy.types.Operator):
    """Add a Japanese sword blade of documented dimensions, with its steel"""

    bl_idname = "mesh.togishi_katana_add"
    bl_label = "Add Katana"
    bl_options = {"REGISTER", "UNDO"}

    with_pattern: BoolProperty(
        name="Steel pattern",
        description="Also make the maps of hamon, hada and polish; they can be made again with other styles later",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allowed(cls, (context.mode == "OBJECT", NEEDS_OBJECT_MODE))

    def draw(self, _context: bpy.types.Context) -> None:
        self.draw_dimensions(self.layout)
        self.layout.prop(self, "with_pattern")

    def execute(self, context: bpy.types.Context) -> set[str]:
        core = native.core()
        try:
            parameters = self.parameters()
            katana = blade_object.make(parameters, self.detail)
        except core.InputError as error:
            self.report({"ERROR"}, f"No blade was made: {error}")
            return {"CANCELLED"}
        label = preset(self.preset).label
        obj = blade_object.new_object(context.scene, label, katana, parameters, self.detail)
        obj.location = context.scene.cursor.location
        material = blade_object.new_material(f"{label} steel")
        obj.data.materials.append(material)
        if self.with_pattern:
            pattern_baking.bake_now(material, json.loads(obj.togishi.katana_json))
        context.collection.objects.link(obj)
        blade_object.select_only(context, obj)
        return {"FINISHED"}


def _generated(context: bpy.types.Context) -> bpy.types.Object | None:
    """The blade that the panels show, where it remembers its dimensions."""
    blade = blade_object.find_blade(context)
    return blade if blade is not None and blade.togishi.katana_json else None


def _first_blade(tries: list[dict[str, Any]], detail: float) -> tuple[dict[str, Any], Any]:
    """The first parameters that make a blade, and the blade. Raises the last one's InputError."""
    *others, last = tries
    for parameters in others:
        with contextlib.suppress(native.core().InputError):
            return parameters, blade_object.make(parameters, detail)
    return last, blade_object.make(last, detail)


class TOGISHI_OT_katana_edit(KatanaDimensions, bpy.types.Operator):
    """Make the mesh of this generated blade anew with other dimensions. Materials by part and maps stay; what was
    modelled by hand, vertex groups and other attributes are lost"""

    bl_idname = "object.togishi_katana_edit"
    bl_label = "Edit Katana"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = _generated(context)
        return allowed(
            cls,
            (obj, "Needs a blade that was made by 'Add Katana'"),
            (obj is None or local(obj, obj.data), LINKED),
            (
                obj is None or obj.data.shape_keys is None,
                "This blade has shape keys, which a new mesh would lose; remove them first",
            ),
            (context.mode == "OBJECT", NEEDS_OBJECT_MODE),
        )

    def draw(self, _context: bpy.types.Context) -> None:
        self.draw_dimensions(self.layout)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = _generated(context)
        assert obj is not None
        # What an earlier edit chose is no choice for this blade.
        self.properties.property_unset("preset")
        _take(self, json.loads(obj.togishi.katana_json))
        self.detail = obj.togishi.detail
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        core = native.core()
        obj = _generated(context)
        assert obj is not None
        parameters = json.loads(obj.togishi.katana_json)
        touched = self.properties.is_property_set
        shown = ("sori_type", "mune", *(row[0] for row in DIMENSIONS))
        # Dimensions that no field shows belong to the preset and the zukuri.
        if touched("preset"):
            parameters = preset_parameters(self.preset)
        parameters |= {key: getattr(self, key) for key in shown if touched(key)}
        tries = [parameters]
        if touched("zukuri") and self.zukuri != parameters["zukuri"]:
            # The new zukuri's own where they go with what is shown, else the old blade's.
            defaults = core.katana_defaults(self.zukuri)
            parameters["zukuri"] = self.zukuri
            tries.insert(0, {**defaults, **{key: parameters[key] for key in shown}})
        detail = self.detail if touched("detail") else obj.togishi.detail
        try:
            parameters, katana = _first_blade(tries, detail)
        except core.InputError as error:
            self.report({"ERROR"}, f"The blade was left as it is: {error}")
            return {"CANCELLED"}
        slots = blade_object.slot_of_part(obj.data)
        obj.data.clear_geometry()
        blade_object.fill_mesh(obj.data, katana, context.scene.unit_settings.scale_length or 1.0)
        blade_object.set_slots(obj.data, slots)
        # Linked duplicates share the mesh, and with it the recipe.
        for other in bpy.data.objects:
            if other.data == obj.data:
                blade_object.remember(other, parameters, detail)
        return {"FINISHED"}


def _menu(self: Any, _context: bpy.types.Context) -> None:
    self.layout.operator(TOGISHI_OT_katana_add.bl_idname, text="Katana", icon="MESH_PLANE")


CLASSES = (TOGISHI_OT_katana_add, TOGISHI_OT_katana_edit)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.VIEW3D_MT_mesh_add.append(_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_mesh_add.remove(_menu)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
