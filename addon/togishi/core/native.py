"""The native module, loaded when it is first needed.

Users of native add-ons know four failures: the module is not there for this Python, a library it
needs does not load, an older copy is still installed, or one is still in memory. Each must leave the extension enabled and
able to say in one sentence what is wrong and what to do.
"""

from __future__ import annotations

import importlib
import sys
import tomllib
from functools import cache
from pathlib import Path
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
    "pack_normal_atlas",
    "ray_tree",
    "katana",
    "katana_defaults",
    "steel_pattern",
    "steel_defaults",
    "encode_lobe",
    "fit_scans",
    "fit_pictures",
    "capture_diffuse",
    "capture_lights",
    "capture_project",
)


class CoreMissingError(RuntimeError):
    """The native module cannot be used. The message says why and what to do."""


def addon_version() -> str:
    """This add-on's version, from its manifest."""
    manifest = Path(__file__).resolve().parents[1] / "blender_manifest.toml"
    return str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])


def _installed_build(module: ModuleType) -> str:
    """What lies on disk where the module was loaded from: the name of its wheel's record, which holds a hash of the
    content. "" where it came from no wheel."""
    file = getattr(module, "__file__", None)
    if file is None:
        return ""
    return ", ".join(sorted(path.name for path in Path(file).parent.glob("togishi_core-*-info")))


def _stale(module: ModuleType) -> str:
    """Why the module is not the one that belongs to this add-on, or ""."""
    version = getattr(module, "__version__", "unknown")
    build = _installed_build(module)
    # A loaded library stays in memory until Blender ends, whatever is installed meanwhile. The module outlives
    # this add-on's own modules, so it keeps what it was loaded from.
    if not hasattr(module, "_togishi_loaded_from"):
        module._togishi_loaded_from = build  # type: ignore[attr-defined]
    if module._togishi_loaded_from != build:
        return (
            f"Togishi was installed anew while Blender was running, and its native module is still "
            f"the earlier one ({version}). Restart Blender."
        )
    own = addon_version()
    missing = [name for name in REQUIRED if not hasattr(module, name)]
    if version != own or missing:
        lacks = f"; it lacks {missing[0]}" if missing else ""
        return (
            f"Togishi's native module is from another version ({version}; the add-on is {own}{lacks}). "
            "Remove the extension, restart Blender, then install it again."
        )
    return ""


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
    except (ImportError, OSError, SystemError) as error:
        return None, (
            f"Togishi's native module does not load in Python {python}: {error}. "
            "Remove the extension, restart Blender, then install the package made for this platform."
        )
    stale = _stale(module)
    if stale:
        return None, stale
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
