"""The reference with its CoM shifted: other velocities of base and legs, feet and pelvis where they were."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import SIDES, Array, Joints
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig
from follower_humanoid.robot.body_state import BodyState
from follower_humanoid.robot.model import BASE_DOF, RobotModel


class ShiftedReference:
    """Turns a shift of the CoM into joint references, tick by tick."""

    def __init__(self, config: IkConfig, robot: RobotModel) -> None:
        self._config = config
        self._robot = robot
        self._soles = {side: robot.frame_id(f"{side.prefix}_sole") for side in SIDES}
        self._ik: DifferentialIk | None = None

    def step(self, q: Array, v: Array, wanted: BodyState, offset: Array, rate: Array, dt: float) -> Joints:
        """One tick.

        Args:
            q, v: Reference configuration, shape (52,), and velocity, shape (51,).
            wanted: Kinematics of that reference.
            offset: Shift of the CoM over the ground, shape (2,) [m].
            rate: Its velocity, shape (2,) [m/s].
            dt: Tick [s].

        Returns:
            The corrected joint reference.
        """
        if self._ik is None:
            self._ik = DifferentialIk(self._robot, self._config, q)
        feet = {side: self._as_wanted(wanted, frame) for side, frame in self._soles.items()}
        rotation = wanted.base[:3].T
        body = BodyTask(
            com=wanted.com[:2] + offset, com_velocity=wanted.com_velocity[:2] + rate,
            pelvis_height=float(q[2]), pelvis_height_velocity=float(rotation[2] @ v[:3]),
            pelvis_rotation=rotation, pelvis_angular_velocity=rotation @ v[3:6],
        )  # fmt: skip
        ik = self._ik
        # Joints outside the IK follow the reference as it is.
        given = np.empty(len(v) - BASE_DOF)
        _lead(q, v, ik.q, self._config.foot_gain, given)
        ik.advance(feet, body, given, dt)
        return Joints(ik.q[BASE_DOF + 1 :], ik.v[BASE_DOF:], np.zeros(len(given)))

    def _as_wanted(self, wanted: BodyState, sole: int) -> FootTask:
        """A sole goes where the reference has it."""
        place, twist = wanted.frames[sole], wanted.twist(sole)
        return FootTask(place[3], place[:3].T, twist[:3], twist[3:])


@kernel("void(float64[::1], float64[::1], float64[::1], float64, float64[::1])")
def _lead(q: Array, v: Array, q_now: Array, gain: float, given: Array) -> None:
    """Writes velocities that lead the joints to a reference: q̇_d + k (q_d − q).

    Args:
        q, v: Reference configuration, shape (52,), and velocity, shape (51,).
        q_now: Present configuration, shape (52,).
        gain: k [1/s].
        given: Written, shape (45,) [rad/s].
    """
    for joint in range(given.size):
        error = q[BASE_DOF + 1 + joint] - q_now[BASE_DOF + 1 + joint]
        given[joint] = v[BASE_DOF + joint] + gain * error
