"""What Blender wrote on its console, and which of its lines mean that something went wrong.

python console.py FILE      prints the lines that do and exits with 1 where there are any
"""

from __future__ import annotations

import argparse
import ctypes
import re
import sys
from pathlib import Path

_SUSPECT = re.compile(
    r"error|traceback|exception|warning|fail|assert|segmentation|abort|not freed|leak|"
    r"invalid|cannot|unable|rna_uiItem|unknown|deprecated|\bnot found\b",
    re.IGNORECASE,
)

# Lines that are no fault of ours, each with its reason. They are matched whole.
ALLOWED = (
    (r"Info: .*", "a report to the user, not of a problem"),
    (r"libEGL warning:.*", "Mesa without a screen looks for a hardware driver first"),
    (r"MESA(-LOADER)?: .*", "Mesa without a screen looks for a hardware driver first"),
    (r"EGL Error \(0x3009\): EGL_BAD_MATCH.*", "Blender tries several kinds of GPU context"),
    (
        r"Repository data: .* not found, sync required!",
        "Blender's own extensions, without a network",
    ),
    (r"pci id for fd.*", "Mesa without a graphics card"),
)
_ALLOWED = re.compile("|".join(f"(?:{pattern})" for pattern, _reason in ALLOWED))


def problems(text: str) -> list[str]:
    """The lines of a console that mean trouble."""
    return [
        line.rstrip()
        for line in text.splitlines()
        if _SUSPECT.search(line) and not _ALLOWED.fullmatch(line.strip())
    ]


def options() -> argparse.Namespace:
    """What the scripts of this folder are told; in Blender it stands after "--"."""
    own = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser()
    parser.add_argument("--zip", type=Path, required=True, help="the extension")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.add_argument("--console", type=Path, required=True, help="where our streams go")
    return parser.parse_args(own)


class Console:
    """The file that this process's standard streams go to, read piece by piece."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read = 0

    def new_problems(self) -> list[str]:
        """Lines that mean trouble since the call before."""
        sys.stdout.flush()
        sys.stderr.flush()
        ctypes.CDLL(None).fflush(
            None
        )  # Blender's own output, which C keeps back in a file's buffer
        data = self._path.read_bytes()
        text, self._read = data[self._read :].decode(errors="replace"), len(data)
        return problems(text)


def main() -> int:
    found = problems(Path(sys.argv[1]).read_text(errors="replace"))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
