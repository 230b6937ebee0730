"""How high the pelvis may be: no leg is asked for more than its length."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from follower_humanoid.core.config import parameter


@dataclass(frozen=True)
class PelvisConfig:
    """Leg length and pelvis motion."""

    leg_reach: float = parameter(
        0.806, "longest hip-to-ankle distance asked for (0.83 m is straight)", "m", 0.5, 0.83
    )
    bandwidth: float = parameter(5.0, "critically damped filter of the pelvis height", "rad/s", 1, 40)
    spare: float = parameter(
        0.02, "how much further the hip may be from a foot that lands or lifts off", "m", 0, 0.2
    )
    rise_speed: float = parameter(
        0.01, "the pelvis rises no faster; it falls as fast as needed", "m/s", 0.001, 1
    )
    lowest: float = parameter(0.68, "lowest pelvis height", "m", 0.4, 0.9)


class Reach(NamedTuple):
    """How far a leg must reach.

    Attributes:
        ankle_height: Height of its ankle above the ground [m].
        horizontal: Horizontal distance of the ankle from the hip [m].
    """

    ankle_height: float
    horizontal: float


class PelvisHeight:
    """Walking height, lowered by itself near the limits of leg length.

    Attributes:
        height: Of `base_link` above the ground [m].
        velocity: [m/s].
    """

    def __init__(self, config: PelvisConfig, height: float) -> None:
        self._config = config
        self._standing = height
        self.height = height
        self.velocity = 0.0

    def admissible(self, reaches: list[Reach]) -> float:
        """The highest pelvis at which no leg is longer than it may be [m]."""
        height, longest = self._standing, self._config.leg_reach**2
        for ankle_height, horizontal in reaches:
            rise = longest - horizontal**2
            height = min(height, ankle_height + math.sqrt(max(rise, 0.01)))
        return max(height, self._config.lowest)

    def advance(self, goal: float, dt: float) -> None:
        """One tick of a critically damped filter towards a height [m]."""
        w = self._config.bandwidth
        acceleration = w * w * (goal - self.height) - 2.0 * w * self.velocity
        # Rising slowly keeps the height nearly constant over a walk: the next step needs it low again.
        self.velocity = min(self.velocity + dt * acceleration, self._config.rise_speed)
        self.height += dt * self.velocity
