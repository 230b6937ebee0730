"""Where everything was during a run, by forward kinematics of the recorded joint states and odometry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.graph.record import Integers, Run
from follower_humanoid.robot.model import RobotModel


class SoleAt(NamedTuple):
    """A sole at some ticks: origins in world, shape (T, 3) [m], and headings, shape (T,) [rad]."""

    position: Array
    yaw: Array


@dataclass(frozen=True)
class Motion:
    """The motion of a run at the ticks of `joint_states`.

    Attributes:
        times: Shape (T,) [s].
        sole: Sole origins in world, shape (T, 3) per side [m].
        sole_rotation: Sole to world, shape (T, 3, 3) per side.
        sole_yaw: Heading of the soles, shape (T,) per side [rad].
        gripper: Gripper in world, shape (T, 3) per side [m].
        hand: Gripper in axes of the pelvis heading, relative to base_link, shape (T, 3) per side [m].
        com: CoM in world, shape (T, 3) [m].
        momentum: Linear momentum in world and angular momentum about the CoM, shape (T, 6).
        pelvis_yaw: Shape (T,) [rad].
        leg_gap: Smallest distance between the two legs, shape (T,) [m].
        contacts: Sole points in world, shape (T, 12, 3) [m]: six left, six right.
    """

    times: Array
    sole: dict[Side, Array]
    sole_rotation: dict[Side, Array]
    sole_yaw: dict[Side, Array]
    gripper: dict[Side, Array]
    hand: dict[Side, Array]
    com: Array
    momentum: Array
    pelvis_yaw: Array
    leg_gap: Array
    contacts: Array

    def sole_at(self, side: Side, ticks: Integers) -> SoleAt:
        """A sole at some ticks, where the motion has every tick from 0 on."""
        return SoleAt(self.sole[side][ticks], self.sole_yaw[side][ticks])


# Radii of the leg segments, as drawn: thigh, shank; the foot is wrapped by capsules along its edges.
_SEGMENTS = (("thigh", "shank", 0.065), ("shank", "ankle", 0.048))
_FOOT_EDGE = 0.01


def motion_of(run: Run, every: int = 1, robot: RobotModel | None = None) -> Motion:
    """Forward kinematics over a run.

    Args:
        run: The run.
        every: Take every n-th tick.
        robot: Model to use; the package's own by default.
    """
    robot = robot or RobotModel()
    model, data = robot.pin_model, robot.pin_model.createData()
    joints, odometry = run["joint_states"], run["odom"]
    rows = range(0, min(len(joints), len(odometry)), every)
    frames = {name: robot.frame_id(name) for name in _frame_names()}
    n = len(rows)
    sole = {side: np.zeros((n, 3)) for side in SIDES}
    turned = {side: np.zeros((n, 3, 3)) for side in SIDES}
    yaw = {side: np.zeros(n) for side in SIDES}
    grip = {side: np.zeros((n, 3)) for side in SIDES}
    hand = {side: np.zeros((n, 3)) for side in SIDES}
    com, momentum, pelvis_yaw = np.zeros((n, 3)), np.zeros((n, 6)), np.zeros(n)
    gap, contacts = np.zeros(n), np.zeros((n, 12, 3))
    for i, row in enumerate(rows):
        q = np.concatenate((odometry.position[row], odometry.quat_xyzw[row], joints.position[row]))
        v = np.concatenate(
            (odometry.linear_velocity[row], odometry.angular_velocity[row], joints.velocity[row])
        )
        pin.computeCentroidalMomentum(model, data, q, v)
        pin.updateFramePlacements(model, data)
        momentum[i], com[i] = data.hg.vector, data.com[0]
        rotation = data.oMi[1].rotation
        pelvis_yaw[i] = np.arctan2(rotation[1, 0], rotation[0, 0])
        c, s = np.cos(pelvis_yaw[i]), np.sin(pelvis_yaw[i])
        to_heading = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        for side in SIDES:
            place = data.oMf[frames[f"{side.prefix}_sole"]]
            sole[side][i], turned[side][i] = place.translation, place.rotation
            yaw[side][i] = np.arctan2(place.rotation[1, 0], place.rotation[0, 0])
            grip[side][i] = data.oMf[frames[f"{side.prefix}_gripper"]].translation
            hand[side][i] = to_heading @ (grip[side][i] - odometry.position[row])
        points = {name: np.array(data.oMf[frame].translation) for name, frame in frames.items()}
        contacts[i] = [points[f"{p}_contact_{k}"] for p in "lr" for k in range(1, 7)]
        gap[i] = _leg_gap(points)
    return Motion(
        joints.times[::every][:n], sole, turned, yaw, grip, hand, com, momentum, pelvis_yaw, gap, contacts
    )


def _frame_names() -> list[str]:
    names = [f"{p}_{n}" for p in "lr" for n in ("sole", "gripper", "thigh", "shank", "ankle")]
    return names + [f"{p}_contact_{k}" for p in "lr" for k in range(1, 7)]


def _capsules(points: dict[str, Array], prefix: str) -> list[tuple[Array, Array, float]]:
    """Segments of a leg with their radii: thigh, shank and the edges of the sole."""
    capsules = [(points[f"{prefix}_{a}"], points[f"{prefix}_{b}"], radius) for a, b, radius in _SEGMENTS]
    for a, b in ((1, 5), (2, 6), (1, 2), (5, 6)):
        capsules.append((points[f"{prefix}_contact_{a}"], points[f"{prefix}_contact_{b}"], _FOOT_EDGE))
    return capsules


def _leg_gap(points: dict[str, Array]) -> float:
    """Smallest distance between the surfaces of the left and the right leg [m]."""
    left, right = _capsules(points, "l"), _capsules(points, "r")
    p1 = np.array([a for a, _, _ in left for _ in right])
    q1 = np.array([b for _, b, _ in left for _ in right])
    p2 = np.array([a for _ in left for a, _, _ in right])
    q2 = np.array([b for _ in left for _, b, _ in right])
    radii = np.array([r1 + r2 for _, _, r1 in left for _, _, r2 in right])
    return float(np.min(segment_distances(p1, q1, p2, q2) - radii))


def segment_distances(p1: Array, q1: Array, p2: Array, q2: Array) -> Array:
    """Distances of pairs of line segments (Ericson, Real-Time Collision Detection, 5.1.9), shape (n,).

    Args:
        p1, q1: Ends of the first segments, shape (n, 3) [m].
        p2, q2: Ends of the second segments, shape (n, 3) [m].
    """
    d1, d2, r = q1 - p1, q2 - p2, p1 - p2
    a, e = np.sum(d1 * d1, 1), np.sum(d2 * d2, 1)
    b, c, f = np.sum(d1 * d2, 1), np.sum(d1 * r, 1), np.sum(d2 * r, 1)
    denominator = a * e - b * b
    parallel = denominator < 1e-12
    s = np.where(parallel, 0.0, (b * f - c * e) / np.where(parallel, 1.0, denominator))
    s = np.clip(s, 0.0, 1.0)
    t = (b * s + f) / e
    s = np.where(t < 0.0, np.clip(-c / a, 0.0, 1.0), np.where(t > 1.0, np.clip((b - c) / a, 0.0, 1.0), s))
    t = np.clip(t, 0.0, 1.0)
    gap = (p1 + s[:, None] * d1) - (p2 + t[:, None] * d2)
    return np.asarray(np.sqrt(np.sum(gap * gap, 1)))
