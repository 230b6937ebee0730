"""The hands' task: where they are relative to the pelvis, and what moves them there.

The place of a hand is its gripper's position relative to `base_link` in pelvis-yaw axes (x ahead
of the pelvis, z up). Holding that place constant is eq. (18) with the offset turned by the base's
yaw and ẋ_d fed forward: world translation and turns of the pelvis drop out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.robot.model import Indices, RobotModel
from follower_humanoid.robot.placed_frames import PlacedFrames

_ARM_JOINTS = 7
_BASE_JOINT = 1  # Pinocchio's joint 0 is the universe
Mask = NDArray[np.bool_]


class HandMotion(NamedTuple):
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
        self._grippers = PlacedFrames(robot, self._data, [f"{side.prefix}_gripper" for side in SIDES])
        columns = [np.flatnonzero(moved) for moved in self._grippers.moved_by]
        self._columns: Indices = np.array(columns)  # base, trunk, own arm

    def motion(self, q: Array, v: Array, kept: HandMotion | None = None) -> HandMotion:
        """Both hands at state (q, v), shapes (52,), (51,).

        Who needs no motion but the newest may give the last one as `kept`: it is written over.
        """
        pin.computeJointJacobians(self._model, self._data, q)
        grippers, motion = self._grippers, kept or unwritten_motion()
        _hand_motion(
            grippers.poses, grippers.joints, grippers.offsets, grippers.world_jacobian, self._columns, q, v,
            *motion,
        )  # fmt: skip
        return motion


def unwritten_motion() -> HandMotion:
    """Memory for a motion: compiled code that made the arrays itself would take longer to hand them over."""
    return HandMotion(
        place=np.empty((2, 3)), place_rate=np.empty((2, 3)), carried=np.empty((2, 3)),
        jacobian=np.empty((2, 3, _ARM_JOINTS)), wrench_jacobian=np.empty((2, 6, _ARM_JOINTS)),
        yaw_to_world=np.empty((3, 3)), base_to_world=np.empty((3, 3)),
    )  # fmt: skip


@kernel_part
def _yaw(base_axes: Array, v: Array, rotation: Array) -> float:
    """The rate of the base's yaw [rad/s]; writes the rotation about z by it, (3, 3).

    Yaw is the direction c of the base's x axis on the ground, atan2(c_y, c_x); its rate follows from
    ċ = ω × c, exact at any tilt below 90°.
    """
    w = np.zeros(3)
    for axis in range(3):
        for row in range(3):
            w[row] += base_axes[axis, row] * v[3 + axis]
    cx, cy, cz = base_axes[0]
    level = math.hypot(cx, cy)
    rotation[:] = 0.0
    rotation[0, 0] = rotation[1, 1] = cx / level
    rotation[1, 0], rotation[0, 1] = cy / level, -cy / level
    rotation[2, 2] = 1.0
    rate: float = (cx * (w[2] * cx - w[0] * cz) - cy * (w[1] * cz - w[2] * cy)) / level**2
    return rate


@kernel_part
def _twist_at(world_jacobian: Array, column: int, position: Array, twist: Array) -> None:
    """A column of the world Jacobian is a twist (u, w) at the origin of world: (u + w × p, w) at p."""
    for row in range(6):
        twist[row] = world_jacobian[row, column]
    twist[0] += twist[4] * position[2] - twist[5] * position[1]
    twist[1] += twist[5] * position[0] - twist[3] * position[2]
    twist[2] += twist[3] * position[1] - twist[4] * position[0]


@kernel_part
def _turn_back(rotation: Array, vector: Array, result: Array) -> None:
    """`Rᵀ x`."""
    for row in range(3):
        result[row] = 0.0
        for column in range(3):
            result[row] += rotation[column, row] * vector[column]


@kernel_part
def _turn_jacobian_back(rotation: Array, linear: Array, result: Array) -> None:
    """`Rᵀ J`; of `linear` the first three rows."""
    for axis in range(3):
        for joint in range(result.shape[1]):
            result[axis, joint] = 0.0
            for row in range(3):
                result[axis, joint] += rotation[row, axis] * linear[row, joint]


@kernel(
    "void(float64[:,:,::1], intp[::1], float64[:,::1], float64[::1,:], intp[:,::1], float64[::1], "
    "float64[::1], float64[:,::1], float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1], "
    "float64[:,::1], float64[:,::1])"
)
def _hand_motion(
    poses: Array, joints: Indices, offsets: Array, world_jacobian: Array, columns: Indices,
    q: Array, v: Array, place: Array, place_rate: Array, carried: Array, jacobian: Array,
    wrench_jacobian: Array, yaw_to_world: Array, base_to_world: Array,
) -> None:  # fmt: skip
    """Writes a `HandMotion` from Pinocchio's poses and Jacobian; the last `columns` are the own arm's."""
    base_axes = poses[_BASE_JOINT, :3]
    yaw_rate = _yaw(base_axes, v, yaw_to_world)
    base_to_world[:] = base_axes.T
    first = columns.shape[1] - _ARM_JOINTS
    position, twist, by_body, by_arm = np.empty(3), np.empty(6), np.empty(3), np.empty(3)
    for hand in range(2):
        pose = poses[joints[hand]]
        for row in range(3):
            position[row] = pose[3, row]
            for axis in range(3):
                position[row] += pose[axis, row] * offsets[hand, axis]
        by_body[:] = by_arm[:] = 0.0
        for n in range(3, columns.shape[1]):  # the base's own translation moves no place
            column = columns[hand, n]
            _twist_at(world_jacobian, column, position, twist)
            moved = by_body if n < first else by_arm
            for row in range(3):
                moved[row] += twist[row] * v[column]
            if n >= first:
                wrench_jacobian[hand, :, n - first] = twist
        for row in range(3):
            position[row] -= q[row]
        _turn_back(yaw_to_world, position, place[hand])
        _turn_back(yaw_to_world, by_body, carried[hand])
        _turn_back(yaw_to_world, by_arm, place_rate[hand])
        _turn_jacobian_back(yaw_to_world, wrench_jacobian[hand], jacobian[hand])
        # The task axes turn with the pelvis.
        carried[hand, 0] += yaw_rate * place[hand, 1]
        carried[hand, 1] -= yaw_rate * place[hand, 0]
        for row in range(3):
            place_rate[hand, row] += carried[hand, row]


def forces_in_task_axes(task_to_world: Array, left: Array, right: Array) -> Array:
    """Forces on both hands, in world shape (3,) each, turned into the task's axes, shape (2, 3) [N]."""
    turned = np.zeros((2, 3))
    _add_in_task_axes(task_to_world, left, right, turned)
    return turned


@kernel("void(float64[:,::1], float64[:], float64[:], float64[:,::1])")
def _add_in_task_axes(task_to_world: Array, left: Array, right: Array, turned: Array) -> None:
    """Adds the forces of `forces_in_task_axes`."""
    for axis in range(3):
        for row in range(3):
            turned[0, axis] += task_to_world[row, axis] * left[row]
            turned[1, axis] += task_to_world[row, axis] * right[row]
