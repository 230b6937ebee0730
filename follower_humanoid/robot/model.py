"""The rigid-body model every node shares: Pinocchio model, joint groups, frames, state vectors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from follower_humanoid.core.samples import Array, Joints, Odometry, Side
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.resources import share_path
from follower_humanoid.robot.urdf_file import read_urdf

GRAVITY = 9.81
BASE_DOF = 6
ACTUATED = 45
Indices = NDArray[np.intp]
SOLE_OUTLINE = (1, 3, 5, 6, 4, 2)
"""Contact points along the one edge of a sole and back along the other."""

_LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll", "toe_pitch")
_ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_yaw", "wrist_pitch", "wrist_roll")


@dataclass(frozen=True)
class JointGroups:
    """Indices into the 45 actuated joints, in the order of `RobotModel.joint_names`.

    `legs` is what the leg controller drives (legs, trunk, neck), `arms` the arm controller's share.
    """

    left_leg: Indices
    right_leg: Indices
    left_arm: Indices
    right_arm: Indices
    trunk: Indices
    neck: Indices
    legs: Indices
    arms: Indices

    def leg(self, side: Side) -> Indices:
        """Seven joints from hip yaw to toe."""
        return self.left_leg if side is Side.LEFT else self.right_leg

    def arm(self, side: Side) -> Indices:
        """Seven joints from shoulder pitch to wrist roll."""
        return self.left_arm if side is Side.LEFT else self.right_arm


class RobotModel:
    """Pinocchio model of the follower with a free-flyer base at `base_link`.

    Configuration q (52): base position in world, base quaternion (x, y, z, w), 45 joints.
    Velocity v (51): base linear and angular velocity in base_link axes, 45 joint velocities.

    Attributes:
        pin_model: The Pinocchio model; make a `pin.Data` of your own from it.
        joint_names: The 45 actuated joints in model order, which is the order of `joint_states`.
        groups: Index groups into `joint_names`.
        lower, upper: Joint ranges, shape (45,) [rad].
        mass: Total mass [kg].
        urdf: The URDF text the model was made from.
    """

    def __init__(self, urdf: str = "") -> None:
        """Loads the URDF file at path `urdf`, or the package's own.

        Raises:
            ConfigurationError: Not a URDF of this robot's structure.
        """
        path = Path(urdf) if urdf else share_path("urdf/follower.urdf")
        self.urdf = read_urdf(path)
        try:
            self.pin_model: pin.Model = pin.buildModelFromXML(self.urdf, pin.JointModelFreeFlyer())
        except (ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split()) or "not well-formed"
            raise ConfigurationError(f"URDF {path} is malformed: {reason}") from None
        self.joint_names: tuple[str, ...] = tuple(self.pin_model.names)[2:]
        if self.pin_model.nv != BASE_DOF + ACTUATED:
            raise ConfigurationError(
                f"URDF {path} has {self.pin_model.nv} degrees of freedom; needs {BASE_DOF + ACTUATED}"
            )
        self.groups = self._joint_groups()
        self.lower: Array = np.array(self.pin_model.lowerPositionLimit[7:])
        self.upper: Array = np.array(self.pin_model.upperPositionLimit[7:])
        self.mass = float(sum(inertia.mass for inertia in self.pin_model.inertias))
        self._last_state: tuple[Odometry, Joints, tuple[Array, Array]] | None = None

    def joint_index(self, name: str) -> int:
        """Index into the 45 actuated joints."""
        if name not in self.joint_names:
            raise UnknownNameError("joint", name, self.joint_names)
        return self.joint_names.index(name)

    def frame_id(self, name: str) -> int:
        """Pinocchio id of a URDF link or frame."""
        if not self.pin_model.existFrame(name):
            raise UnknownNameError("frame", name, [frame.name for frame in self.pin_model.frames])
        return int(self.pin_model.getFrameId(name))

    def configuration(self, odometry: Odometry, position: Array) -> Array:
        """q, shape (52,), from the base pose and the 45 joint positions."""
        return np.concatenate((odometry.position, odometry.quat_xyzw, position))

    def velocity(self, odometry: Odometry, joint_velocity: Array) -> Array:
        """v, shape (51,), from the base twist and the 45 joint velocities."""
        return np.concatenate((odometry.linear_velocity, odometry.angular_velocity, joint_velocity))

    def state(self, odometry: Odometry, joints: Joints) -> tuple[Array, Array]:
        """(q, v) of a robot state, not to be written to: all components of a process ask for the same one."""
        last = self._last_state
        if last is not None and last[0] is odometry and last[1] is joints:
            return last[2]
        state = (
            self.configuration(odometry, joints.position),
            self.velocity(odometry, joints.velocity),
        )
        self._last_state = (odometry, joints, state)
        return state

    def _joint_groups(self) -> JointGroups:
        def indices(names: list[str]) -> Indices:
            return np.array([self.joint_index(name) for name in names], dtype=np.intp)

        left_leg, right_leg = (indices([f"{p}_{name}" for name in _LEG]) for p in "lr")
        left_arm, right_arm = (indices([f"{p}_{name}" for name in _ARM]) for p in "lr")
        trunk = indices([name for name in self.joint_names if name.startswith("spine_")])
        neck = indices(["neck_yaw", "neck_pitch"])
        return JointGroups(
            left_leg=left_leg, right_leg=right_leg, left_arm=left_arm, right_arm=right_arm,
            trunk=trunk, neck=neck,
            legs=np.concatenate((left_leg, right_leg, trunk, neck)),
            arms=np.concatenate((left_arm, right_arm)),
        )  # fmt: skip
