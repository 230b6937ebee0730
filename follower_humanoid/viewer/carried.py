"""Poses within links, carried into world, and whether one can be seen to have moved."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array

VISIBLE = 1e-4
"""A shorter way [m], or a smaller change of a quaternion, is not drawn."""

Singles = NDArray[np.float32]


@kernel_part
def quaternion(rotation: Array, wxyz: Array) -> None:
    """Writes the quaternion (w, x, y, z) of a rotation, by whichever of its parts is the largest."""
    trace = rotation[0, 0] + rotation[1, 1] + rotation[2, 2]
    i = 0
    if rotation[1, 1] > rotation[0, 0]:
        i = 1
    if rotation[2, 2] > rotation[i, i]:
        i = 2
    j, k = (i + 1) % 3, (i + 2) % 3
    if trace > 0.0:
        size = 2.0 * math.sqrt(1.0 + trace)
        wxyz[0] = 0.25 * size
        wxyz[1 + i] = (rotation[k, j] - rotation[j, k]) / size
        wxyz[1 + j] = (rotation[i, k] - rotation[k, i]) / size
        wxyz[1 + k] = (rotation[j, i] - rotation[i, j]) / size
    else:
        size = 2.0 * math.sqrt(1.0 + rotation[i, i] - rotation[j, j] - rotation[k, k])
        wxyz[0] = (rotation[k, j] - rotation[j, k]) / size
        wxyz[1 + i] = 0.25 * size
        wxyz[1 + j] = (rotation[j, i] + rotation[i, j]) / size
        wxyz[1 + k] = (rotation[k, i] + rotation[i, k]) / size


@kernel("boolean(float64[:,:,::1], int64[::1], float64[:,:,::1], float32[:,::1], float32[:,::1])")
def carry(frames: Array, rows: NDArray[np.int64], within: Array, positions: Singles, wxyz: Singles) -> bool:
    """Writes where things are now; False, and nothing is written, where none has visibly moved.

    A thing at s, turned by S, in a frame at p, turned by R, is at R s + p, turned by R S.

    Args:
        frames: In world, as `pose_table` has them, shape (·, 4, 3).
        rows: Frame of each thing, shape (n,).
        within: The things in their frames, laid out likewise, shape (n, 4, 3).
        positions, wxyz: As they were told last, in world, shapes (n, 3) [m] and (n, 4).
    """
    count = rows.shape[0]
    new_positions, new_wxyz = np.zeros((count, 3)), np.empty((count, 4))
    turned = np.empty((3, 3))
    for n in range(count):
        frame, thing = frames[rows[n]], within[n]
        turned[:] = 0.0
        for i in range(3):
            new_positions[n, i] = frame[3, i]
            for k in range(3):
                new_positions[n, i] += frame[k, i] * thing[3, k]
                for j in range(3):
                    turned[i, j] += frame[k, i] * thing[j, k]
        quaternion(turned, new_wxyz[n])
    moved = np.abs(new_positions - positions).max() > VISIBLE or np.abs(new_wxyz - wxyz).max() > VISIBLE
    if moved:
        positions[:] = new_positions
        wxyz[:] = new_wxyz
    return bool(moved)
