"""Why an operator cannot run now: Blender shows the sentence in the tooltip of the greyed-out button."""

from __future__ import annotations

import bpy

from ..core import native

# Library overrides keep none of the add-on's settings.
LINKED = "This blade is linked from another file; make it local to change it"
NEEDS_BLADE_MATERIAL = "Needs an object with a blade material; 'Assign Blade Material' gives one"
NEEDS_OBJECT_MODE = "Works in Object Mode only"


def local(*blocks: bpy.types.ID | None) -> bool:
    """Whether changes to these data-blocks are saved with this file."""
    return not any(block and (block.library or block.override_library) for block in blocks)


def editable(material: bpy.types.Material | None) -> tuple[tuple[object, str], ...]:
    """The conditions of every operator that changes a blade material."""
    return (material, NEEDS_BLADE_MATERIAL), (local(material), LINKED)


def allowed(cls: type[bpy.types.Operator], *conditions: tuple[object, str]) -> bool:
    """Whether the native module works and every condition holds; the first that does not has its sentence shown."""
    for holds, sentence in ((not native.problem(), native.problem()), *conditions):
        if not holds:
            cls.poll_message_set(sentence)
            return False
    return True
