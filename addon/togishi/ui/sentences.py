"""Sentences in panels: Blender cuts a label that is too long, so they are broken into lines that fit."""

from __future__ import annotations

from functools import lru_cache

import blf
import bpy

# Of a region's width, in px at scale 1: margins of panel and box, scroll bar, the sidebar's tabs; an icon.
_MARGIN_PX = 72
_ICON_PX = 22
_FALLBACK_PX = 240  # where there is no region: without a window


@lru_cache(maxsize=256)
def _lines(text: str, width_px: float, size_px: float) -> tuple[str, ...]:
    """`text` in lines of at most that width in Blender's own font; a longer word stands alone."""
    blf.size(0, size_px)
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and blf.dimensions(0, longer)[0] <= width_px:
            lines[-1] = longer
        else:
            lines.append(word)
    return tuple(lines)


def draw_sentence(layout: bpy.types.UILayout, text: str, icon: str = "NONE") -> None:
    """Draw all of `text`, in as many lines as the region asks for; the icon stands before the first."""
    preferences = bpy.context.preferences
    scale = preferences.system.ui_scale or 1.0
    region = bpy.context.region
    width_px = region.width if region is not None else _FALLBACK_PX * scale
    width_px -= (_MARGIN_PX + (_ICON_PX if icon != "NONE" else 0)) * scale
    column = layout.column(align=True)
    column.scale_y = 0.8  # lines of one sentence
    size_px = preferences.ui_styles[0].widget.points * scale
    for index, line in enumerate(_lines(text, width_px, size_px)):
        column.label(text=line, icon="BLANK1" if index and icon != "NONE" else icon)
