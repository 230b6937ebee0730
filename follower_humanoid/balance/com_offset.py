"""The velocity correction of the reference: the CoM moves to where it rests against the hand forces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Joints
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig
from follower_humanoid.robot.body_state import BodyState
from follower_humanoid.robot.model import BASE_DOF, RobotModel


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
        self._robot = robot
        self._soles = {side: robot.frame_id(f"{side.prefix}_sole") for side in SIDES}
        self._ik: DifferentialIk | None = None
        self._offset = np.zeros(2)

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
        if self._ik is None:
            self._ik = DifferentialIk(self._robot, self._config.ik, q)
        com, velocity = wanted.com[:2], wanted.com_velocity[:2]
        rate = self._move_offset(com, hands, dt)
        feet = {side: self._as_wanted(wanted, frame) for side, frame in self._soles.items()}
        rotation = wanted.base[:3].T
        body = BodyTask(
            com=com + self._offset, com_velocity=velocity + rate,
            pelvis_height=float(q[2]), pelvis_height_velocity=float(rotation[2] @ v[:3]),
            pelvis_rotation=rotation, pelvis_angular_velocity=rotation @ v[3:6],
        )  # fmt: skip
        ik = self._ik
        # Joints outside the IK follow the reference as it is.
        given = v[BASE_DOF:] + self._config.ik.foot_gain * (q[BASE_DOF + 1 :] - ik.q[BASE_DOF + 1 :])
        ik.advance(feet, body, given, dt)
        return Joints(ik.q[BASE_DOF + 1 :], ik.v[BASE_DOF:], np.zeros(len(given)))

    def _move_offset(self, com: Array, hands: HandEffect, dt: float) -> Array:
        """δ̇ towards the offset at which the CoM rests, shape (2,) [m/s]."""
        config = self._config
        goal = np.minimum(np.maximum(hands.resting_com(com) - com, -config.limit), config.limit)
        rate = config.bandwidth * (goal - self._offset)
        self._offset = self._offset + dt * rate
        return rate

    def _as_wanted(self, wanted: BodyState, sole: int) -> FootTask:
        """A sole goes where the reference has it."""
        place, twist = wanted.frames[sole], wanted.twist(sole)
        return FootTask(place[3], place[:3].T, twist[:3], twist[3:])
