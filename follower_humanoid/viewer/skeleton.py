"""Where every frame of the robot is, from joint angles and base pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import Array, Joints, Odometry, Side
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.resources import share_path
from follower_humanoid.robot.model import SOLE_OUTLINE
from follower_humanoid.robot.pose_table import pose_table


class Skeleton:
    """Forward kinematics of one posture after the other.

    Attributes:
        urdf: Text of the model.
        joint_names: Order of the joints in a posture.
        frames: All frames in world, shape (n, 4, 3): of each the axes x, y, z, then the origin [m].
    """

    def __init__(self, urdf: str = "", joint_names: Sequence[str] = ()) -> None:
        """Makes the model.

        Args:
            urdf: Text of the URDF; empty: the package's own.
            joint_names: Order of the joints in what is placed; empty: that of the model.

        Raises:
            ConfigurationError: The URDF is malformed or has other joints.
        """
        self.urdf = urdf or share_path("urdf/follower.urdf").read_text(encoding="utf-8")
        try:
            self._model = pin.buildModelFromXML(self.urdf, pin.JointModelFreeFlyer())
        except (ValueError, RuntimeError) as error:
            raise ConfigurationError(f"the URDF is malformed: {' '.join(str(error).split())}") from None
        own = tuple(self._model.names)[2:]
        self.joint_names = tuple(joint_names) or own
        if set(self.joint_names) != set(own):
            raise ConfigurationError("the URDF does not have the joints of the robot that is shown")
        self._columns = [self.joint_names.index(name) for name in own]
        self._data = self._model.createData()
        self.frames = pose_table(self._data.oMf)
        self._ids = {frame.name: number for number, frame in enumerate(self._model.frames)}
        self.standing()

    def standing(self) -> None:
        """Places the zero posture with the soles on the ground."""
        q = pin.neutral(self._model)
        pin.framesForwardKinematics(self._model, self._data, q)
        q[2] = -self.pose("l_sole").translation[2]
        pin.framesForwardKinematics(self._model, self._data, q)

    def place(self, odometry: Odometry, joints: Joints) -> None:
        """Takes a posture; what is asked for afterwards is of this one."""
        q = np.concatenate((odometry.position, odometry.quat_xyzw, joints.position[self._columns]))
        pin.framesForwardKinematics(self._model, self._data, q)

    def pose(self, frame: str) -> pin.SE3:
        """Placement of a frame of the URDF in world."""
        return self._data.oMf[self._ids[frame]]

    def index(self, frame: str) -> int:
        """Row of a frame of the URDF in `frames`."""
        return self._ids[frame]

    def position(self, frame: str) -> Array:
        """Origin of a frame in world, shape (3,) [m]."""
        origin: Array = self.frames[self._ids[frame], 3].copy()
        return origin

    def sole_outline(self, side: Side) -> Array:
        """Corners of a sole in order with its toe as it is, in the sole frame, shape (6, 3) [m]."""
        sole = self.pose(f"{side.prefix}_sole")
        return np.array([sole.actInv(self.position(f"{side.prefix}_contact_{n}")) for n in SOLE_OUTLINE])
