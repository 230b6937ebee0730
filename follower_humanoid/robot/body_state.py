"""Where the body is and how it moves: one Pinocchio pass for a state, read without copies."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import BASE_DOF, RobotModel
from follower_humanoid.robot.pose_table import pose_table

BASE_JOINT = 1  # Pinocchio's joint 0 is the universe
IN_WORLD_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class BodyState:
    """Kinematics and centroidal momentum of one state at a time.

    All attributes are views that follow `update`: what must outlive it, copy.

    Attributes:
        frames: Axes and origin of every frame in world, shape (n, 4, 3), see `pose_table`.
        base: The same of `base_link`, shape (4, 3).
        angular_velocity: Of `base_link` in world, shape (3,) [rad/s].
        com: CoM in world, shape (3,) [m].
        com_velocity: Shape (3,) [m/s].
        angular_momentum: About the CoM in world, shape (3,) [kg·m²/s].
    """

    def __init__(self, robot: RobotModel) -> None:
        """Args: the robot; there is no state before the first `update`."""
        self._model = robot.pin_model
        self._data = data = self._model.createData()
        self.frames = pose_table(data.oMf)
        self.base = pose_table(data.oMi)[BASE_JOINT]
        self._rotation = self.base[:3].T
        self.angular_velocity: Array = np.zeros(3)
        self.com: Array = data.com[0]
        self.com_velocity: Array = data.vcom[0]
        self.angular_momentum: Array = data.hg.angular

    def update(self, q: Array, v: Array) -> None:
        """Takes over a state: q, shape (52,), and v, shape (51,), as in `RobotModel.state`."""
        pin.computeCentroidalMomentum(self._model, self._data, q, v)
        pin.updateFramePlacements(self._model, self._data)
        self._rotation.dot(v[3:BASE_DOF], self.angular_velocity)

    def twist(self, frame: int) -> Array:
        """Linear, then angular velocity of a frame at its origin, in axes of world, shape (6,)."""
        twist: Array = pin.getFrameVelocity(self._model, self._data, frame, IN_WORLD_AXES).vector
        return twist
