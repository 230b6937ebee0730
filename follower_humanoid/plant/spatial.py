"""Small vectors, fast."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import Array


def cross(a: Array, b: Array) -> Array:
    """Vector product a × b of two 3-vectors; ten times as fast as `np.cross`."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))
