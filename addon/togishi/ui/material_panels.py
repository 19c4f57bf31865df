"""The blade material in the Properties editor."""

from __future__ import annotations

import bpy

from .. import bake_cost_cache, map_images, properties
from ..core import native
from ..core.blade_lobes import part_aspects
from ..nodes import steel_group
from ..nodes.lobe_nodes import MAX_ASPECT
from .sentences import draw_sentence


def _lobe_row(layout: bpy.types.UILayout) -> tuple[bpy.types.UILayout, bpy.types.UILayout]:
    """Where a part's name stands, and its numbers in three columns."""
    split = layout.split(factor=0.3, align=True)
    return split.column(), split.row(align=True)


def draw_lobe_header(layout: bpy.types.UILayout) -> None:
    name_part, numbers = _lobe_row(layout)
    name_part.label(text="Degrees")
    # A row would share the width out by the texts' lengths, and they would stand beside their columns.
    columns = numbers.grid_flow(row_major=True, columns=3, even_columns=True, align=True)
    for text in ("μ wide", "narrow", "ρ"):
        cell = columns.row()
        cell.alignment = "CENTER"
        cell.label(text=text)


def draw_lobe(
    layout: bpy.types.UILayout,
    settings: properties.TogishiMaterial,
    name: str,
    label: str,
    constant: str,
) -> None:
    lobe = getattr(settings, name)
    column = layout.column(align=True)
    name_part, numbers = _lobe_row(column)
    name_part.label(text=label)
    for field in ("mu_t_deg", "mu_b_deg", "rho_deg"):
        numbers.prop(lobe, field, text="")
    if settings.weights == "measured" and constant:
        column.prop(lobe, "weight", text="χ (1/sr)" if constant == "chi" else "β (1/sr)")


def draw_steel(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    settings = material.togishi
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "metal_choice")
    if settings.metal == properties.FILE_CHOICE:
        layout.prop(settings, "metal_path")
        if not settings.metal_path:
            layout.label(text="No file is chosen: iron is used", icon="ERROR")
    layout.prop(settings, "weights")
    row = layout.row(align=True)
    row.operator("material.togishi_load", text="Load…", icon="FILE_FOLDER")
    row.operator("material.togishi_save", text="Save…", icon="FILE_TICK")


