"""What differs between the Blender versions that Togishi is tested on: one row each. addon/togishi/blender_versions.py
is the one module of the add-on that knows these differences; the tests hold it to this table. Imports no Blender."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class BlenderVersion:
    version: tuple[int, int]
    python: tuple[int, int]
    environment: (
        str  # with bpy, from the checkout's root; "" where only a window's Blender is at hand
    )
    eevee: str  # the engine's identifier
    light_temperature: (
        bool  # lights have a temperature, an exposure and a normalisation of their own
    )
    custom_normals: bool  # a mesh keeps custom normals as floats
    relative_path_option: bool  # properties of paths say whether they may be relative
    working_spaces: bool  # a file chooses its scene-linear space
    media_type: bool  # a file format's kind of medium is chosen before it
    action_curves: bool  # actions hold their curves without slots and channel bags
    gpu_init: bool  # a GPU context is made on request

    @property
    def label(self) -> str:
        return ".".join(map(str, self.version))

    @property
    def python_label(self) -> str:
        return ".".join(map(str, self.python))

    @property
    def interpreter(self) -> Path:
        return ROOT / self.environment / "bin/python"

    @property
    def module(self) -> Path | None:
        """The native module that `make core` or `make core-5.2` put into this version's environment."""
        pattern = f"lib/python{self.python_label}/site-packages/togishi_core*.so"
        return next((ROOT / self.environment).glob(pattern), None) if self.environment else None

    @property
    def openimageio(self) -> Path:
        """PyPI's openimageio for this version's Python (tools/setup_openimageio.sh)."""
        return ROOT / ".venv-openimageio" / self.python_label


VERSIONS = (
    # Debian trixie's build, on Debian's own Python. In its window: tools/test_window.sh.
    BlenderVersion(
        (4, 3),
        (3, 13),
        environment="",
        eevee="BLENDER_EEVEE_NEXT",
        light_temperature=False,
        custom_normals=False,
        relative_path_option=False,
        working_spaces=False,
        media_type=False,
        action_curves=True,
        gpu_init=False,
    ),
    BlenderVersion(
        (4, 5),
        (3, 11),
        environment=".venv",
        eevee="BLENDER_EEVEE_NEXT",
        light_temperature=True,
        custom_normals=True,
        relative_path_option=True,
        working_spaces=False,
        media_type=False,
        action_curves=True,
        gpu_init=False,
    ),
    BlenderVersion(
        (5, 2),
        (3, 13),
        environment=".venv-5.2",
        eevee="BLENDER_EEVEE",
        light_temperature=True,
        custom_normals=True,
        relative_path_option=True,
        working_spaces=True,
        media_type=True,
        action_curves=False,
        gpu_init=True,
    ),
)
WHEELS = tuple(row for row in VERSIONS if row.environment)
"""The versions that are at hand as bpy, without a window."""


def row_of(version: tuple[int, ...]) -> BlenderVersion:
    """The row of `bpy.app.version`. Raises LookupError where the table lacks it."""
    for row in VERSIONS:
        if row.version == tuple(version[:2]):
            return row
    known = ", ".join(row.label for row in VERSIONS)
    raise LookupError(f"Blender {version} is not in the table of versions, which has {known}")
