"""Frames of the robot as one set of Pinocchio data has them: where they are, and what wrenches there do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import Indices, RobotModel
from follower_humanoid.robot.pose_table import pose_table


class PlacedFrames:
    """Reads joint poses and the world Jacobian where Pinocchio leaves them: nothing is looked up again.

    Valid after `pin.computeJointJacobians`, or `pin.crba` in the world convention, on the same data.

    Attributes:
        poses: Of all joints, as `pose_table` has them: a view, shape (joints, 4, 3).
        world_jacobian: A view, shape (6, 51): column c is the twist of what coordinate c carries, per
            unit of its velocity; linear part of the point at the origin of world, then angular.
        joints: Which joint carries each frame, shape (n,).
        offsets: Origins of the frames in the axes of their joints, shape (n, 3) [m].
        axes: Of the frames (rows), in the axes of their joints, shape (n, 3, 3).
        moved_by: Which columns move each frame, shape (n, 51).
    """

    def __init__(self, robot: RobotModel, data: pin.Data, names: Sequence[str]) -> None:
        """The frames `names` in `data`, which is of the robot's model."""
        model = robot.pin_model
        infos = [model.frames[robot.frame_id(name)] for name in names]
        self._data = data  # owns the memory of the views
        self.poses = pose_table(data.oMi)
        self.world_jacobian: Array = data.J
        self.joints: Indices = np.array([info.parentJoint for info in infos], dtype=np.intp)
        self.offsets: Array = np.array([info.placement.translation for info in infos])
        self.axes: Array = np.array([info.placement.rotation.T for info in infos])
        self.moved_by: NDArray[np.bool_] = np.zeros((len(infos), model.nv), dtype=bool)
        for moved, joint in zip(self.moved_by, self.joints.tolist(), strict=True):
            for carrier in list(model.supports[joint])[1:]:
                first = model.joints[carrier].idx_v
                moved[first : first + model.joints[carrier].nv] = True

    def add_wrenches(self, wrenches: Array, in_frame: NDArray[np.bool_], forces: Array) -> None:
        """Adds the generalised forces of wrenches that act at the frames' origins.

        Args:
            wrenches: Force [N] and torque about the frame's origin [N·m], shape (n, 6).
            in_frame: Whether they are given in axes of the frame, else of world; shape (n,).
            forces: Added to, shape (51,).
        """
        _add_wrenches(
            self.poses, self.joints, self.offsets, self.axes, self.world_jacobian, self.moved_by,
            wrenches, in_frame, forces,
        )  # fmt: skip


@kernel_part
def _along(axes: Array, vector: Array, result: Array) -> None:
    """Writes a vector given along three axes, of which each is a row."""
    for row in range(3):
        result[row] = 0.0
        for axis in range(3):
            result[row] += axes[axis, row] * vector[axis]


@kernel(
    "void(float64[:,:,::1], intp[::1], float64[:,::1], float64[:,:,::1], float64[::1,:], boolean[:,::1],"
    " float64[:,::1], boolean[::1], float64[::1])"
)
def _add_wrenches(
    poses: Array, joints: Indices, offsets: Array, axes: Array, world_jacobian: Array,
    moved_by: NDArray[np.bool_], wrenches: Array, in_frame: NDArray[np.bool_], forces: Array,
) -> None:  # fmt: skip
    """`Q += Jᵀ (f, p × f + τ)`: power of each wrench, taken about the origin of world, on every column."""
    point, force, torque, turned = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for n in range(joints.size):
        joint_axes = poses[joints[n], :3]
        _along(joint_axes, offsets[n], point)
        for row in range(3):
            point[row] += poses[joints[n], 3, row]
        if in_frame[n]:
            _along(axes[n], wrenches[n, :3], turned)
            _along(joint_axes, turned, force)
            _along(axes[n], wrenches[n, 3:], turned)
            _along(joint_axes, turned, torque)
        else:
            force[:], torque[:] = wrenches[n, :3], wrenches[n, 3:]
        torque[0] += point[1] * force[2] - point[2] * force[1]
        torque[1] += point[2] * force[0] - point[0] * force[2]
        torque[2] += point[0] * force[1] - point[1] * force[0]
        for column in range(forces.size):
            if moved_by[n, column]:
                for row in range(3):
                    forces[column] += world_jacobian[row, column] * force[row]
                    forces[column] += world_jacobian[3 + row, column] * torque[row]
