"""Zero moment point, from what the feet measure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array, Wrench


@dataclass(frozen=True)
class ZmpConfig:
    """What it takes for a ZMP, a foot or a point of a sole to count."""

    force_floor: float = parameter(50.0, "no ZMP below this vertical force", "N", 1, 500)
    carrying: float = parameter(20.0, "a foot with more than this carries", "N", 1, 500)
    clearance: float = parameter(
        0.003, "sole points higher than this are left out of the polygon", "m", 1e-4, 0.05
    )


@kernel_part
def turned(axes: Array, vector: Array) -> tuple[float, float, float]:
    """A vector that is given along three axes, of which each is a row, in plain numbers."""
    return (
        axes[0, 0] * vector[0] + axes[1, 0] * vector[1] + axes[2, 0] * vector[2],
        axes[0, 1] * vector[0] + axes[1, 1] * vector[1] + axes[2, 1] * vector[2],
        axes[0, 2] * vector[0] + axes[1, 2] * vector[1] + axes[2, 2] * vector[2],
    )


@kernel_part
def moved_to_origin(force: Array, torque: Array, frame: Array) -> tuple[Array, Array]:
    """Force and moment about the world origin in world axes, shape (3,) each, of a wrench at and in a frame.

    Args:
        force, torque: The wrench, shape (3,) each [N], [N·m].
        frame: Its axes and origin in world, shape (4, 3), as in `robot.pose_table`.
    """
    fx, fy, fz = turned(frame, force)
    mx, my, mz = turned(frame, torque)
    x, y, z = frame[3, 0], frame[3, 1], frame[3, 2]
    moment = np.array([mx + y * fz - z * fy, my + z * fx - x * fz, mz + x * fy - y * fx])
    return np.array([fx, fy, fz]), moment


def measured_zmp(
    left: Wrench, right: Wrench, left_sole: Array, right_sole: Array, force_floor: float
) -> Array | None:
    """The point of the ground about which the feet's wrench has no horizontal moment.

    p_x = −M_y/F_z, p_y = M_x/F_z with force and moment of both feet about the world origin, ground z = 0.

    Args:
        left, right: Ground on foot, at and in the sole frames.
        left_sole, right_sole: Axes and origin in world, shape (4, 3), as in `robot.pose_table`.
        force_floor: Smallest vertical force [N].

    Returns:
        ZMP over the ground, shape (2,) [m]; None where the feet carry less than the floor.
    """
    vertical, m_x, m_y = _feet_about_origin(
        left.force, left.torque, left_sole, right.force, right.torque, right_sole
    )
    if vertical < force_floor:
        return None
    return np.array([-m_y / vertical, m_x / vertical])


@kernel(
    "UniTuple(float64, 3)(float64[::1], float64[::1], float64[:,::1],"
    " float64[::1], float64[::1], float64[:,::1])"
)
def _feet_about_origin(
    left_force: Array, left_torque: Array, left_sole: Array,
    right_force: Array, right_torque: Array, right_sole: Array,
) -> tuple[float, float, float]:  # fmt: skip
    """Vertical force and horizontal moments about the world origin of both feet; as in `moved_to_origin`."""
    force_left, moment_left = moved_to_origin(left_force, left_torque, left_sole)
    force_right, moment_right = moved_to_origin(right_force, right_torque, right_sole)
    return (
        force_left[2] + force_right[2], moment_left[0] + moment_right[0], moment_left[1] + moment_right[1]
    )  # fmt: skip
