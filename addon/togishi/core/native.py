"""The native module, loaded when it is first needed.

Users of native add-ons know three failures: the module is not there for this Python, a library it
needs does not load, or an older copy is still installed. Each must leave the extension enabled and
able to say in one sentence what is wrong and what to do.
"""

from __future__ import annotations

import importlib
import sys
from functools import cache
from types import ModuleType

# What the add-on uses of the module; an older module lacks some of them.
REQUIRED = (
    "InputError",
    "metals",
    "lights",
    "fresnel_table",
    "default_material",
    "material_to_toml",
    "load_material",
    "pack_mip_atlas",
    "katana",
    "katana_defaults",
    "steel_pattern",
    "steel_defaults",
    "encode_lobe",
)


class CoreMissingError(RuntimeError):
    """The native module cannot be used. The message says why and what to do."""


@cache
def _load() -> tuple[ModuleType | None, str]:
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    try:
        module = importlib.import_module("togishi_core")
    except ModuleNotFoundError as error:
        if error.name != "togishi_core":
            return None, (
                f"Togishi's native module needs the Python module {error.name!r}, which this Blender "
                "does not have. Install the official Blender build, then restart it."
            )
        return None, (
            f"Togishi's native module (togishi_core) is not installed for Python {python}. "
            "Remove the extension, install the package made for this platform, then restart Blender."
        )
    except ImportError as error:
        return None, (
            f"Togishi's native module does not load in Python {python}: {error}. "
            "Remove the extension, restart Blender, then install the package made for this platform."
        )
    missing = [name for name in REQUIRED if not hasattr(module, name)]
    if missing:
        version = getattr(module, "__version__", "unknown")
        return None, (
            f"Togishi's native module is from another version ({version}; it lacks {missing[0]}). "
            "Remove the extension, restart Blender, then install it again."
        )
    return module, ""


def problem() -> str:
    """A sentence that says why the module cannot be used and what to do, or "" when all is well."""
    return _load()[1]


def core() -> ModuleType:
    """The module togishi_core. Raises CoreMissingError with `problem()` as its message."""
    module, reason = _load()
    if module is None:
        raise CoreMissingError(reason)
    return module


def forget() -> None:
    """Try the import again at the next call (after an installation, and in tests)."""
    _load.cache_clear()
