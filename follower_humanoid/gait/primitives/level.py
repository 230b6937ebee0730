"""Level: the swing sole turns into the attitude in which it will land."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import Primitive, StepContext


@dataclass(frozen=True)
class Level(Primitive):
    """Turns the swing foot to the landing heading and to a pitch.

    Attributes:
        pitch: Pitch of the sole at the end, positive toes down [rad].
    """

    channel: ClassVar[str] = "swing_attitude"

    pitch: float = 0.0

    def target(self, context: StepContext) -> Array:
        """(yaw in world, pitch), shape (2,) [rad]."""
        return np.array([context.landing.yaw, self.pitch])
