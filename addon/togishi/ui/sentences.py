"""Sentences in panels: Blender cuts a label that is too long, so they are broken into lines that fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import blf
import bpy

# Of a region's width, in px at scale 1: margins of panel and box, scroll bar, the sidebar's tabs; an icon.
_MARGIN_PX = 72
_ICON_PX = 22
_FALLBACK_PX = 240  # where there is no region: without a window


def _pieces(word: str, width_px: float) -> Iterator[str]:
    """A word that is wider than a line, such as a path, in pieces that are not."""
    while len(word) > 1 and blf.dimensions(0, word)[0] > width_px:
        count = len(word) - 1
        while count > 1 and blf.dimensions(0, word[:count])[0] > width_px:
            count -= 1
        yield word[:count]
        word = word[count:]
    yield word


@lru_cache(maxsize=256)
def _lines(text: str, width_px: float, size_px: float) -> tuple[str, ...]:
    """`text` in lines of at most that width in Blender's own font."""
    blf.size(0, size_px)
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and blf.dimensions(0, longer)[0] <= width_px:
            lines[-1] = longer
        else:
            lines.extend(_pieces(word, width_px))
    return tuple(lines)


def _space_px(icon: str) -> tuple[float, float]:
    """How wide a line may be beside an icon, and how large its letters are, both in px."""
    preferences = bpy.context.preferences
    scale = preferences.system.ui_scale or 1.0
    region = bpy.context.region
    width_px = region.width if region is not None else _FALLBACK_PX * scale
    width_px -= (_MARGIN_PX + (_ICON_PX if icon != "NONE" else 0)) * scale
    return width_px, preferences.ui_styles[0].widget.points * scale


def draw_pairs(layout: bpy.types.UILayout, rows: Sequence[tuple[str, str, bool]]) -> None:
    """Names and values in two columns where both fit, else a line each. False: the row is warned of."""
    width_px, size_px = _space_px("NONE")
    blf.size(0, size_px)
    # A label keeps some space around its text.
    name_px = size_px + max(blf.dimensions(0, name)[0] for name, _value, _good in rows)
    value_px = size_px + max(blf.dimensions(0, value)[0] for _name, value, _good in rows)
    column = layout.column(align=True)
    for name, value, good in rows:
        if name_px + value_px > width_px:
            draw_sentence(column, f"{name}: {value}", "NONE" if good else "ERROR")
            continue
        split = column.split(factor=name_px / width_px, align=True)
        split.alert = not good
        split.label(text=name)
        split.label(text=value)


def draw_sentence(layout: bpy.types.UILayout, text: str, icon: str = "NONE") -> None:
    """Draw all of `text`, in as many lines as the region asks for; the icon stands before the first."""
    width_px, size_px = _space_px(icon)
    column = layout.column(align=True)
    column.scale_y = 0.8  # lines of one sentence
    for index, line in enumerate(_lines(text, width_px, size_px)):
        column.label(text=line, icon="BLANK1" if index and icon != "NONE" else icon)
