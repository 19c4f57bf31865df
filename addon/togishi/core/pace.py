"""How finely a viewport draws while something moves: coarser pixels where the machine is too slow for its own."""

from __future__ import annotations

SLOW_S = 0.1
"""A picture that takes longer is no movement any more."""
COARSEST = 4


def next_step(step: int, seconds: float) -> int:
    """Side of the next picture's pixels, in the screen's, from how long the last one took: 1, 2 or 4."""
    if seconds > SLOW_S and step < COARSEST:
        return 2 * step
    # Finer only where it would not be too slow at once.
    if step > 1 and 4.0 * seconds < 0.7 * SLOW_S:
        return step // 2
    return step


def coarse_size(size: tuple[int, int], step: int) -> tuple[int, int]:
    """Size of a picture whose pixels are so large; its last ones may reach beyond the screen's border."""
    return -(-size[0] // step), -(-size[1] // step)
