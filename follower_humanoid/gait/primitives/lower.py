"""Lower: the swing foot comes down until the ground carries it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import Primitive, StepContext


@dataclass(frozen=True)
class Lower(Primitive):
    """Brings the swing sole to the ground and stops where it meets it.

    Attributes:
        depth: How far below the expected ground it goes on looking for it [m].
    """

    channel: ClassVar[str] = "swing_height"

    depth: float = 0.0

    def target(self, context: StepContext) -> Array:
        """Height of the swing sole in world, shape (1,) [m]."""
        return np.array([context.landing.z - self.depth])

    def finished(self, context: StepContext, load: float, progress: float) -> bool:
        """Whether the ground carries the foot."""
        return progress > self.start and load > context.touchdown_load
