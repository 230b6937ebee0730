"""What a node's steps cost, for its diagnostics."""

from __future__ import annotations

import time

from follower_humanoid.ros.managed_node import Rate


class Toll:
    """Counts steps and the time they take.

    Attributes:
        steps: So far.
    """

    def __init__(self) -> None:
        """None yet."""
        self.steps = 0
        self._busy = 0.0
        self._cpu_from: float | None = None
        self._rate = Rate()

    def begin(self) -> None:
        """The process's CPU time counts from here."""
        self._cpu_from = time.process_time()

    def add(self, seconds: float) -> None:
        """One more step and its wall time [s]."""
        self.steps += 1
        self._busy += seconds

    def report(self, ticks: int) -> dict[str, float | int | str | bool]:
        """Steps per second, wall time of a step, and CPU time of the whole process per tick."""
        cpu = 0.0 if self._cpu_from is None or ticks == 0 else (time.process_time() - self._cpu_from) / ticks
        return {
            "rate [Hz]": self._rate.look(self.steps),
            "step_time [s]": self._busy / self.steps if self.steps else 0.0,
            "process_cpu_per_tick [s]": cpu,
        }
