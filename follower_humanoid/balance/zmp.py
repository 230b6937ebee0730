"""Zero moment point, from what the feet measure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array, Wrench


@dataclass(frozen=True)
class ZmpConfig:
    """Force floors below which a foot or a ZMP does not count."""

    force_floor: float = parameter(50.0, "no ZMP below this vertical force", "N", 1, 500)
    carrying: float = parameter(20.0, "a foot with more than this carries", "N", 1, 500)
    clearance: float = parameter(
        0.003, "sole points higher than this are left out of the polygon", "m", 1e-4, 0.05
    )


@dataclass(frozen=True, slots=True)
class SolePlace:
    """A sole in world.

    Attributes:
        position: Sole origin, shape (3,) [m].
        rotation: Sole to world, shape (3, 3).
    """

    position: Array
    rotation: Array


@kernel("Tuple((float64, float64, float64))(float64[:,:], float64[::1])")
def turned(rotation: Array, vector: Array) -> tuple[float, float, float]:
    """`rotation @ vector` in plain numbers."""
    return (
        rotation[0, 0] * vector[0] + rotation[0, 1] * vector[1] + rotation[0, 2] * vector[2],
        rotation[1, 0] * vector[0] + rotation[1, 1] * vector[1] + rotation[1, 2] * vector[2],
        rotation[2, 0] * vector[0] + rotation[2, 1] * vector[1] + rotation[2, 2] * vector[2],
    )


@kernel("UniTuple(float64[::1], 2)(float64[::1], float64[::1], float64[::1], float64[:,:])")
def moved_to_origin(force: Array, torque: Array, position: Array, rotation: Array) -> tuple[Array, Array]:
    """Force and moment about the world origin in world axes of a wrench at and in a frame.

    Args:
        force, torque: The wrench, shape (3,) each [N], [N·m].
        position, rotation: Pose of the frame in world, shape (3,) [m] and (3, 3).
    """
    fx, fy, fz = turned(rotation, force)
    mx, my, mz = turned(rotation, torque)
    x, y, z = position[0], position[1], position[2]
    moment = np.array([mx + y * fz - z * fy, my + z * fx - x * fz, mz + x * fy - y * fx])
    return np.array([fx, fy, fz]), moment


def wrench_about_origin(wrench: Wrench, place: SolePlace) -> tuple[Array, Array]:
    """Force and moment about the world origin, both in world axes, shape (3,) each [N], [N·m]."""
    return moved_to_origin(wrench.force, wrench.torque, place.position, place.rotation)


def measured_zmp(
    left: Wrench, right: Wrench, left_place: SolePlace, right_place: SolePlace, force_floor: float
) -> Array | None:
    """The point of the ground about which the feet's wrench has no horizontal moment.

    p_x = −M_y/F_z, p_y = M_x/F_z with force and moment of both feet about the world origin, ground z = 0.

    Args:
        left, right: Ground on foot, at and in the sole frames.
        left_place, right_place: Soles in world.
        force_floor: Smallest vertical force [N].

    Returns:
        ZMP over the ground, shape (2,) [m]; None where the feet carry less than the floor.
    """
    vertical, m_x, m_y = _feet_about_origin(
        left.force, left.torque, left_place.position, left_place.rotation,
        right.force, right.torque, right_place.position, right_place.rotation,
    )  # fmt: skip
    if vertical < force_floor:
        return None
    return np.array([-m_y / vertical, m_x / vertical])


@kernel(
    "UniTuple(float64, 3)(float64[::1], float64[::1], float64[::1], float64[:,:],"
    " float64[::1], float64[::1], float64[::1], float64[:,:])"
)
def _feet_about_origin(
    left_force: Array, left_torque: Array, left_position: Array, left_rotation: Array,
    right_force: Array, right_torque: Array, right_position: Array, right_rotation: Array,
) -> tuple[float, float, float]:  # fmt: skip
    """Vertical force and horizontal moments about the world origin of both feet; as in `moved_to_origin`."""
    force_left, moment_left = moved_to_origin(left_force, left_torque, left_position, left_rotation)
    force_right, moment_right = moved_to_origin(right_force, right_torque, right_position, right_rotation)
    return (
        force_left[2] + force_right[2], moment_left[0] + moment_right[0], moment_left[1] + moment_right[1]
    )  # fmt: skip
