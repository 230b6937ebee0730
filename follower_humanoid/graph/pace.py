"""How the ticks of a run lie on the wall's clock, free of ROS; times come in, no clock is read."""

from __future__ import annotations

import numpy as np

_GRACE = 1.0  # behind by more than that a run in real time goes on from where it is [s]
_KEPT = 4096


class Durations:
    """The last few thousand durations.

    Attributes:
        count: Of all so far.
    """

    def __init__(self) -> None:
        """None yet."""
        self.count = 0
        self._kept = np.zeros(_KEPT)

    def add(self, seconds: float) -> None:
        """One more [s]."""
        self._kept[self.count % _KEPT] = seconds
        self.count += 1

    def percentiles(self, *shares: float) -> tuple[float, ...]:
        """Percentiles of those that are kept [s]; zeros where there is none."""
        if not self.count:
            return (0.0,) * len(shares)
        return tuple(np.percentile(self._kept[: self.count], shares).tolist())


class Pace:
    """Not faster than real time.

    Attributes:
        late: By how much each tick began after its time.
        missed: Ticks that began later than the next one should have.
    """

    def __init__(self, tick: float, now: float, first: int) -> None:
        """Args: length of a tick [s], the wall's time [s] and the tick that begins now."""
        self._tick = tick
        self._from, self._first = now, first
        self._begun = first
        self.late = Durations()
        self.missed = 0

    def may_begin(self, tick: int, now: float) -> bool:
        """Whether a tick's time has come. Too slow a machine does not race to catch up afterwards."""
        late = now - self._from - (tick - self._first) * self._tick
        if late > _GRACE:
            self._from, self._first = now, tick
        if late < 0.0:
            return False
        if tick != self._begun:  # asked again for a tick that could not begin for other reasons
            self._begun = tick
            self.late.add(late)
            self.missed += late > self._tick
        return True
