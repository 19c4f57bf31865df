"""The extension's zip: the add-on with its shaders, wheels and licence texts."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

from fixed_zip import write_zip

MANIFEST = "blender_manifest.toml"
MAX_BYTES = 20_000_000


class ExtensionError(ValueError):
    """Something of which no extension can be made; the message says what."""


def source_files(root: Path, folder: str) -> dict[str, Path]:
    """The files below root/folder that git knows or would add, by their path below it; links are left out."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", "."]
    done = subprocess.run(command, cwd=root / folder, capture_output=True, check=False)
    if done.returncode != 0:
        raise ExtensionError(
            f"{root}: 'git ls-files' failed: {done.stderr.decode().strip()}. The package is made from a git checkout."
        )
    names = sorted(name for name in done.stdout.decode().split("\0") if name)
    paths = {name: root / folder / name for name in names}
    # A file that is deleted but not yet committed is still listed.
    return {name: path for name, path in paths.items() if path.is_file() and not path.is_symlink()}


def manifest_text(text: str, wheels: Sequence[str], version: str | None = None) -> str:
    """The manifest with its list of wheels, and its version where one is given."""
    listed = "".join(f'    "{name}",\n' for name in wheels)
    filled, found = re.subn(r"^wheels = \[\]$", f"wheels = [\n{listed}]", text, flags=re.MULTILINE)
    if found != 1:
        raise ExtensionError(f"{MANIFEST}: the line 'wheels = []' is there {found} times, not once")
    if version is not None:
        filled, found = re.subn(
            r'^version = ".*"$', f'version = "{version}"', filled, flags=re.MULTILINE
        )
        if found != 1:
            raise ExtensionError(f"{MANIFEST}: the line 'version = …' is there {found} times")
    tomllib.loads(filled)
    return filled


def write_extension(
    root: Path, wheels: Sequence[Path], out: Path, epoch_s: int, version: str | None = None
) -> Path:
    """Writes out/togishi-<version>-linux_x64.zip; returns its path. `version`: the source manifest's, or another."""
    files = {name: path.read_bytes() for name, path in source_files(root, "addon/togishi").items()}
    for name, path in source_files(root, "shaders").items():
        files[f"shaders/{name}"] = path.read_bytes()
    for name, path in source_files(root, "licenses").items():
        files[f"licenses/{name}"] = path.read_bytes()
    for path in sorted((root / "data").glob("LICENSE.*")):
        files[f"licenses/{path.name.removeprefix('LICENSE.')}.txt"] = path.read_bytes()
    files["LICENSE"] = (root / "LICENSE").read_bytes()
    for path in wheels:
        files[f"wheels/{path.name}"] = path.read_bytes()
    listed = sorted(f"./wheels/{path.name}" for path in wheels)
    manifest = manifest_text(files[MANIFEST].decode(), listed, version)
    files[MANIFEST] = manifest.encode()
    zip_path = out / f"togishi-{tomllib.loads(manifest)['version']}-linux_x64.zip"
    write_zip(zip_path, files, epoch_s)
    size = zip_path.stat().st_size
    if size > MAX_BYTES:
        zip_path.unlink()
        raise ExtensionError(
            f"{zip_path.name}: {size / 1e6:.1f} MB; allowed are {MAX_BYTES / 1e6:.0f} MB"
        )
    return zip_path


def blender_validators(root: Path) -> list[Path]:
    """The programs behind `blender --command extension` of the bpy wheels in the checkout's environments."""
    pattern = ".venv*/lib/python*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py"
    return sorted(root.glob(pattern))


def validate(zip_path: Path, validator: Path) -> None:
    """Runs `blender --command extension validate`. Raises ExtensionError with what Blender says."""
    done = subprocess.run(
        [sys.executable, str(validator), "validate", str(zip_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise ExtensionError(f"{zip_path.name} is not valid: {done.stdout}{done.stderr}".strip())
