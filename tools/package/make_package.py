"""Makes the extension that users drag into Blender: dist/togishi-<version>-linux_x64.zip.

    make_package.py --tools .venv-package --python 3.11=/usr/bin/python3.11 --python 3.13=…   compiles the modules
    make_package.py --module …/togishi_core.cpython-311-x86_64-linux-gnu.so        takes compiled ones
    make_package.py --installed                                                    takes those of `make core` and `make core-5.2`

The same commit makes the same bytes wherever the checkout lies, given the same Debian and the same Pythons. Prints its
path. Exit code 0: made and validated; 1: not; 2: wrong usage.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from compile_module import ALLOWED_LIBRARIES, GLIBC, CompileError, Toolchain, compile_module
from elf import needs
from extension import MANIFEST, ExtensionError, blender_validators, validate, write_extension
from wheel import write_wheel

ROOT = Path(__file__).resolve().parents[2]


def say(text: str) -> None:
    """As tools/say.sh does; standard output is for the package's path alone."""
    print(f"\033[1m[togishi]\033[0m {text}", file=sys.stderr, flush=True)


def commit_epoch_s() -> int:
    """The date of everything in the package: $SOURCE_DATE_EPOCH, or the last commit's."""
    if text := os.environ.get("SOURCE_DATE_EPOCH"):
        if not text.isdecimal():
            raise ExtensionError(f"SOURCE_DATE_EPOCH={text!r}: it must be seconds since 1970")
        return int(text)
    done = subprocess.run(
        ["git", "log", "-1", "--format=%ct"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise ExtensionError(
            "this is no git checkout, so the package has no date; set SOURCE_DATE_EPOCH to one"
        )
    return int(done.stdout)


def warn_of_changes() -> None:
    done = subprocess.run(
        ["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.stdout.strip():
        say("note: the checkout has changes that are not committed; the package has them too")


def compiled(options: argparse.Namespace, epoch_s: int) -> list[Path]:
    """The modules for all Pythons asked for."""
    folder = options.work / options.compiler
    chain = Toolchain(ROOT, options.tools, folder, options.compiler, epoch_s)
    modules = []
    for step, (version, python) in enumerate(options.python, 1):
        say(f"[{step}/{len(options.python)}] compiling for Python {version} with {chain.compiler}")
        made = compile_module(chain, python, version)
        kept = options.work / "modules" / made.name
        kept.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(made, kept)
        check_module(kept, python, chain.compiler)
        modules.append(kept)
    return modules


def check_module(module: Path, python: Path, compiler: str) -> None:
    """It must load in its Python, and with zig wherever Blender does."""
    asks = needs(module)
    if compiler == "zig":
        foreign = asks.libraries - ALLOWED_LIBRARIES
        if asks.glibc > GLIBC or foreign:
            raise CompileError(
                f"{module.name} asks for glibc {asks.glibc[0]}.{asks.glibc[1]} and {sorted(asks.libraries)}; "
                f"allowed are glibc {GLIBC[0]}.{GLIBC[1]} and {sorted(ALLOWED_LIBRARIES)}"
            )
    done = subprocess.run(
        [str(python), "-c", "import togishi_core; print(togishi_core.__version__)"],
        env={**os.environ, "PYTHONPATH": str(module.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise CompileError(f"{module.name} does not load in {python}: {done.stderr.strip()}")


def python_option(text: str) -> tuple[str, Path]:
    version, _, path = text.partition("=")
    if not path:
        raise argparse.ArgumentTypeError(
            f"{text!r}; it must be VERSION=PATH, as 3.11=/usr/bin/python3.11"
        )
    return version, Path(path)


def installed_modules() -> list[Path]:
    found = sorted(ROOT.glob(".venv*/lib/python*/site-packages/togishi_core*.so"))
    if not found:
        raise ExtensionError("togishi_core is not installed in .venv: run 'make core'")
    return found


def make(options: argparse.Namespace) -> Path:
    """Compiles or takes the modules, packs and validates them; returns the zip's path."""
    manifest = tomllib.loads((ROOT / "addon/togishi" / MANIFEST).read_text(encoding="utf-8"))
    version = options.version or manifest["version"]
    epoch_s = commit_epoch_s()
    if options.python:
        modules = compiled(options, epoch_s)
    else:
        modules = installed_modules() if options.installed else options.module
    stub = ROOT / "cpp_core/python/togishi_core.pyi"
    warn_of_changes()
    with tempfile.TemporaryDirectory() as folder:
        wheels = [write_wheel(module, stub, version, Path(folder), epoch_s) for module in modules]
        zip_path = write_extension(ROOT, wheels, options.out, epoch_s, options.version)
        tags = ", ".join(sorted(" ".join(wheel.stem.split("-")[-2:]) for wheel in wheels))
    validators = blender_validators(ROOT)
    if not validators:
        raise ExtensionError(
            "there is no bpy in .venv to validate the package with: run 'make setup'"
        )
    for validator in validators:
        validate(zip_path, validator)
    size_mb = zip_path.stat().st_size / 1e6
    say(f"{size_mb:.2f} MB, valid for {len(validators)} Blender versions; wheels: {tags}")
    return zip_path


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    modules = parser.add_mutually_exclusive_group(required=True)
    add = modules.add_argument
    add("--python", type=python_option, action="append", metavar="VERSION=PATH")
    add("--module", type=Path, action="append", metavar="FILE.so")
    add("--installed", action="store_true")
    add = parser.add_argument
    add("--compiler", default="zig", help="zig, or g++ of this machine: for no older ones")
    add("--tools", type=Path, default=ROOT / ".venv-package", help="has ziglang and pybind11")
    add("--work", type=Path, default=ROOT / "build/package", help="folder to compile in")
    add("--out", type=Path, default=ROOT / "dist", help="folder of the zip")
    add("--version", help="another version than the manifest's (for tests)")
    options = parser.parse_args()
    try:
        print(make(options))
    except (CompileError, ValueError, OSError) as error:
        print(f"\033[1m[togishi] no package was made: {error}\033[0m", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
