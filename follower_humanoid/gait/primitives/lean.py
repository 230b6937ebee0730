"""Lean: the weight goes over to the coming stance foot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import ZMP, Primitive, StepContext


@dataclass(frozen=True)
class Lean(Primitive):
    """Moves the ZMP onto the stance foot while both feet carry.

    Attributes:
        forward: Target ahead of the ankle on the stance sole [m], for a step in the foot's direction.
        inward: Target towards the other foot [m].
    """

    channel: ClassVar[str] = ZMP

    forward: float = -0.01
    inward: float = 0.0

    def target(self, context: StepContext) -> Array:
        """ZMP on the stance sole in world, shape (2,) [m]."""
        return context.stance.point(self.forward, -context.stance.side.sign * self.inward)
