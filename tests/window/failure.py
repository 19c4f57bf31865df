"""What a user sees where the native module does not load: the extension is enabled, and its panel says why and
what to do. Three ways in which it happens: a library that cannot be loaded, an older copy, none at all.

    blender --factory-startup --enable-event-simulate --python failure.py -- --zip Z --out DIR --console FILE
"""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import screen
from console import Console, options
from screen import Steps

EXTENSION = "bl_ext.user_default.togishi"
OPTIONS = options()


def need(condition: bool, sentence: str) -> None:
    if not condition:
        raise AssertionError(sentence)


def leave() -> None:
    """As if Blender had been ended. Disabling it in Blender would take the wheel off the disk."""
    sys.modules[EXTENSION].unregister()
    for loaded in [key for key in sys.modules if key.startswith((EXTENSION, "togishi_core"))]:
        del sys.modules[loaded]


def break_library(library: Path) -> None:
    library.write_bytes(b"\x7fELF" + bytes(60))


def break_version(library: Path) -> None:
    library.unlink()
    (library.parent / "togishi_core.py").write_text(
        "__version__ = '0.0.1'\nInputError = ValueError\n"
    )


def break_all(library: Path) -> None:
    library.unlink(missing_ok=True)
    (library.parent / "togishi_core.py").unlink(missing_ok=True)


# name of the picture, what is done to the library, words of the sentence
WAYS = (
    ("failure_library", break_library, ("does not load", "restart Blender")),
    ("failure_stale", break_version, ("another version (0.0.1", "install it again")),
    ("failure_missing", break_all, ("not installed for Python", "install the package")),
)


def failures() -> Steps:
    bpy.ops.extensions.package_install_files(
        filepath=str(OPTIONS.zip), repo="user_default", enable_on_install=True
    )
    user = Path(os.environ["BLENDER_USER_RESOURCES"])
    (library,) = user.rglob("togishi_core*.so")
    shots = screen.Shots(OPTIONS.out)
    view = screen.areas("VIEW_3D")[0]
    for name, damage, words in WAYS:
        leave()
        damage(library)
        importlib.invalidate_caches()
        importlib.import_module(EXTENSION).register()
        native = importlib.import_module(f"{EXTENSION}.core.native")
        sentence = native.problem()
        for word in words:
            need(word in sentence, f"{name}: {word!r} is not in {sentence!r}")
        view.spaces.active.show_region_ui = True
        yield 0.6
        screen.region_of(view, "UI").active_panel_category = "Togishi"
        # The engine can be chosen, and says the same in the view.
        bpy.context.scene.render.engine = "TOGISHI"
        view.spaces.active.shading.type = "RENDERED"
        yield 1.0
        yield from shots.everything(name)
        need(not bpy.ops.mesh.togishi_katana_add.poll(), f"{name}: a blade could be added")
        view.spaces.active.shading.type = "SOLID"
        bpy.context.scene.render.engine = "BLENDER_EEVEE_NEXT"
        yield 0.3
    leave()


def main() -> None:
    console = Console(OPTIONS.console)

    def ended(error: BaseException | None) -> None:
        if error is not None:
            traceback.print_exception(error)
        found = console.new_problems()
        if error is not None or found:
            sys.stdout.flush()
            os._exit(1)
        bpy.ops.wm.quit_blender()

    screen.run_in_window(failures(), ended)


main()
