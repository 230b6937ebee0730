"""The hands' task: keep their places relative to the pelvis, eqs. (17), (18) corrected, and eq. (6).

The place of a hand is its gripper's position relative to `base_link` in pelvis-yaw axes (x ahead
of the pelvis, z up). Holding that place constant is eq. (18) with the offset turned by the base's
yaw and ẋ_d fed forward: world translation and turns of the pelvis drop out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.robot.model import BASE_DOF, RobotModel


@dataclass(frozen=True)
class HandMotion:
    """Both hands at one instant, left first. Task axes: pelvis-yaw.

    Attributes:
        place: Gripper relative to base_link, shape (2, 3) [m].
        place_rate: Its rate of change, shape (2, 3) [m/s].
        carried: The part of `place_rate` that would remain with the arm joints frozen: tilting of
            the pelvis and motion of the trunk, shape (2, 3) [m/s].
        jacobian: J, of `place` with respect to the own arm's joints, shape (2, 3, 7) [m/rad].
        wrench_jacobian: Linear and angular Jacobian of the gripper, axes of world, shape (2, 6, 7).
        yaw_to_world: Rotation of the task axes, shape (3, 3).
        base_to_world: Rotation of base_link, shape (3, 3).
    """

    place: Array
    place_rate: Array
    carried: Array
    jacobian: Array
    wrench_jacobian: Array
    yaw_to_world: Array
    base_to_world: Array


class HandKinematics:
    """Computes the hands' motion from the robot's state."""

    def __init__(self, robot: RobotModel) -> None:
        self._model = robot.pin_model
        self._data = self._model.createData()
        self._grippers = [robot.frame_id(f"{side.prefix}_gripper") for side in SIDES]
        self._columns = [_consecutive(BASE_DOF + robot.groups.arm(side)) for side in SIDES]

    def motion(self, q: Array, v: Array) -> HandMotion:
        """Both hands at state (q, v), shapes (52,), (51,)."""
        model, data = self._model, self._data
        pin.computeJointJacobians(model, data, q)
        base_to_world = data.oMi[1].rotation.copy()
        yaw_to_world, yaw_rate = _yaw(base_to_world, base_to_world @ v[3:6])
        world_to_yaw = yaw_to_world.T
        base_velocity = base_to_world @ v[:3]
        place, rate, carried, jacobian, wrench_jacobian = (
            np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3, 7)), np.empty((2, 6, 7)),
        )  # fmt: skip
        for hand, (frame, columns) in enumerate(zip(self._grippers, self._columns, strict=True)):
            position = pin.updateFramePlacement(model, data, frame).translation
            full = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
            wrench_jacobian[hand] = full[:, columns]
            jacobian[hand] = world_to_yaw @ full[:3, columns]
            place[hand] = world_to_yaw @ (position - q[:3])
            rate[hand] = world_to_yaw @ (full[:3] @ v - base_velocity)
            x, y, _ = place[hand].tolist()
            rate[hand, 0] += yaw_rate * y
            rate[hand, 1] -= yaw_rate * x
            carried[hand] = rate[hand] - jacobian[hand] @ v[columns]
        return HandMotion(place, rate, carried, jacobian, wrench_jacobian, yaw_to_world, base_to_world)


def _consecutive(indices: NDArray[np.intp]) -> slice:
    """The joints of a limb as a slice, which reads an array without copying it."""
    return slice(int(indices[0]), int(indices[-1]) + 1)


def _yaw(base_to_world: Array, angular_velocity: Array) -> tuple[Array, float]:
    """Rotation about z by the base's yaw, and the yaw's rate [rad/s].

    Yaw is the direction of the base's x axis on the ground, atan2(c_y, c_x); its rate follows from
    ċ = ω × c, exact at any tilt below 90°.
    """
    cx, cy, cz = base_to_world[:, 0].tolist()
    wx, wy, wz = angular_velocity.tolist()
    level = math.hypot(cx, cy)
    c, s = cx / level, cy / level
    rate = (cx * (wz * cx - wx * cz) - cy * (wy * cz - wz * cy)) / level**2
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), rate


def return_velocity(error: Array, error_rate: Array, proportional: float, differential: float) -> Array:
    """Hand velocity that leads back to the place: `v_ref = K_P x_err + K_D ẋ_err`.

    The point that the impedance's springs pull to moves with it, which makes it integral action:
    under a constant force the hand yields, then returns with the time constant (1 + K_D)/K_P.

    Args:
        error: x_err = x_d − x, shape (..., 3) [m].
        error_rate: Its rate, shape (..., 3) [m/s].
        proportional: K_P [1/s].
        differential: K_D.

    Reference: Savić et al. 2016, eqs. (17), (18).
    """
    return proportional * error + differential * error_rate


def limited_return(velocity: Array, virtual_force: Array, limit: Array) -> Array:
    """Stops an axis of v_ref that would stretch the virtual spring beyond its force limit.

    A hand that somebody holds away from its place would otherwise pull ever harder.

    Args:
        velocity: v_ref, shape (..., 3) [m/s].
        virtual_force: Force of the impedance's springs, shape (..., 3) [N].
        limit: Shape (3,) [N].
    """
    winding = (np.abs(virtual_force) >= limit) & (velocity * virtual_force > 0.0)
    return np.where(winding, 0.0, velocity)
