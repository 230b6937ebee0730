"""A simulator whose physics break: `python -m follower_humanoid.faults.broken_simulator`.

It takes the place of the graph's own.
At 0.1 s the current of one motor is no number any more.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from follower_humanoid.ros.simulator_node import SimulatorNode
from follower_humanoid.ros.spin import run

BREAKS_AT = 50  # tick


class BrokenSimulator(SimulatorNode):
    """Good until then."""

    def step(self, tick: int, samples: Mapping[str, Any]) -> None:
        """One tick of physics."""
        if tick == BREAKS_AT:
            self.component.plant.motors.current[3] = np.nan
        super().step(tick, samples)


if __name__ == "__main__":
    sys.exit(run([BrokenSimulator], sys.argv[1:]))
