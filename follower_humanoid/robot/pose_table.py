"""Pinocchio's poses and velocities as arrays that compiled loops can read: no object per frame, no copy."""

from __future__ import annotations

from typing import Any

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError

_NUMBER = np.dtype(float).itemsize
_POSE = 12  # numbers of a pose: the three axes, then the origin
_VELOCITY = 6  # numbers of a velocity: linear, then angular


def pose_table(poses: Any) -> Array:
    """A view of `data.oMf` or `data.oMi` that follows every later update of that data.

    Args:
        poses: Pinocchio's vector of poses. Its data must outlive the view.

    Returns:
        Shape (n, 4, 3): of each frame the axes x, y, z (columns of its rotation), then the origin [m], in
        world. `table[i, :3].T` is the rotation, `table[i, 3]` the translation.

    Raises:
        PhysicsError: This Pinocchio lays its poses out otherwise.
    """
    first, last = poses[0], poses[len(poses) - 1]
    start, end = _address(first.rotation), _address(last.rotation)
    in_rows = end - start == (len(poses) - 1) * _POSE * _NUMBER
    if not in_rows or any(
        _address(p.translation) != _address(p.rotation) + 9 * _NUMBER for p in (first, last)
    ):
        raise PhysicsError("this version of Pinocchio keeps its poses in an unknown order")
    strides = (_POSE * _NUMBER, 3 * _NUMBER, _NUMBER)
    return np.lib.stride_tricks.as_strided(first.rotation.T, (len(poses), 4, 3), strides)


def velocity_table(velocities: Any) -> Array:
    """A view of `data.v` that follows every later update of that data.

    Args:
        velocities: Pinocchio's vector of spatial velocities. Its data must outlive the view.

    Returns:
        Shape (n, 2, 3): of each joint linear [m/s], then angular velocity [rad/s], at and in its frame.

    Raises:
        PhysicsError: This Pinocchio lays its velocities out otherwise.
    """
    first, last = velocities[0], velocities[len(velocities) - 1]
    in_rows = _address(last.linear) - _address(first.linear) == (len(velocities) - 1) * _VELOCITY * _NUMBER
    if not in_rows or any(_address(m.angular) != _address(m.linear) + 3 * _NUMBER for m in (first, last)):
        raise PhysicsError("this version of Pinocchio keeps its velocities in an unknown order")
    strides = (_VELOCITY * _NUMBER, 3 * _NUMBER, _NUMBER)
    return np.lib.stride_tricks.as_strided(first.linear, (len(velocities), 2, 3), strides)


def _address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])
