"""Limits of the walking parameters: what no message may ask for."""

from __future__ import annotations

from dataclasses import dataclass

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Gait


@dataclass(frozen=True)
class GaitLimits:
    """Ranges of the walking parameters; beyond them they are cut and counted."""

    slowest: float = parameter(0.1, "a smaller walk_speed is standing", "", 0.01, 1)
    fastest: float = parameter(10.0, "largest walk_speed", "", 0.1, 100)
    longest: float = parameter(2.0, "largest step_length", "", 0.1, 10)
    lowest: float = parameter(0.2, "smallest step_height", "", 0, 1)
    highest: float = parameter(4.0, "largest step_height", "", 0.1, 10)


def limited(gait: Gait, limits: GaitLimits) -> Gait:
    """The walking parameters within their limits; a speed too small, or backward, is standing."""
    speed = min(gait.walk_speed, limits.fastest) if gait.walk_speed >= limits.slowest else 0.0
    return Gait(
        walk_speed=speed,
        walk_dir=gait.walk_dir,
        step_length=min(max(gait.step_length, 0.0), limits.longest),
        step_height=min(max(gait.step_height, limits.lowest), limits.highest),
        heading=gait.heading,
    )
