"""How fast simulated time goes."""

from __future__ import annotations

import math
from collections import deque

_OVER = 1.0  # wall time over which the speed is taken [s]


class Speedometer:
    """Simulated seconds per wall second, over the last second."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self._seen: deque[tuple[float, float]] = deque()

    def look(self, time: float, wall: float) -> float:
        """The speed, given simulated and wall time [s]; NaN before it is known."""
        if self._seen and time < self._seen[-1][0]:
            self._seen.clear()
        self._seen.append((time, wall))
        while len(self._seen) > 2 and wall - self._seen[1][1] > _OVER:
            self._seen.popleft()
        begin, since = self._seen[0]
        return (time - begin) / (wall - since) if wall - since > 0.2 * _OVER else math.nan
