"""How fast the reference motion changes its angular momentum: mostly the swing leg's doing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array


@dataclass(frozen=True)
class MomentumConfig:
    """Limit and filter of the momentum rate."""

    limit: float = parameter(200.0, "largest rate of angular momentum; 0: left out", "N·m", 0, 1000)
    filter_time: float = parameter(0.01, "low-pass: touchdown ends swings abruptly", "s", 1e-4, 1)


class MomentumRate:
    """L̇ about the CoM from one tick to the next, limited and low-passed; likewise λ̇ for λ of the pendulum."""

    def __init__(self, config: MomentumConfig, start: Array | None = None) -> None:
        """Args: limit and filter, and the momentum before the first step; None: not known, so no rate yet."""
        self._config = config
        self._last = start
        self._rate: Array | None = None

    def step(self, momentum: Array, dt: float) -> Array:
        """Its rate, same shape as the momentum, in its unit per second.

        Args:
            momentum: L of the reference about its CoM in world, shape (3,) [kg·m²/s], or λ, shape (2,) [m·s].
            dt: Tick [s].
        """
        rate_now = np.zeros_like(momentum) if self._rate is None else self._rate
        if self._last is not None:
            limit = self._config.limit
            rate = np.clip((momentum - self._last) / dt, -limit, limit)
            share = 1.0 - math.exp(-dt / self._config.filter_time)
            rate_now = rate_now + share * (rate - rate_now)
        self._last, self._rate = momentum, rate_now
        return rate_now
