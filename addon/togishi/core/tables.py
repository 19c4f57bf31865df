"""Rows of the tables that the programs look colours up in, made when they are first asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from . import native
from .scene_data import F32, ColourSettings
from .shader_source import TABLE_SIZE

# Baking one row takes tens of microseconds, so only the rows of recent lights are kept: dragging a
# temperature makes a new spectrum at every step.
_KEPT = 256

Stamp = tuple[int, int] | None  # time of change in ns and size of a file; None: it is not there


def _file_of(name: str) -> Path | None:
    """The user's file behind a spectrum or a metal; None for built-in ones."""
    path = name.removeprefix("csv:")
    return Path(path) if path != name or "/" in name or "\\" in name else None


def _stamp(file: Path) -> Stamp:
    try:
        status = file.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


class Tables:
    """Fresnel rows by (metal, light, colour settings), and the plain rows that are the light's RGB."""

    def __init__(self) -> None:
        self._rows: dict[tuple[str, str, ColourSettings], F32] = {}
        self._stamps: dict[str, Stamp] = {}
        self.baked = 0
        self.version = 0  # rises when rows were forgotten
        self.problems: dict[
            str, str
        ] = {}  # spectrum or metal -> why it was replaced by D65 or the default iron

    def refresh(self) -> None:
        """Forget what was made from files that have changed since: a spectrum that was repaired applies at the next
        picture."""
        changed = {
            name
            for name, stamp in self._stamps.items()
            if (file := _file_of(name)) is not None and _stamp(file) != stamp
        }
        if not changed:
            return
        self._rows = {
            k: row for k, row in self._rows.items() if not changed & {k[0], k[1], k[2].white}
        }
        for name in changed:
            del self._stamps[name]
            self.problems.pop(name, None)
        self.version += 1

    def rows(self, metal: str, spectra: Sequence[str], colour: ColourSettings) -> list[F32]:
        """(TABLE_SIZE, 3) for each spectrum. metal "": rows of the light itself."""
        return [self._row(metal, spectrum, colour) for spectrum in spectra]

    def light_rgb(self, spectrum: str, colour: ColourSettings) -> tuple[float, float, float]:
        """The light itself in RGB, luminance 1."""
        red, green, blue = (float(v) for v in self._row("", spectrum, colour)[0])
        return red, green, blue

    def _row(self, metal: str, spectrum: str, colour: ColourSettings) -> F32:
        key = (metal, spectrum, colour)
        row = self._rows.get(key)
        if row is None:
            for name in (metal, spectrum, colour.white):
                # Before the file is read: a change in between is then seen.
                if name not in self._stamps and (file := _file_of(name)) is not None:
                    self._stamps[name] = _stamp(file)
            row = self._bake(metal, spectrum, colour)
            while len(self._rows) >= _KEPT:
                del self._rows[next(iter(self._rows))]
            self._rows[key] = row
            self.baked += 1
        return row

    def _bake(self, metal: str, spectrum: str, colour: ColourSettings) -> F32:
        core = native.core()
        row: F32
        if colour.white and colour.adaptation != "none":
            # One white for everything: what each light and its metal give is adapted as one colour.
            row = self._row(metal, spectrum, replace(colour, adaptation="none", white=""))
            return np.ascontiguousarray(row @ self._adaptation(colour).T, np.float32)
        try:
            if metal:
                row = core.fresnel_table(
                    metal, spectrum, colour.observer, colour.space, TABLE_SIZE, colour.adaptation
                )
                return row
            rgb = core.light_rgb(spectrum, colour.observer, colour.space, colour.adaptation)
            return np.tile(np.asarray(rgb, np.float32), (TABLE_SIZE, 1))
        except core.InputError as error:
            # A picture in daylight or of iron says more than none; the message goes to the user.
            if spectrum != "D65":
                self.problems[spectrum] = str(error)
                return self._row(metal, "D65", colour)
            default = str(core.metals()[0]["name"])
            if metal not in ("", default):
                self.problems[metal] = str(error)
                return self._row(default, spectrum, colour)
            raise

    def _adaptation(self, colour: ColourSettings) -> F32:
        core = native.core()
        try:
            matrix = core.adapt_rgb(colour.white, colour.observer, colour.space, colour.adaptation)
            return np.asarray(matrix, np.float32)
        except core.InputError as error:
            self.problems[colour.white] = str(error)
            return np.eye(3, dtype=np.float32)
