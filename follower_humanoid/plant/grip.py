"""Intake for wrenches that people send: the newest acts at once, silence lets go gently."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import Wrench

ZERO = Wrench(np.zeros(3), np.zeros(3))


class Grip:
    """The wrench of one hand (or push): held until replaced, let go after silence.

    Attributes:
        received: Messages taken so far.
        rejected: Messages refused because a number was not finite.
    """

    def __init__(self, timeout: float = 0.5, release: float = 0.2) -> None:
        """Lets go after `timeout` of silence, linearly over `release` [s of simulated time]."""
        self._timeout, self._release = timeout, release
        self._wrench = ZERO
        self._since = 0.0
        self.received = 0
        self.rejected = 0

    def receive(self, wrench: Wrench, time: float) -> bool:
        """Takes a message at simulated `time` [s]; False if it is not finite and was refused."""
        if not np.isfinite(wrench.force.sum() + wrench.torque.sum()):
            self.rejected += 1
            return False
        self._wrench, self._since = wrench, time
        self.received += 1
        return True

    def at(self, time: float) -> Wrench:
        """What acts at simulated `time` [s]."""
        silence = time - self._since - self._timeout
        # Ticks are multiples of a step: what is late by rounding alone is not late.
        if silence <= 1e-9:
            return self._wrench
        share = 1.0 - silence / self._release if self._release > 0.0 else 0.0
        if share <= 1e-9:
            self._wrench = ZERO
            return ZERO
        return Wrench(share * self._wrench.force, share * self._wrench.torque, self._wrench.frame)
