"""Keeps count of how the ZMP fares: margin to the support polygon, error against its command."""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.balance.zmp import polygon_margin
from follower_humanoid.core.samples import Array


class ZmpWatch:
    """Running margin and error of the ZMP, for the diagnostics."""

    def __init__(self) -> None:
        self._margin: float | None = None
        self._smallest = math.inf
        self._commanded: Array | None = None
        self._squares: Array = np.zeros(2)
        self._count = 0

    def command(self, zmp: Array) -> None:
        """The ZMP that the next tick should have, in world, shape (2,) [m]."""
        self._commanded = zmp

    def see(self, zmp: Array | None, polygon: Array | None, ahead: Array) -> None:
        """The measured ZMP and support polygon of a tick.

        Args:
            zmp: In world, shape (2,) [m]; None where there is none.
            polygon: Vertices in world, shape (n, 2) [m]; None where no foot carries.
            ahead: Direction of the pelvis over the ground, shape (2,); need not be of length 1.
        """
        self._margin = None if zmp is None or polygon is None else polygon_margin(polygon, zmp)
        if self._margin is not None:
            self._smallest = min(self._smallest, self._margin)
        if zmp is None or self._commanded is None:
            return
        heading = ahead / max(math.hypot(ahead[0], ahead[1]), 1e-9)
        error = self._commanded - zmp
        along = heading[0] * error[0] + heading[1] * error[1]
        across = heading[0] * error[1] - heading[1] * error[0]
        self._squares = self._squares + np.array([along**2, across**2])
        self._count += 1

    def diagnostics(self) -> dict[str, float | str]:
        """Margin now and at its smallest, error along and across the heading, rms."""
        if self._margin is None:
            return {"zmp_margin [m]": "no ZMP"}
        along, across = np.sqrt(self._squares / max(self._count, 1))
        return {
            "zmp_margin [m]": self._margin,
            "smallest_zmp_margin [m]": self._smallest,
            "zmp_error_along [m]": float(along),
            "zmp_error_across [m]": float(across),
        }
