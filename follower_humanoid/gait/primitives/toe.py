"""Toe: the toes of the swing foot lift for clearance and flatten for landing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.gait.primitives.base import Primitive, StepContext


@dataclass(frozen=True)
class Toe(Primitive):
    """Turns the toe joint of the swing foot.

    Attributes:
        angle: Toe joint at the end of the window, negative up [rad].
    """

    channel: ClassVar[str] = "swing_toe"

    angle: float = 0.0

    def target(self, context: StepContext) -> Array:
        """Toe joint, shape (1,) [rad]."""
        del context
        return np.array([self.angle])
