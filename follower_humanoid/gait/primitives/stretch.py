"""Stretch: the swing leg reaches out to where its foot will land."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import Primitive, StepContext


@dataclass(frozen=True)
class Stretch(Primitive):
    """Carries the swing foot over the ground to the landing place.

    Attributes:
        forward, outward: Shift of the landing place in axes of the landing foot [m].
    """

    channel: ClassVar[str] = "swing_place"

    forward: float = 0.0
    outward: float = 0.0

    def target(self, context: StepContext) -> Array:
        """Swing sole origin over the ground in world, shape (2,) [m]."""
        return context.landing.point(self.forward, context.landing.side.sign * self.outward)
