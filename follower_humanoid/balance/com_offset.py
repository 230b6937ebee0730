"""The CoM moves to where it rests against the hand forces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.balance.shifted_reference import ShiftedReference
from follower_humanoid.core.config import parameter
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

    def __init__(self, config: OffsetConfig, robot: RobotModel) -> None:
        self._config = config
        self._shifted = ShiftedReference(config.ik, robot)
        self._offset: Array = np.zeros(2)

    def step(self, q: Array, v: Array, wanted: BodyState, hands: HandEffect, dt: float) -> Joints:
        """One tick.

        Args:
            q, v: Reference configuration, shape (52,), and velocity, shape (51,).
            wanted: Kinematics of that reference.
            hands: Effect of the hand forces.
            dt: Tick [s].

        Returns:
            The corrected joint reference.
        """
        config, com = self._config, wanted.com[:2]
        goal = np.minimum(np.maximum(hands.resting_com(com) - com, -config.limit), config.limit)
        rate = config.bandwidth * (goal - self._offset)
        self._offset = self._offset + dt * rate
        return self._shifted.step(q, v, wanted, self._offset, rate, dt)
