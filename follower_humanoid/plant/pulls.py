"""Wrenches that people and things put on the robot, and the points where they act."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import Indices


class Pull(NamedTuple):
    """A wrench on the robot during one physics step.

    Attributes:
        frame: Pinocchio frame at whose origin it acts.
        force: In world, shape (3,) [N].
        torque: About the frame's origin, in world, shape (3,) [N·m].
    """

    frame: int
    force: Array
    torque: Array


@dataclass(frozen=True)
class HeldPoint:
    """What the model says about a frame that is pulled.

    Attributes:
        joint: Pinocchio joint that carries it.
        offset: Its origin in the joint's frame, shape (3,) [m].
        columns: Columns of the Jacobian that move the joint.
    """

    joint: int
    offset: Array
    columns: Indices


def held_point(model: pin.Model, frame: int) -> HeldPoint:
    """Looks a frame up."""
    info = model.frames[frame]
    joints = [model.joints[joint] for joint in model.supports[info.parentJoint] if joint > 0]
    columns = [joint.idx_v + n for joint in joints for n in range(joint.nv)]
    return HeldPoint(int(info.parentJoint), info.placement.translation.copy(), np.array(columns))


@kernel(
    "void(float64[:,::1], float64[::1], float64[::1], float64[::1], float64[::1,:], int64[::1], "
    "float64[::1], float64[::1])"
)
def add_pull(
    pose: Array, offset: Array, force: Array, torque: Array, twists: Array, columns: Indices,
    place: Array, forces: Array,
) -> None:  # fmt: skip
    """Adds Jᵀ (f, x × f + τ) to the generalised forces; writes where the pull acts.

    Args:
        pose: Of the joint in world, see `robot.pose_table`, (4, 3).
        offset: In the joint's frame, (3,).
        force, torque: f and τ, in world, (3,).
        twists: World Jacobian, (6, ≥ columns).
        columns: Those that move the joint.
        place: Written: x in world, (3,).
        forces: Changed, (≥ columns,).
    """
    for axis in range(3):
        turned = pose[0, axis] * offset[0] + pose[1, axis] * offset[1] + pose[2, axis] * offset[2]
        place[axis] = pose[3, axis] + turned
    moment_x = torque[0] + place[1] * force[2] - place[2] * force[1]
    moment_y = torque[1] + place[2] * force[0] - place[0] * force[2]
    moment_z = torque[2] + place[0] * force[1] - place[1] * force[0]
    for column in columns:
        forces[column] += (
            force[0] * twists[0, column] + force[1] * twists[1, column] + force[2] * twists[2, column]
            + moment_x * twists[3, column] + moment_y * twists[4, column] + moment_z * twists[5, column]
        )  # fmt: skip


@kernel("void(float64[:,::1], float64[::1], float64[::1], float64[::1], float64[::1])")
def add_in_joint(pose: Array, offset: Array, force: Array, torque: Array, total: Array) -> None:
    """Adds a pull at and in its joint's frame: (Rᵀ f, Rᵀ τ + offset × Rᵀ f).

    Args:
        pose: Of the joint in world, see `robot.pose_table`, (4, 3).
        offset: Where it acts in the joint's frame, (3,).
        force, torque: f and τ, in world, (3,).
        total: Changed, (6,).
    """
    fx = pose[0, 0] * force[0] + pose[0, 1] * force[1] + pose[0, 2] * force[2]
    fy = pose[1, 0] * force[0] + pose[1, 1] * force[1] + pose[1, 2] * force[2]
    fz = pose[2, 0] * force[0] + pose[2, 1] * force[1] + pose[2, 2] * force[2]
    total[0] += fx
    total[1] += fy
    total[2] += fz
    for axis in range(3):
        total[3 + axis] += pose[axis, 0] * torque[0] + pose[axis, 1] * torque[1] + pose[axis, 2] * torque[2]
    total[3] += offset[1] * fz - offset[2] * fy
    total[4] += offset[2] * fx - offset[0] * fz
    total[5] += offset[0] * fy - offset[1] * fx
