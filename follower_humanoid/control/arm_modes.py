"""The two modes of the arm, who is in which, and switching without a bump.

`impedance` keeps a place with springs; `gravity_compensation` lets itself be led; `auto` chooses by
the measured force, per hand.
"""

from __future__ import annotations

import numpy as np

from follower_humanoid.control.hand_task import Mask
from follower_humanoid.core.samples import Array

IMPEDANCE, COMPENSATION, AUTO = "impedance", "gravity_compensation", "auto"
MODES = (IMPEDANCE, COMPENSATION, AUTO)


class ModeSwitch:
    """Which hands yield.

    In `auto` a hand begins to yield as soon as it is pulled by more than one force, and stops once
    it has been pulled by less than another, lower one for a while: hysteresis in force and in time.

    Attributes:
        yielding: Left and right hand, shape (2,).
        changed: Whose mode changed at this tick, shape (2,).
        anybody: True where a hand yields.
        switched: True where a mode changed at this tick.
    """

    def __init__(self, period: float) -> None:
        """Nobody yields; `period` is the control tick [s]."""
        self.yielding: Mask = np.zeros(2, dtype=bool)
        self.changed: Mask = np.zeros(2, dtype=bool)
        self.anybody = self.switched = False
        self._mode = IMPEDANCE
        self._period = period
        self._quiet = np.zeros(2)

    def step(self, mode: str, force: Array, pulled: float, released: float, delay: float) -> None:
        """Decides for this tick.

        Args:
            mode: One of `MODES`.
            force: Measured on each hand, shape (2, 3) [N]; zero where none is measured yet.
            pulled: Force above which a hand yields in `auto` [N].
            released: Force below which it is let go [N].
            delay: For how long, until it stops yielding [s].
        """
        if mode == self._mode != AUTO and not self.switched:
            return  # nothing can change
        before, self._mode = self.yielding, mode
        if mode == AUTO:
            self.yielding = self._automatic(force, pulled, released, delay)
        else:
            self.yielding = np.full(2, mode == COMPENSATION)
            self._quiet[:] = 0.0
        self.changed = self.yielding != before
        self.anybody, self.switched = bool(self.yielding.any()), bool(self.changed.any())

    def _automatic(self, force: Array, pulled: float, released: float, delay: float) -> Mask:
        size = np.sqrt((force * force).sum(axis=1))
        self._quiet = np.where(size < released, self._quiet + self._period, 0.0)
        stays: Mask = self.yielding & (self._quiet < delay)
        begins: Mask = size > pulled
        return stays | begins


class Blend:
    """Takes what one law commanded over into the next, and lets it fade.

    At a switch the difference between the last command and the new law's is added to the new law
    and fades linearly: whatever the two laws are, the command has no step.
    """

    def __init__(self, time: float, period: float) -> None:
        """`time` in which the difference fades [s], and the control tick [s]."""
        self._step = period / time
        self._carried = np.zeros((2, 7))
        self._share = np.zeros(2)
        self._fading = False
        self._last: Array | None = None

    def step(self, command: Array, changed: Mask | None) -> Array:
        """The command without a step.

        Args:
            command: Of the laws that hold now, shape (2, 7).
            changed: Whose law is a new one, shape (2,); None: nobody's.
        """
        if changed is not None and self._last is not None:
            self._carried[changed] = (self._last - command)[changed]
            self._share[changed] = 1.0
            self._fading = True
        if self._fading:
            command = command + self._share[:, None] * self._carried
            self._share = np.maximum(0.0, self._share - self._step)
            self._fading = bool(self._share.any())
        self._last = command
        return command
