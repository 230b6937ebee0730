"""Compares the joint positions of a repetition with the recorded ones, bit for bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Integers, Run


@dataclass(frozen=True)
class Difference:
    """Where two runs part.

    Attributes:
        tick: First tick at which a joint differs.
        time: Of that tick [s].
        joint: The joint that differs most at that tick.
        recorded, simulated: Its positions [rad].
        joints: How many joints differ at that tick.
    """

    tick: int
    time: float
    joint: str
    recorded: float
    simulated: float
    joints: int

    def __str__(self) -> str:
        apart = abs(self.simulated - self.recorded)
        others = f" ({self.joints} joints differ)" if self.joints > 1 else ""
        return (
            f"differs first at tick {self.tick} ({self.time:.3f} s), joint {self.joint}: recorded "
            f"{self.recorded!r} rad, simulated {self.simulated!r} rad, {apart:.3g} rad apart{others}"
        )


class Comparison:
    """Joint positions of a repetition against the recorded ones, tick by tick."""

    def __init__(self, run: Run, joint_names: tuple[str, ...]) -> None:
        """Args: the recorded run and the order of the repetition's joints.

        Raises:
            ConfigurationError: The bag does not list these joints.
        """
        missing = sorted(set(joint_names) - set(run.joint_names))
        if missing:
            raise ConfigurationError(f"the bag's joint_states leave out {', '.join(missing)}")
        columns = [run.joint_names.index(name) for name in joint_names]
        states = run["joint_states"]
        self._names, self._tick = joint_names, run.tick
        self._position: Array = np.ascontiguousarray(states.position[:, columns])
        self._rows = {int(tick): row for row, tick in enumerate(states.ticks)}
        self.compared = 0

    def look(self, tick: int, position: Array) -> Difference | None:
        """The difference at a tick; None where there is none or nothing was recorded.

        Args:
            tick: Control tick.
            position: Of all joints, shape (n,) [rad].
        """
        row = self._rows.get(tick)
        if row is None:
            return None
        self.compared += 1
        recorded = self._position[row]
        differs: Integers = np.flatnonzero(recorded.view(np.int64) != position.view(np.int64))
        if not len(differs):
            return None
        worst = int(differs[np.argmax(np.abs(position - recorded)[differs])])
        return Difference(
            tick, tick * self._tick, self._names[worst],
            float(recorded[worst]), float(position[worst]), len(differs),
        )  # fmt: skip
