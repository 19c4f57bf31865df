"""Options of the headless render: what the command line means, without Blender."""

from __future__ import annotations

import argparse
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

EXIT_OK = 0
EXIT_FAILED = 1  # something went wrong while rendering
EXIT_BAD_INPUT = 2  # the command line, or a file that it names

MAX_FRAMES = 1_000_000

# Still formats by the name on the command line: Blender's identifier and the file's suffix.
FORMATS = {
    "png": ("PNG", ".png"),
    "exr": ("OPEN_EXR", ".exr"),
    "exr-multilayer": ("OPEN_EXR_MULTILAYER", ".exr"),
    "tiff": ("TIFF", ".tif"),
    "jpeg": ("JPEG", ".jpg"),
}
SUFFIXES = {
    ".png": "png",
    ".exr": "exr",
    ".tif": "tiff",
    ".tiff": "tiff",
    ".jpg": "jpeg",
    ".jpeg": "jpeg",
}
ENGINES = ("file", "togishi", "cycles", "eevee", "workbench")


class UsageError(ValueError):
    """What is wrong with the command line: option, value, what is allowed."""


@dataclass(frozen=True)
class RenderOptions:
    blend: Path
    output: str
    frames: tuple[int, ...]  # empty: the file's own current frame
    engine: str
    width: int | None
    height: int | None
    samples: int | None
    format: str | None
    camera: str | None
    scene: str | None
    skip_existing: bool


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(message)


def parse_frames(text: str, step: int = 1) -> tuple[int, ...]:
    """Frames of "1-48", "1,5,7-9" or "1-48x4" (every fourth), each once, in ascending order. `step` applies
    to ranges without one of their own. Raises UsageError."""
    if step < 1:
        raise UsageError(f"--step: {step}; it must be 1 or more")
    frames: set[int] = set()
    for piece in text.split(","):
        match = re.fullmatch(r"\s*(-?\d{1,7})(?:-(-?\d{1,7})(?:x(\d{1,7}))?)?\s*", piece)
        if match is None:
            raise UsageError(
                f"--frames: {piece.strip()!r}; allowed are 7, 1-48, 1-48x2, and lists with commas"
            )
        first = int(match[1])
        last = int(match[2]) if match[2] is not None else first
        every = int(match[3]) if match[3] is not None else step
        if last < first:
            raise UsageError(f"--frames: {piece.strip()!r} ends before it starts")
        if every < 1:
            raise UsageError(f"--frames: {piece.strip()!r}; the step must be 1 or more")
        frames.update(range(first, last + 1, every))
        if len(frames) > MAX_FRAMES:
            raise UsageError(f"--frames: more than {MAX_FRAMES} frames")
    return tuple(sorted(frames))


def parse_resolution(text: str) -> tuple[int, int]:
    """Width and height of "1920x1080", each 4 to 65536. Raises UsageError."""
    match = re.fullmatch(r"(\d{1,6})[xX](\d{1,6})", text.strip())
    if match is None:
        raise UsageError(f"--resolution: {text!r}; it must be WIDTHxHEIGHT, such as 1920x1080")
    width, height = int(match[1]), int(match[2])
    if not (4 <= width <= 65536 and 4 <= height <= 65536):
        raise UsageError(f"--resolution: {text!r}; each side must be 4 to 65536")
    return width, height


def parser() -> argparse.ArgumentParser:
    top = _Parser(prog="togishi", description="Togishi without a window.")
    commands = top.add_subparsers(dest="command", required=True, parser_class=_Parser)
    render = commands.add_parser(
        "render",
        help="render frames of a .blend",
        description=(
            "Render frames of a .blend. Prints \"Saved: 'PATH'\" for each file; progress goes to stderr. "
            "Exit code 0: every frame is there; 1: a frame failed; 2: bad options, input files or output folder."
        ),
    )
    render.add_argument("blend", metavar="FILE.blend", type=Path)
    render.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help="file name; #### stands for the frame number",
    )
    render.add_argument(
        "-f", "--frames", metavar="LIST", help='such as "1-48", "1,5,7-9" or "1-48x2"'
    )
    render.add_argument(
        "--step", type=int, default=1, help="every n-th frame of ranges (default 1)"
    )
    render.add_argument(
        "-E", "--engine", choices=ENGINES, default="file", help="default: the file's own"
    )
    render.add_argument(
        "-r", "--resolution", metavar="WxH", help="in pixels; default: the file's own"
    )
    render.add_argument(
        "-s", "--samples", type=int, help="samples per pixel; default: the file's own"
    )
    render.add_argument(
        "-F", "--format", choices=sorted(FORMATS), help="default: by OUT, else the file's own"
    )
    render.add_argument("--camera", help="name of the camera; default: the scene's own")
    render.add_argument("--scene", help="name of the scene; default: the file's current one")
    render.add_argument(
        "--skip-existing", action="store_true", help="leave out frames whose file is there"
    )
    return top


def parse(argv: list[str]) -> RenderOptions:
    """Raises UsageError for anything that does not make sense; SystemExit(0) after --help."""
    values = parser().parse_args(argv)
    width = height = None
    if values.resolution is not None:
        width, height = parse_resolution(values.resolution)
    if values.samples is not None and not 1 <= values.samples <= 65536:
        raise UsageError(f"--samples: {values.samples}; allowed are 1 to 65536")
    format_name = values.format
    by_suffix = SUFFIXES.get(Path(values.output).suffix.lower())
    if format_name is None:
        format_name = by_suffix
    elif by_suffix is not None and FORMATS[format_name][1] != FORMATS[by_suffix][1]:
        raise UsageError(f"--format: {format_name} does not fit the file name {values.output!r}")
    return RenderOptions(
        blend=values.blend,
        output=values.output,
        frames=() if values.frames is None else parse_frames(values.frames, values.step),
        engine=values.engine,
        width=width,
        height=height,
        samples=values.samples,
        format=format_name,
        camera=values.camera,
        scene=values.scene,
        skip_existing=values.skip_existing,
    )


def frame_path(output: str, frame: int, suffix: str, several: bool) -> Path:
    """File of a frame. The last run of # is replaced by the number; without one, several frames get _#### and a
    single frame gets the name as it is. A folder gets ####. The suffix is added where it is missing."""
    if output.endswith(("/", os.sep)) or Path(output).is_dir():
        output = os.path.join(output, "####")  # noqa: PTH118 - a name with # is no path yet
    stem, ending = output, ""
    if SUFFIXES.get(Path(output).suffix.lower()) is not None:
        ending = Path(output).suffix
        stem = output[: -len(ending)]
    runs = list(re.finditer(r"#+", stem))
    if runs:
        last = runs[-1]
        sign = "-" if frame < 0 else ""
        number = sign + str(abs(frame)).zfill(len(last[0]))
        stem = stem[: last.start()] + number + stem[last.end() :]
    elif several:
        stem = f"{stem}_{frame:04d}"
    return Path(stem + (ending or suffix))


def unwritable(folder: Path) -> str:
    """A sentence about a folder in which files cannot be made, or "". Tries it: permissions alone do not tell."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".togishi-{os.getpid()}"
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        return f"--output: cannot write in {folder}: {error.strerror or error}"
    return ""
