"""A real window from within: areas, input as from a person, and pictures that are taken from outside.

`bpy.ops.screen.screenshot` is black on software GPUs, so the script that started Blender takes the pictures: a
file NAME.request asks for one, and is gone when NAME.ppm is there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

# One wait of the timer that drives a window, in seconds.
TICK_S = 0.05
Steps = Iterator[float]


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def areas(kind: str) -> list[bpy.types.Area]:
    """Areas of the first window, the largest first."""
    found = [area for area in window().screen.areas if area.type == kind]
    return sorted(found, key=lambda area: -area.width * area.height)


def region_of(area: bpy.types.Area, kind: str = "WINDOW") -> bpy.types.Region:
    return next(region for region in area.regions if region.type == kind)


def override(area: bpy.types.Area, kind: str = "WINDOW") -> Any:
    """Context as if the mouse were over the area."""
    return bpy.context.temp_override(window=window(), area=area, region=region_of(area, kind))


def press(kind: str, at: tuple[int, int] | None = None, **modifiers: bool) -> Steps:
    """A key or mouse button, pressed and let go, with the mouse at `at` (px from the lower left corner)."""
    x, y = at or (window().width // 2, window().height // 2)
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    yield TICK_S
    window().event_simulate(type=kind, value="PRESS", x=x, y=y, **modifiers)
    yield TICK_S
    window().event_simulate(type=kind, value="RELEASE", x=x, y=y, **modifiers)
    yield TICK_S


def centre(area: bpy.types.Area) -> tuple[int, int]:
    region = region_of(area)
    return region.x + region.width // 2, region.y + region.height // 2


def until(condition: Callable[[], bool], timeout_s: float, what: str) -> Steps:
    """Let Blender run until something holds. Raises TimeoutError, naming it."""
    left = timeout_s
    while not condition():
        if left <= 0.0:
            raise TimeoutError(f"{what}: not within {timeout_s:.0f} s")
        left -= TICK_S
        yield TICK_S


def clear_view(area: bpy.types.Area) -> None:
    """Nothing but the engine's picture in a 3-D view: no overlays, gizmos, headers and panels."""
    space = area.spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    space.show_region_header = space.show_region_tool_header = False
    space.show_region_toolbar = space.show_region_ui = False


class Draws:
    """Counts what the 3-D views draw."""

    def __init__(self) -> None:
        self.count: dict[int, int] = {}
        self._handle = bpy.types.SpaceView3D.draw_handler_add(
            self._drawn, (), "WINDOW", "POST_PIXEL"
        )

    def _drawn(self) -> None:
        key = bpy.context.space_data.as_pointer()
        self.count[key] = self.count.get(key, 0) + 1

    def shown(self, timeout_s: float = 120.0) -> Steps:
        """Until every 3-D view was drawn once more."""
        views = areas("VIEW_3D")
        wanted = {}
        for area in views:
            key = area.spaces.active.as_pointer()
            wanted[key] = self.count.get(key, 0) + 1
            area.tag_redraw()
        yield TICK_S
        yield from until(
            lambda: all(self.count.get(key, 0) >= count for key, count in wanted.items()),
            timeout_s,
            "the viewport's next picture",
        )


class Shots:
    """Pictures of the window. keep: where PNGs stay for people to look at."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder / ".shots"
        self._folder.mkdir(parents=True, exist_ok=True)

    def take(
        self,
        name: str,
        corner: tuple[int, int],
        size: tuple[int, int],
        result: list[np.ndarray],
        keep: bool = False,
    ) -> Steps:
        """Append (height, width, 3) uint8, rows from the bottom, to `result`. corner: lower left, in px."""
        top = window().height - corner[1] - size[1]
        request = self._folder / f"{name}.request"
        part = request.with_suffix(".part")
        part.write_text(f"{size[0]}x{size[1]}+{corner[0]}+{top} {'keep' if keep else 'drop'}\n")
        part.replace(request)
        yield from until(lambda: not request.exists(), 30.0, f"screenshot {name}")
        file = self._folder / f"{name}.ppm"
        if not file.exists():
            raise RuntimeError(f"screenshot {name}: xwd or convert failed; see above")
        result.append(read_ppm(file))
        file.unlink()

    def region(
        self, region: bpy.types.Region, name: str, result: list[np.ndarray], keep: bool = False
    ) -> Steps:
        size = (region.width, region.height)
        yield from self.take(name, (region.x, region.y), size, result, keep)

    def area(self, area: bpy.types.Area, name: str) -> Steps:
        yield from self.take(name, (area.x, area.y), (area.width, area.height), [], keep=True)

    def everything(self, name: str) -> Steps:
        size = (window().width, window().height)
        yield from self.take(name, (0, 0), size, [], keep=True)


def read_ppm(file: Path) -> np.ndarray:
    data = file.read_bytes()
    magic, width, height, largest = data.split(None, 4)[:4]
    if magic != b"P6" or largest != b"255":
        raise ValueError(f"{file}: not an 8-bit PPM: {data[:20]!r}")
    count = int(width) * int(height) * 3
    pixels = np.frombuffer(data, np.uint8, count, len(data) - count)
    return pixels.reshape(int(height), int(width), 3)[::-1]


def write_ppm(file: Path, picture: np.ndarray) -> None:
    """(H, W, 3), values from 0 to 1, rows from the bottom."""
    pixels = (np.clip(picture[::-1], 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
    header = f"P6 {picture.shape[1]} {picture.shape[0]} 255\n".encode()
    file.write_bytes(header + pixels.tobytes())


def run_in_window(steps: Iterator[float], ended: Callable[[BaseException | None], None]) -> None:
    """Drive a generator from Blender's timers: what it yields is how long Blender runs in between, in seconds."""

    def advance() -> float | None:
        try:
            return next(steps)
        except StopIteration:
            ended(None)
        except BaseException as error:
            ended(error)
        return None

    # The splash screen would take the first key; it comes up after this.
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.use_preferences_save = False
    bpy.app.timers.register(advance, first_interval=0.5, persistent=True)
