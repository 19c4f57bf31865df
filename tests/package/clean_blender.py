"""Blender as a new user has it: no settings, nothing installed, none of this checkout's modules within reach."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "tests/blender"), str(ROOT / "tools/package")]

from fixed_zip import write_zip  # noqa: E402
from version_table import BlenderVersion  # noqa: E402
from wheel import write_files  # noqa: E402

MAKE_PACKAGE = ROOT / "tools/package/make_package.py"
EPOCH_S = 1_700_000_000


@dataclass
class Answer:
    """What a script inside Blender reported, and how its process ended."""

    values: dict[str, Any]
    code: int
    output: str  # both streams

    def __getitem__(self, name: str) -> Any:
        assert name in self.values, f"no {name!r} was reported; the process said:\n{self.output}"
        return self.values[name]


@dataclass
class CleanBlender:
    """One version with one user folder, which outlives the processes that use it."""

    row: BlenderVersion
    folder: Path
    environment: dict[str, str] = field(default_factory=dict)

    @property
    def user(self) -> Path:
        return self.folder / "user"

    @property
    def site_packages(self) -> Path:
        """Where Blender unpacks the wheels of extensions."""
        return self.user / f"extensions/.local/lib/python{self.row.python_label}/site-packages"

    def run(self, script: str, *arguments: object, path: tuple[Path, ...] = ()) -> Answer:
        """Runs in_blender/<script>.py in a process of its own. path: more folders to import from."""
        report = self.folder / "report.json"
        report.unlink(missing_ok=True)
        output = self.folder / "output.txt"
        code = self.process(
            HERE / f"in_blender/{script}.py", report, *arguments, path=path, output=output
        )
        values = json.loads(report.read_text()) if report.is_file() else {}
        return Answer(values, code, output.read_text(errors="replace"))

    def process(
        self,
        script: Path,
        *arguments: object,
        output: Path,
        path: tuple[Path, ...] = (),
        timeout_s: float = 200.0,
    ) -> int:
        """Runs a script with this version's bpy, both its streams into `output`; returns its exit code."""
        self.user.mkdir(parents=True, exist_ok=True)
        environment = {
            "PATH": os.environ["PATH"],
            "HOME": str(self.folder),
            "BLENDER_USER_RESOURCES": str(self.user),
            "PYTHONPATH": os.pathsep.join(map(str, (*path, self._modules()))),
            **self.environment,
        }
        # -S: the environment's own site-packages, which has our module, is not looked at.
        command = [self.row.interpreter, "-S", script, *arguments]
        with output.open("wb") as stream:
            done = subprocess.run(
                [str(part) for part in command],
                env=environment,
                cwd=self.folder,
                stdout=stream,
                stderr=subprocess.STDOUT,
                timeout=timeout_s,
                check=False,
            )
        return done.returncode

    def _modules(self) -> Path:
        """The environment's modules but ours, as links."""
        links = self.folder / "modules"
        if not links.is_dir():
            links.mkdir(parents=True)
            for path in self.row.interpreter.parents[1].glob("lib/python*/site-packages/*"):
                if not path.name.startswith(("togishi", "__pycache__")) and path.suffix != ".pth":
                    (links / path.name).symlink_to(path)
        return links


def make_package(out: Path, *modules: Path, version: str | None = None) -> Path:
    """The extension around these compiled modules."""
    command: list[object] = [sys.executable, MAKE_PACKAGE, "--out", out]
    for module in modules:
        command += ["--module", module]
    if version is not None:
        command += ["--version", version]
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())


def with_other_wheel(package: Path, out: Path, files: dict[str, bytes], tag: str) -> Path:
    """A copy of the extension whose only wheel is one of these files, of the same version."""
    with zipfile.ZipFile(package) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    wheels = [name for name in content if name.endswith(".whl")]
    version = wheels[0].split("-")[1].partition("+")[0]
    wheel = write_files(files, tag, version, out / "wheel", EPOCH_S)
    manifest = content["blender_manifest.toml"].decode()
    start, _, rest = manifest.partition("wheels = [")
    rest = rest.partition("]")[2]
    content = {name: data for name, data in content.items() if name not in wheels}
    content["blender_manifest.toml"] = f'{start}wheels = ["./wheels/{wheel.name}"]{rest}'.encode()
    content[f"wheels/{wheel.name}"] = wheel.read_bytes()
    path = out / package.name
    write_zip(path, content, EPOCH_S)
    shutil.rmtree(out / "wheel")
    return path
