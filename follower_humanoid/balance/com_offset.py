"""The velocity correction of the reference: the CoM moves to where it rests against the hand forces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig
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
        self._data = robot.pin_model.createData()
        self._soles = {side: robot.frame_id(f"{side.prefix}_sole") for side in SIDES}
        self._ik: DifferentialIk | None = None
        self._offset: Array = np.zeros(2)

    def step(self, reference: Joints, base: Odometry, hands: HandEffect, dt: float) -> Joints:
        """One tick.

        Args:
            reference, base: Motion reference.
            hands: Effect of the hand forces.
            dt: Tick [s].

        Returns:
            The corrected joint reference.
        """
        if not self._config.enabled:
            return reference
        model, data = self._robot.pin_model, self._data
        q, v = self._robot.state(base, reference)
        if self._ik is None:
            self._ik = DifferentialIk(self._robot, self._config.ik, q)
        pin.centerOfMass(model, data, q, v, False)
        com, velocity = np.array(data.com[0][:2]), np.array(data.vcom[0][:2])
        goal = np.clip(hands.resting_com(com) - com, -self._config.limit, self._config.limit)
        rate = self._config.bandwidth * (goal - self._offset)
        self._offset = self._offset + dt * rate
        tasks = {}
        for side, frame in self._soles.items():
            place = pin.updateFramePlacement(model, data, frame)
            motion = pin.getFrameVelocity(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            tasks[side] = FootTask(
                np.array(place.translation),
                np.array(place.rotation, order="C"),
                np.array(motion.linear),
                np.array(motion.angular),
            )
        rotation = np.array(data.oMi[1].rotation, order="C")
        body = BodyTask(
            com=com + self._offset, com_velocity=velocity + rate,
            pelvis_height=float(q[2]), pelvis_height_velocity=float(rotation[2] @ v[:3]),
            pelvis_rotation=rotation, pelvis_angular_velocity=rotation @ v[3:6],
        )  # fmt: skip
        ik = self._ik
        # Joints outside the IK follow the reference as it is.
        given = reference.velocity + self._config.ik.foot_gain * (reference.position - ik.q[7:])
        ik.advance(tasks, body, given, dt)
        return Joints(ik.q[7:].copy(), ik.v[BASE_DOF:].copy(), np.zeros_like(reference.effort))
