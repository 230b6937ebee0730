"""A push of a chosen impulse: a constant force for a fifth of a second of simulated time."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import Array

LENGTH = 0.2  # s
_LAST_WORD = 0.3  # simulated time for which the end is told, so that nobody misses it [s]


class Push:
    """At most one push at a time."""

    def __init__(self) -> None:
        """Nobody pushes."""
        self._force = np.zeros(3)
        self._since: float | None = None

    @property
    def active(self) -> bool:
        """Whether there is anything to tell."""
        return self._since is not None

    def begin(self, impulse: Array, time: float) -> None:
        """Begins at a simulated time [s]; impulse in world, shape (3,) [N·s]."""
        self._force, self._since = np.asarray(impulse) / LENGTH, time

    def force(self, time: float) -> Array:
        """What pushes at a simulated time [s], shape (3,) [N]; zero after the push."""
        since = self._since
        if since is None or not since <= time < since + LENGTH + _LAST_WORD:
            self._since = None
            return np.zeros(3)
        return self._force if time < since + LENGTH else np.zeros(3)
