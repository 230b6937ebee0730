"""Where the body is and how it moves: one Pinocchio pass for a state, read without copies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import BASE_DOF, Indices, RobotModel
from follower_humanoid.robot.pose_table import pose_table, velocity_table

BASE_JOINT = 1  # Pinocchio's joint 0 is the universe


class BodyState:
    """Kinematics and centroidal momentum of one state at a time.

    All attributes are views that follow `update`: what must outlive it, copy.

    Attributes:
        frames: Axes and origin of every frame in world, shape (n, 4, 3), see `pose_table`.
        base: The same of `base_link`, shape (4, 3).
        base_twist: Linear [m/s], then angular velocity [rad/s] of `base_link` in world, shape (2, 3).
        twists: The same of the frames asked for, at their origins, shape (n, 2, 3).
        com: CoM in world, shape (3,) [m].
        com_velocity: Shape (3,) [m/s].
        angular_momentum: About the CoM in world, shape (3,) [kg·m²/s].
    """

    def __init__(self, robot: RobotModel, moving: Sequence[str] = ()) -> None:
        """Args: the robot, and the frames whose twists are asked for; no state before the first `update`."""
        self._model = robot.pin_model
        self._data = data = self._model.createData()
        self.frames = pose_table(data.oMf)
        self._joints, self._velocities = pose_table(data.oMi), velocity_table(data.v)
        self.base = self._joints[BASE_JOINT]
        self.base_twist: Array = np.zeros((2, 3))
        self.com: Array = data.com[0]
        self.com_velocity: Array = data.vcom[0]
        self.angular_momentum: Array = data.hg.angular
        infos = [self._model.frames[robot.frame_id(name)] for name in moving]
        self._carriers: Indices = np.array([info.parentJoint for info in infos], dtype=np.intp)
        self._offsets: Array = np.array([info.placement.translation for info in infos]).reshape(-1, 3)
        self.twists: Array = np.zeros((len(infos), 2, 3))

    def update(self, q: Array, v: Array) -> None:
        """Takes over a state: q, shape (52,), and v, shape (51,), as in `RobotModel.state`."""
        pin.computeCentroidalMomentum(self._model, self._data, q, v)
        pin.updateFramePlacements(self._model, self._data)
        v[:BASE_DOF].reshape(2, 3).dot(self.base[:3], self.base_twist)
        if self._carriers.size:
            _write_twists(self._joints, self._velocities, self._carriers, self._offsets, self.twists)


@kernel_part
def _turn(axes: Array, x: float, y: float, z: float, result: Array) -> None:
    """Writes a vector x, y, z that is given along three axes; sums go as in Pinocchio."""
    for row in range(2):
        result[row] = axes[0, row] * x + axes[1, row] * y + axes[2, row] * z
    result[2] = axes[0, 2] * x + (axes[1, 2] * y + axes[2, 2] * z)


@kernel("void(float64[:,:,::1], float64[:,:,::1], intp[::1], float64[:,::1], float64[:,:,::1])")
def _write_twists(joints: Array, velocities: Array, carriers: Indices, offsets: Array, twists: Array) -> None:
    """ẋ = R(v + ω × r) and R ω of frames on joints, in axes of world.

    Args:
        joints: Poses of all joints, shape (joints, 4, 3).
        velocities: v and ω of all joints in their own axes, shape (joints, 2, 3).
        carriers: Which joint carries each frame, shape (n,).
        offsets: r, origin of each frame in the axes of its joint, shape (n, 3) [m].
        twists: Written, shape (n, 2, 3).
    """
    for n in range(carriers.size):
        axes, r = joints[carriers[n], :3], offsets[n]
        v, w = velocities[carriers[n], 0], velocities[carriers[n], 1]
        x = v[0] + (w[1] * r[2] - w[2] * r[1])
        y = v[1] + (w[2] * r[0] - w[0] * r[2])
        z = v[2] + (w[0] * r[1] - w[1] * r[0])
        _turn(axes, x, y, z, twists[n, 0])
        _turn(axes, w[0], w[1], w[2], twists[n, 1])
