"""How hard people can pull and push: more is cut to the limit, in its own direction, and counted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Wrench

# A wrench that was cut is exactly at the limit but for rounding: it must not be cut a second time
# when a recorded run is simulated again.
_ROUNDING = 1.0 + 1e-9


@dataclass(frozen=True)
class PullLimits:
    """Largest wrenches from outside."""

    hand_force: float = parameter(200.0, "largest force on a hand", "N", 0.0, 1e4)
    hand_torque: float = parameter(50.0, "largest moment on a hand", "N·m", 0.0, 1e4)
    push_force: float = parameter(5000.0, "largest force on base_link", "N", 0.0, 1e5)
    push_torque: float = parameter(1000.0, "largest moment on base_link", "N·m", 0.0, 1e5)


class PullLimiter:
    """Cuts what is too much.

    Attributes:
        cut: Place → ticks at which its wrench was cut.
    """

    def __init__(self, limits: PullLimits) -> None:
        """Nothing was cut yet."""
        self._hand = (limits.hand_force, limits.hand_torque)
        self._push = (limits.push_force, limits.push_torque)
        self.cut = {"left_hand": 0, "right_hand": 0, "base": 0}

    def limited(self, place: str, wrench: Wrench) -> Wrench:
        """The wrench that acts on a place, one of the keys of `cut`."""
        force_limit, torque_limit = self._push if place == "base" else self._hand
        force, torque = _shortened(wrench.force, force_limit), _shortened(wrench.torque, torque_limit)
        if force is wrench.force and torque is wrench.torque:
            return wrench
        self.cut[place] += 1
        return Wrench(force, torque, wrench.frame)


def _shortened(vector: Array, limit: float) -> Array:
    """The vector, not longer than the limit; also one whose square is no number any more."""
    largest = float(abs(vector).max())
    if largest * math.sqrt(3.0) <= limit:
        return vector
    direction = vector / largest
    length = math.sqrt(direction @ direction)  # at most √3, however large the vector
    if largest * length <= limit * _ROUNDING:
        return vector
    return direction * (limit / length)
