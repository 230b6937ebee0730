"""Keeps count of how the ZMP fares: margin to the support polygon, error against its command."""

from __future__ import annotations

import math

from follower_humanoid.balance.support_polygon import polygon_margin
from follower_humanoid.core.samples import Array


class ZmpWatch:
    """Running margin and error of the ZMP, for the diagnostics."""

    def __init__(self) -> None:
        self._margin: float | None = None
        self._smallest = math.inf
        self._commanded: tuple[float, float] | None = None
        self._square_along = self._square_across = 0.0
        self._count = 0

    def command(self, zmp: Array) -> None:
        """The ZMP that the next tick should have, in world, shape (≥ 2,) [m]."""
        x, y, *_ = zmp.tolist()
        self._commanded = x, y

    def see(self, zmp: Array | None, polygon: Array | None, ahead: Array) -> None:
        """The measured ZMP and support polygon of a tick.

        Args:
            zmp: In world, shape (2,) [m]; None where there is none.
            polygon: Vertices in world, shape (n, 3) [m]; None where no foot carries.
            ahead: Direction of the pelvis; only what is over the ground counts, of any length.
        """
        self._margin = None if zmp is None or polygon is None else polygon_margin(polygon, zmp)
        if self._margin is not None:
            self._smallest = min(self._smallest, self._margin)
        if zmp is None or self._commanded is None:
            return
        x, y, *_ = ahead.tolist()
        length = max(math.hypot(x, y), 1e-9)
        (wanted_x, wanted_y), (zmp_x, zmp_y) = self._commanded, zmp.tolist()
        e_x, e_y = wanted_x - zmp_x, wanted_y - zmp_y
        self._square_along += ((x * e_x + y * e_y) / length) ** 2
        self._square_across += ((x * e_y - y * e_x) / length) ** 2
        self._count += 1

    def diagnostics(self) -> dict[str, float | str]:
        """Margin now and at its smallest, error along and across the heading, rms; what is known of it."""
        values: dict[str, float | str] = {"zmp_margin [m]": "no ZMP"}
        if self._margin is not None:
            values["zmp_margin [m]"] = self._margin
        if self._smallest < math.inf:
            values["smallest_zmp_margin [m]"] = self._smallest
        if self._count:
            values["zmp_error_along [m]"] = math.sqrt(self._square_along / self._count)
            values["zmp_error_across [m]"] = math.sqrt(self._square_across / self._count)
        return values
