"""Half-steps found from the run itself: foot forces and sole poses, not what the controllers say of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.graph.record import Integers, Run

AIRBORNE = 5.0  # [N]
# About half the weight: a foot that carries it has settled, so there its place is read [N].
LANDED = 200.0
LIFTED = 0.015  # a swing raises the sole at least this far [m]
CLOSING = 0.10  # a shorter half-step only brings the feet together [m]


class SolePose(Protocol):
    """A sole at some ticks."""

    @property
    def position(self) -> Array:
        """Origin in world, shape (T, 3) [m]."""

    @property
    def yaw(self) -> Array:
        """Heading in world, shape (T,) [rad]."""


Sole = Callable[[Side, Integers], SolePose]
"""Where a sole was at the given ticks."""


@dataclass(frozen=True)
class HalfStep:
    """A step that was taken.

    Attributes:
        side: The foot that swung.
        lift_off, landing: Times [s].
        position: Origin of the sole that landed, shape (3,), in world [m].
        heading: Of the foot that landed, in world [rad].
        length: Distance of the sole origins along that heading [m].
        width: Distance across it, positive to the left [m].
        counted: False for a closing step.
    """

    side: Side
    lift_off: float
    landing: float
    position: Array
    heading: float
    length: float
    width: float
    counted: bool


def half_steps(run: Run, sole: Sole) -> list[HalfStep]:
    """All steps of a run in the order of landing.

    A swing begins where the foot carries nothing and ends where it carries about half the weight again;
    bounces in between are part of it. A foot that was never lifted, or is in the air at the beginning or
    the end, has not stepped.
    """
    found: list[HalfStep] = []
    for side in SIDES:
        load = run[f"{side.value}_foot/wrench"]
        for start, landed in _swings(load.force[:, 2]):
            height = sole(side, load.ticks[start:landed]).position[:, 2]
            if np.max(height) - height[0] > LIFTED:
                times = float(load.times[start]), float(load.times[landed])
                found.append(_half_step(side, *times, load.ticks[landed : landed + 1], sole))
    return sorted(found, key=lambda step: step.landing)


def _swings(load: Array) -> list[tuple[int, int]]:
    """Rows at which a foot left the ground and was back on it."""
    swings = []
    row = int(np.argmax(load > AIRBORNE))
    while row < len(load):
        airborne = np.flatnonzero(load[row:] <= AIRBORNE)
        if not len(airborne):
            break
        start = row + int(airborne[0])
        landed = np.flatnonzero(load[start:] >= LANDED)
        if not len(landed):
            break
        row = start + int(landed[0])
        swings.append((start, row))
    return swings


def _half_step(side: Side, lift_off: float, landing: float, tick: Integers, sole: Sole) -> HalfStep:
    foot, other = sole(side, tick), sole(side.other, tick)
    heading = float(foot.yaw[0])
    c, s = math.cos(heading), math.sin(heading)
    x, y = (foot.position[0, :2] - other.position[0, :2]).tolist()
    length, width = c * x + s * y, c * y - s * x
    return HalfStep(
        side, lift_off, landing, foot.position[0], heading, length, width, abs(length) > CLOSING
    )
