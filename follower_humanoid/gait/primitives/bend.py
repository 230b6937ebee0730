"""Bend: the swing leg folds and lifts its foot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import Primitive, StepContext


@dataclass(frozen=True)
class Bend(Primitive):
    """Lifts the swing sole to the walking parameter step_height.

    Attributes:
        height: Factor on the nominal swing height.
    """

    channel: ClassVar[str] = "swing_height"
    settled: ClassVar[float] = 0.6

    height: float = 1.0

    def target(self, context: StepContext) -> Array:
        """Height of the swing sole in world, shape (1,) [m]."""
        lift = self.height * context.gait.step_height * context.swing_height
        return np.array([max(context.stance.z, context.landing.z) + lift])
