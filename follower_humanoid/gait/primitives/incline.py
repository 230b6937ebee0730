"""Incline: the body tips forward over the stance foot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import ZMP, Primitive, StepContext


@dataclass(frozen=True)
class Incline(Primitive):
    """Rolls the ZMP along the stance sole while the other foot swings.

    Attributes:
        forward: Target ahead of the ankle on the stance sole [m].
        inward: Target towards the other foot [m].
    """

    channel: ClassVar[str] = ZMP

    forward: float = 0.07
    inward: float = 0.0

    def target(self, context: StepContext) -> Array:
        """ZMP on the stance sole in world, shape (2,) [m]."""
        return context.stance.point(self.forward, -context.stance.side.sign * self.inward)
