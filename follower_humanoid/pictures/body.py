"""Where the body was: joints, frames and soles of a run at chosen ticks, by forward kinematics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import Array, Side
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.record import Integers, Run
from follower_humanoid.resources import share_path
from follower_humanoid.robot.model import SOLE_OUTLINE, RobotModel

# Lines from the end of a limb to what lies beyond its last joint: frame pairs, `?` stands for l and r.
_BEYOND = (
    ("?_wrist", "?_gripper"),
    ("head", "gaze"),
    ("?_ankle", "?_contact_1"),
    ("?_contact_1", "?_contact_3"),
    ("?_contact_3", "?_contact_5"),
    ("?_contact_5", "?_ankle"),
)


@dataclass(frozen=True)
class Lines:
    """The body as straight lines.

    Attributes:
        sides: Per line `l`, `r`, or empty for the middle of the body.
        ends: Both ends in world, shape (T, lines, 2, 3) [m].
    """

    sides: tuple[str, ...]
    ends: Array


@dataclass(frozen=True)
class Pose:
    """A frame over time.

    Attributes:
        position: In world, shape (T, 3) [m].
        rotation: Frame to world, shape (T, 3, 3).
    """

    position: Array
    rotation: Array

    @property
    def yaw(self) -> Array:
        """Direction of the frame's x axis over the ground, shape (T,) [rad]."""
        yaw: Array = np.arctan2(self.rotation[:, 1, 0], self.rotation[:, 0, 0])
        return yaw


class Body:
    """Forward kinematics of a recorded run.

    Attributes:
        urdf: Text of the model.
    """

    def __init__(self, run: Run) -> None:
        """Makes the model from the run's URDF, or from the package's where the run has none.

        Raises:
            ConfigurationError: The URDF is malformed or its joints are not those of the run.
        """
        urdf = run.urdf or share_path("urdf/follower.urdf").read_text(encoding="utf-8")
        try:
            self._model = pin.buildModelFromXML(urdf, pin.JointModelFreeFlyer())
        except (ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())
            raise ConfigurationError(f"the recorded URDF is malformed: {reason}") from None
        names = tuple(self._model.names)[2:]
        if set(names) != set(run.joint_names):
            raise ConfigurationError("the recorded URDF does not have the recorded joints")
        self._data = self._model.createData()
        self.urdf = urdf
        self._columns = np.array([run.joint_names.index(name) for name in names])
        self._run = run

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return float(sum(inertia.mass for inertia in self._model.inertias))

    @staticmethod
    def command_joints(arms: bool) -> tuple[str, ...]:
        """Joints in the order of `arms/command` or `legs/command`, which is the package's own."""
        robot = RobotModel()
        return tuple(robot.joint_names[i] for i in (robot.groups.arms if arms else robot.groups.legs))

    def configurations(self, ticks: Integers) -> Array:
        """Configurations q at the given ticks, shape (T, nq); a missing tick keeps the state before it."""
        odometry, joints = self._run["odom"], self._run["joint_states"]
        rows = np.maximum(joints.latest(ticks), 0)
        base = np.maximum(odometry.latest(ticks), 0)
        position = joints.position[rows][:, self._columns]
        return np.concatenate((odometry.position[base], odometry.quat_xyzw[base], position), axis=1)

    def pose(self, frame: str, ticks: Integers) -> Pose:
        """One frame of the URDF at the given ticks.

        Raises:
            UnknownNameError: No such frame.
        """
        if not self._model.existFrame(frame):
            raise UnknownNameError("frame", frame, [f.name for f in self._model.frames])
        number = self._model.getFrameId(frame)
        position, rotation = np.empty((len(ticks), 3)), np.empty((len(ticks), 3, 3))
        for row, q in enumerate(self.configurations(ticks)):
            pin.forwardKinematics(self._model, self._data, q)
            placement = pin.updateFramePlacement(self._model, self._data, number)
            position[row], rotation[row] = placement.translation, placement.rotation
        return Pose(position, rotation)

    def sole(self, side: Side, ticks: Integers) -> Pose:
        """A sole at the given ticks."""
        return self.pose(f"{side.prefix}_sole", ticks)

    def sole_outline(self, side: Side) -> Array:
        """Corners of a sole with its toe at zero, in order, in the sole frame, shape (6, 3) [m]."""
        pin.framesForwardKinematics(self._model, self._data, pin.neutral(self._model))
        placements = self._data.oMf
        sole = placements[self._model.getFrameId(f"{side.prefix}_sole")]
        ids = [self._model.getFrameId(f"{side.prefix}_contact_{number}") for number in SOLE_OUTLINE]
        return np.array([sole.actInv(placements[number].translation) for number in ids])

    def lines(self, ticks: Integers) -> Lines:
        """The body as lines between joints, and to gaze, grippers and the points of the soles."""
        model, data = self._model, self._data
        joints = [(model.parents[joint], joint) for joint in range(2, model.njoints)]
        frames = [
            (
                model.getFrameId(begin.replace("?", p)),
                model.getFrameId(end.replace("?", p)),
                p if "?" in begin else "",
            )
            for begin, end in _BEYOND
            for p in ("l", "r")
            if "?" in begin or p == "l"
        ]
        sides = [_side(model.names[child]) for _, child in joints] + [side for _, _, side in frames]
        ends = np.empty((len(ticks), len(sides), 2, 3))
        for row, q in enumerate(self.configurations(ticks)):
            pin.framesForwardKinematics(model, data, q)
            points = [(data.oMi[a].translation, data.oMi[b].translation) for a, b in joints]
            points += [(data.oMf[a].translation, data.oMf[b].translation) for a, b, _ in frames]
            ends[row] = points
        lengths = np.linalg.norm(ends[0, :, 1] - ends[0, :, 0], axis=1) if len(ticks) else np.ones(len(sides))
        keep = np.flatnonzero(lengths > 1e-6)
        return Lines(tuple(sides[index] for index in keep), ends[:, keep])


def _side(name: str) -> str:
    return name[0] if name.startswith(("l_", "r_")) else ""
