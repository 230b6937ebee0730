"""Steps found from the run itself: foot forces and sole poses, not what the controllers say of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.bench.kinematics import Motion
from follower_humanoid.core.samples import SIDES, Side
from follower_humanoid.graph.record import Run

AIRBORNE = 5.0  # [N]
LANDED = 200.0  # [N]
LIFTED = 0.015  # a swing raises the sole at least this far [m]
CLOSING = 0.10  # a shorter half-step only brings the feet together [m]


@dataclass(frozen=True)
class HalfStep:
    """A step that was taken.

    Attributes:
        side: The foot that swung.
        lift_off, landing: Times [s].
        length: Distance of the sole origins along the heading of the foot that landed [m].
        heading: Of the foot that landed, in world [rad].
        counted: False for a closing step.
    """

    side: Side
    lift_off: float
    landing: float
    length: float
    heading: float
    counted: bool


def half_steps(run: Run, motion: Motion) -> list[HalfStep]:
    """All steps of a run in order of landing."""
    found: list[HalfStep] = []
    for side in SIDES:
        load = run[f"{side.value}_foot/wrench"].force[: len(motion.times), 2]
        height = motion.sole[side][:, 2]
        tick = 0
        while tick < len(load):
            if load[tick] > AIRBORNE:
                tick += 1
                continue
            start = tick
            while tick < len(load) and load[tick] < LANDED:
                tick += 1
            if tick == len(load):
                break
            if np.max(height[start:tick]) - height[start] > LIFTED:
                found.append(_half_step(motion, side, start, tick))
    return sorted(found, key=lambda step: step.landing)


def _half_step(motion: Motion, side: Side, start: int, landed: int) -> HalfStep:
    # When the foot carries half the weight it has settled: there its place is read.
    yaw = float(motion.sole_yaw[side][landed])
    away = motion.sole[side][landed] - motion.sole[side.other][landed]
    length = float(away[0] * math.cos(yaw) + away[1] * math.sin(yaw))
    return HalfStep(
        side, float(motion.times[start]), float(motion.times[landed]), length, yaw, abs(length) > CLOSING
    )
