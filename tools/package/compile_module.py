"""Compiles togishi_core for one Python, with zig (C++ against an old C library) or with a compiler of the machine."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

GLIBC = (2, 28)
"""The C library that Blender's own builds ask for: what we ship must load wherever Blender does."""

# Nothing but the C library and its loader: whatever else a module names, a machine may lack.
ALLOWED_LIBRARIES = {
    "libc.so.6",
    "libm.so.6",
    "libpthread.so.0",
    "libdl.so.2",
    "librt.so.1",
    "ld-linux-x86-64.so.2",
}


class CompileError(RuntimeError):
    """The module could not be made; the message says what went wrong."""


@dataclass(frozen=True)
class Toolchain:
    root: Path  # the checkout
    tools: Path  # environment with ziglang and pybind11 (pyproject.toml, group "package")
    folder: Path  # where to build
    compiler: str  # "zig", or a compiler of this machine such as "g++"
    epoch_s: int

    def run(self, *command: str | Path) -> None:
        environment = {**os.environ, "SOURCE_DATE_EPOCH": str(self.epoch_s)}
        # Flags of the caller's shell must not find their way into the package.
        for name in ("CXXFLAGS", "CFLAGS", "LDFLAGS", "CPPFLAGS"):
            environment.pop(name, None)
        done = subprocess.run([str(part) for part in command], env=environment, check=False)
        if done.returncode != 0:
            raise CompileError(
                f"'{command[0]}' ended with exit code {done.returncode}; its message is above"
            )

    def ask(self, code: str) -> str:
        done = subprocess.run(
            [self.tools / "bin/python", "-c", code], capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise CompileError(f"{self.tools} is not complete: {done.stderr.strip()}")
        return done.stdout.strip()

    def command(self) -> Path | str:
        """The C++ compiler as one file, which is what CMake takes."""
        if self.compiler != "zig":
            return self.compiler
        zig = Path(self.ask("import ziglang; print(ziglang.__path__[0])")) / "zig"
        wrapper = self.folder / "zig-c++"
        target = f"x86_64-linux-gnu.{GLIBC[0]}.{GLIBC[1]}"
        wrapper.write_text(f'#!/bin/sh\nexec "{zig}" c++ -target {target} "$@"\n')
        wrapper.chmod(0o755)
        return wrapper

    def headers(self, version: str) -> Path:
        """A folder with the header-only libraries that lie in /usr/include among the machine's own headers, which
        zig must not see, and Debian's pyconfig.h."""
        folder = self.folder / "include"
        machine = "x86_64-linux-gnu"
        (folder / machine).mkdir(parents=True, exist_ok=True)
        for name in ("glm", "toml++", "nlohmann", f"{machine}/python{version}"):
            link, target = folder / name, Path("/usr/include") / name
            if target.is_dir() and not link.is_symlink():
                link.symlink_to(target)
        return folder


def compile_module(chain: Toolchain, python: Path, version: str) -> Path:
    """The stripped module for `python` (its `version` as "3.11"). The parts that do not depend on Python are compiled
    once for all versions."""
    chain.folder.mkdir(parents=True, exist_ok=True)
    flags = (
        f"-isystem {chain.headers(version)} "
        # No folder of this machine in the result: two checkouts make the same bytes.
        f"-ffile-prefix-map={chain.folder}=build -ffile-prefix-map={chain.root}=."
    )
    build = chain.folder / "cmake"
    output = build / "cpp_core/python"
    for old in output.glob("togishi_core*.so"):
        old.unlink()
    chain.run(
        *("cmake", "--fresh", "-S", chain.root, "-B", build, "-G", "Ninja", "--log-level=WARNING"),
        *("-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_COMPILER={chain.command()}", "-DCCACHE=OFF"),
        *("-DTOGISHI_PYTHON=ON", "-DTOGISHI_CLI=OFF", "-DTOGISHI_TESTS=OFF"),
        f"-DPython_EXECUTABLE={python}",
        f"-Dpybind11_DIR={chain.ask('import pybind11; print(pybind11.get_cmake_dir())')}",
        *(f"-DCMAKE_CXX_FLAGS={flags}", "-DCMAKE_MODULE_LINKER_FLAGS=-s -Wl,--build-id=none"),
    )
    chain.run("cmake", "--build", build, "--target", "togishi_core")
    made = list(output.glob("togishi_core*.so"))
    if len(made) != 1:
        raise CompileError(f"{output} holds {len(made)} modules after the build, not one")
    return made[0]
