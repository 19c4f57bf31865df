"""Node groups for Cycles and EEVEE; they follow edits of their material."""

from __future__ import annotations

from .. import properties
from . import steel_group


def register() -> None:
    properties.material_edited.append(steel_group.refresh)


def unregister() -> None:
    properties.material_edited.remove(steel_group.refresh)
