"""Sentences in panels are whole: Blender would cut a label that is wider than its region."""

from __future__ import annotations

import bpy
import pytest
from ui_fixtures import addon  # noqa: F401

SENTENCE = (
    "It does not load: /home/a.name/blender/extensions/togishi_core.so: wrong ELF class; remove"
)


class Layout:
    def __init__(self):
        self.rows = []

    def column(self, **_options):
        return self

    def split(self, **options):
        self.factors = [*getattr(self, "factors", []), options["factor"]]
        return self

    def label(self, text, icon="NONE"):
        self.rows.append((text, icon))


@pytest.mark.parametrize("width_px", [1, 60, 150, 400, 4000])
def test_lines_fit_and_lose_nothing(addon, width_px):  # noqa: F811
    from togishi.ui import sentences

    lines = sentences._lines(SENTENCE, width_px, 11.0)
    assert "".join(lines).replace(" ", "") == SENTENCE.replace(" ", "")
    assert width_px < 400 or " ".join(lines) == SENTENCE
    sentences.blf.size(0, 11.0)
    assert all(
        " " not in line or sentences.blf.dimensions(0, line)[0] <= width_px for line in lines
    )
    assert (len(lines) == 1) == (width_px == 4000)


def test_the_icon_stands_before_the_first_line_only(addon):  # noqa: F811
    from togishi.ui import sentences

    assert bpy.app.background
    layout = Layout()
    sentences.draw_sentence(layout, SENTENCE, "ERROR")
    said = "".join(text for text, _icon in layout.rows)
    assert said.replace(" ", "") == SENTENCE.replace(" ", "")
    assert [icon for _text, icon in layout.rows] == ["ERROR"] + ["BLANK1"] * (len(layout.rows) - 1)
    assert len(layout.rows) > 2
    plain = Layout()
    sentences.draw_sentence(plain, SENTENCE)
    assert {icon for _text, icon in plain.rows} == {"NONE"}


def test_pairs_have_columns_where_they_fit(addon):  # noqa: F811
    from togishi.ui import sentences

    short = Layout()
    sentences.draw_pairs(short, [("χ", "269 1/sr", True), ("μ wide", "not determined", False)])
    assert [text for text, _icon in short.rows] == ["χ", "269 1/sr", "μ wide", "not determined"]
    assert len(set(short.factors)) == 1 and 0.1 < short.factors[0] < 0.9
    long = Layout()
    sentences.draw_pairs(long, [("Out of plane", "0.00012345 ± 0.00012345 °", False)])
    assert not hasattr(long, "factors")
    assert " ".join(text for text, _icon in long.rows) == "Out of plane: 0.00012345 ± 0.00012345 °"
    assert long.rows[0][1] == "ERROR"
