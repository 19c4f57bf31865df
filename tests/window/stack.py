"""A stack of photographs for the scripts of this folder: a strip under sixteen lights, its lower part rougher along a
wavy border, as a hamon is."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np

SHAPE = (48, 384)  # rows, columns
LIGHTS = 16


def write_stack(folder: Path, image_io: ModuleType, photographs: ModuleType) -> Path:
    """The .lp file. photographs: the add-on's core.photographs, which writes the pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    border = 0.55 * SHAPE[0] + 0.1 * SHAPE[0] * np.sin(columns / 17.0) + 3.0 * np.sin(columns / 5.0)
    ha = 1.0 / (1.0 + np.exp(-(rows - border) / 1.5))
    angle, zenith = 2.399963 * np.arange(LIGHTS), np.radians(np.linspace(2.0, 45.0, LIGHTS))
    lines = [str(LIGHTS)]
    for index in range(LIGHTS):
        lean_deg = np.degrees(zenith[index]) / 2.0
        ji, rough = (np.exp(-np.log(2.0) * (lean_deg / mu_deg) ** 2) for mu_deg in (4.0, 9.0))
        signal = (0.8 * (1.0 - ha) * ji + 0.35 * ha * rough)[..., None].astype(np.float32)
        photographs.write_planes(image_io, folder / f"{index}.exr", ["Y"], signal)
        x, y = np.sin(zenith[index]) * np.array([np.cos(angle[index]), np.sin(angle[index])])
        lines.append(f"{index}.exr {x:.9f} {y:.9f} {np.cos(zenith[index]):.9f}")
    stack = folder / "stack.lp"
    stack.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return stack
