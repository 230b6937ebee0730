"""The CoM moves to where it rests against the hand forces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.balance.shifted_reference import ShiftedReference
from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Joints
from follower_humanoid.gait.differential_ik import IkConfig
from follower_humanoid.robot.body_state import BodyState
from follower_humanoid.robot.model import RobotModel


@dataclass(frozen=True)
class OffsetConfig:
    """How the CoM answers steady hand forces."""

    enabled: bool = parameter(True, "shift the reference CoM against the hand forces")
    bandwidth: float = parameter(2.0, "rate at which the CoM offset follows the hand forces", "1/s", 0.1, 20)
    limit: float = parameter(0.12, "largest CoM offset in x and in y", "m", 0, 0.3)
    ik: IkConfig = field(default_factory=IkConfig)


class ComOffset:
    """Adds δ = κ c − γ − c to the CoM of the reference, with the feet and the pelvis where they were."""

    def __init__(self, config: OffsetConfig, robot: RobotModel, wanted: BodyState) -> None:
        """Args: parameters, the robot, and the kinematics of the reference, which follow it."""
        self._config = config
        self._com = wanted.com
        self._shifted = ShiftedReference(config.ik, robot, wanted)
        self._offset: Array = np.zeros(2)

    def step(self, q: Array, v: Array, hands: HandEffect, dt: float) -> Joints:
        """One tick.

        Args:
            q, v: Configuration, shape (52,), and velocity, shape (51,), of which `wanted` has the kinematics.
            hands: Effect of the hand forces.
            dt: Tick [s].

        Returns:
            The corrected joint reference.
        """
        config = self._config
        rate = np.empty(2)
        _follow(self._com, hands.gamma, hands.kappa, config.limit, config.bandwidth, dt, self._offset, rate)
        return self._shifted.step(q, v, self._offset, rate, dt)


@kernel("void(float64[::1], float64[::1], float64, float64, float64, float64, float64[::1], float64[::1])")
def _follow(
    com: Array, gamma: Array, kappa: float, limit: float, bandwidth: float, dt: float,
    offset: Array, rate: Array,
) -> None:  # fmt: skip
    """Moves the offset [m] a tick on towards δ = κ c − γ − c within ±limit; writes its rate [m/s]."""
    for axis in range(2):
        goal = kappa * com[axis] - gamma[axis] - com[axis]
        goal = min(max(goal, -limit), limit)
        rate[axis] = bandwidth * (goal - offset[axis])
        offset[axis] += dt * rate[axis]
