"""First-order low-pass filter of a signal, exact for one that is constant between steps."""

from __future__ import annotations

import math
from typing import Generic, TypeVar

from follower_humanoid.core.samples import Array


def filter_share(time_constant: float, period: float) -> float:
    """`1 − exp(−Δt/T)`, what a sample adds of its distance: T [s], 0 = no filter; Δt between samples [s]."""
    return 1.0 - math.exp(-period / time_constant) if time_constant > 0.0 else 1.0


Signal = TypeVar("Signal", float, Array)


class LowPass(Generic[Signal]):
    """`y' = (x − y)/T`, sampled: `y ← y + (1 − exp(−Δt/T)) (x − y)`.

    The first sample passes unchanged: a filter that starts from zero would report a jump that
    nobody measured.

    Attributes:
        value: y, or None before the first sample.
    """

    def __init__(self, time_constant: float, period: float) -> None:
        """`time_constant` T [s], 0 = no filter; `period` Δt between samples [s]."""
        self._share = filter_share(time_constant, period)
        self.value: Signal | None = None

    def step(self, sample: Signal) -> Signal:
        """The filtered value after one more sample: a number, or an array of the same shape."""
        self.value = sample if self.value is None else self.value + self._share * (sample - self.value)
        return self.value