def draw_maps(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    settings = material.togishi
    pattern = settings.pattern
    layout.use_property_split = True
    layout.use_property_decorate = False
    for name in ("hamon", "boshi", "hada", "seed"):
        layout.prop(pattern, name)
    row = layout.row(align=True)
    row.prop(pattern, "width_px", text="Texels")
    row.prop(pattern, "height_px", text="")
    layout.operator("material.togishi_pattern_bake", icon="RENDER_STILL")
    if settings.lobes_image is not None:
        box = layout.box()
        box.label(text=f"Lobes: {map_images.summary(settings.lobes_image)}", icon="TEXTURE")
        if settings.shape_image is not None:
            box.label(text=f"Shape: {map_images.summary(settings.shape_image)}", icon="TEXTURE")
    row = layout.row(align=True)
    row.operator("material.togishi_maps_import", text="Import…")
    row.operator("material.togishi_maps_export", text="Export…")
    row.operator("material.togishi_maps_clear", text="", icon="X")


def draw_normal_map(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    settings = material.togishi
    image = settings.normal_image
    layout.template_ID(settings, "normal_image", open="image.open")
    if image is None:
        return
    if not image.colorspace_settings.is_data:
        draw_sentence(layout, "Set the image's colour space to Non-Color", "ERROR")
    elif image.depth and image.depth <= 32 and not image.is_float:
        draw_sentence(layout, "8 bits: steps of half a degree show on polished steel", "INFO")


def draw_nodes(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    settings = material.togishi
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "node_spectrum")
    column = layout.column(align=True)
    column.operator("material.togishi_nodes_connect", text="Bake", icon="NODETREE")
    column.operator("material.togishi_nodes_bake_for_scene", text="Bake for the Scene's Light")
    if not steel_group.has_groups(material):
        return
    costs = bake_cost_cache.read(material)
    column = layout.column(align=True)
    if costs is None:
        draw_sentence(column, "Bake to see what one light's colours cost under others", "INFO")
    else:
        draw_sentence(column, "Worst ΔE00 under other lights:")
        grid = column.grid_flow(columns=2, even_columns=True)
        for name, cost in costs.items():
            cell = grid.row()
            cell.alert = cost > 1.0  # what an eye may see
            cell.label(text=f"{name}: {cost:.2f}")
    if (
        settings.shape_image is None
        and max(part_aspects(properties.material_dict(material)).values()) > MAX_ASPECT
    ):
        draw_sentence(layout, "EEVEE shows lobes longer than 10:1 wider than they are", "ERROR")


class _MaterialPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not native.problem() and properties.is_blade(context.material)


class TOGISHI_PT_material(bpy.types.Panel):
    bl_label = "Togishi Steel"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not native.problem() and context.material is not None

    def draw_header(self, context: bpy.types.Context) -> None:
        if properties.is_blade(context.material):
            self.layout.prop(context.material.togishi, "is_blade", text="")

    def draw(self, context: bpy.types.Context) -> None:
        if properties.is_blade(context.material):
            draw_steel(self.layout, context.material)
        else:
            self.layout.operator("material.togishi_make_steel", icon="MATERIAL")


class TOGISHI_PT_material_lobes(_MaterialPanel, bpy.types.Panel):
    bl_label = "Lobes per Part"
    bl_parent_id = "TOGISHI_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.material.togishi
        layout = self.layout
        if settings.lobes_image is not None:
            draw_sentence(
                layout, "The maps decide where there are maps: bake after a change", "INFO"
            )
        draw_lobe_header(layout)
        for name, label, constant in properties.LOBE_PARTS:
            draw_lobe(layout, settings, name, label, constant)
        layout.prop(settings, "nakago_albedo")
        layout.prop(settings, "nakago_ior")


class TOGISHI_PT_material_pattern(_MaterialPanel, bpy.types.Panel):
    bl_label = "Hamon and Hada"
    bl_parent_id = "TOGISHI_PT_material"

    def draw(self, context: bpy.types.Context) -> None:
        draw_maps(self.layout, context.material)


class TOGISHI_PT_material_pattern_more(_MaterialPanel, bpy.types.Panel):
    bl_label = "Details"
    bl_parent_id = "TOGISHI_PT_material_pattern"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        pattern = context.material.togishi.pattern
        for prop in pattern.bl_rna.properties:
            if prop.type == "FLOAT":
                layout.prop(pattern, prop.identifier)


class TOGISHI_PT_material_normal_map(_MaterialPanel, bpy.types.Panel):
    bl_label = "Normal Map"
    bl_parent_id = "TOGISHI_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        draw_normal_map(self.layout, context.material)


class TOGISHI_PT_material_nodes(_MaterialPanel, bpy.types.Panel):
    bl_label = "Cycles and EEVEE"
    bl_parent_id = "TOGISHI_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        draw_nodes(self.layout, context.material)


class TOGISHI_PT_material_source(_MaterialPanel, bpy.types.Panel):
    bl_label = "Source"
    bl_parent_id = "TOGISHI_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.material.togishi
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("title", "source", "licence"):
            layout.prop(settings, name)
        # The field above shows its beginning only.
        draw_sentence(
            layout, settings.source or "Where these values come from is not stated", "INFO"
        )


CLASSES = (
    TOGISHI_PT_material,
    TOGISHI_PT_material_lobes,
    TOGISHI_PT_material_pattern,
    TOGISHI_PT_material_pattern_more,
    TOGISHI_PT_material_normal_map,
    TOGISHI_PT_material_nodes,
    TOGISHI_PT_material_source,
)
