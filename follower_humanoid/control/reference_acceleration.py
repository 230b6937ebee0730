"""Desired joint acceleration: the low-passed derivative of the desired velocity."""

from __future__ import annotations

import numpy as np

from follower_humanoid.control.hand_task import Mask
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.sensing.low_pass import filter_share


class ReferenceAcceleration:
    """q̈_d of both arms from q̇_d at every tick."""

    def __init__(self, filter_time: float, period: float) -> None:
        """`filter_time`: time constant of the low-pass; `period`: control tick [s]."""
        self._share, self._period = filter_share(filter_time, period), period
        self._value = np.zeros((2, 7))
        self._before: Array | None = None

    def step(self, velocity: Array, begun_anew: Mask | None) -> Array:
        """q̈_d, shape (2, 7) [rad/s²], valid until the next step; zero at the first.

        Args:
            velocity: q̇_d of this tick, shape (2, 7) [rad/s].
            begun_anew: Arms whose law is another than at the last tick, shape (2,): a change of laws
                is no motion. None: nobody's.
        """
        if self._before is None:
            self._before = velocity.copy()
        if begun_anew is not None:
            self._value[begun_anew] = 0.0
            self._before[begun_anew] = velocity[begun_anew]
        _derive(velocity, self._period, self._share, self._before, self._value)
        return self._value


@kernel("void(float64[:,::1], float64, float64, float64[:,::1], float64[:,::1])")
def _derive(velocity: Array, period: float, share: float, before: Array, value: Array) -> None:
    """One tick of `ReferenceAcceleration`: `before` and `value` move on."""
    for arm in range(velocity.shape[0]):
        for joint in range(velocity.shape[1]):
            derivative = (velocity[arm, joint] - before[arm, joint]) / period
            value[arm, joint] += share * (derivative - value[arm, joint])
            before[arm, joint] = velocity[arm, joint]
