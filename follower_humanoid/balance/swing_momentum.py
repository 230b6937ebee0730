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
    """L̇ about the CoM from one tick to the next, limited and low-passed."""

    def __init__(self, config: MomentumConfig) -> None:
        self._config = config
        self._last: Array | None = None
        self._rate: Array = np.zeros(3)

    def step(self, momentum: Array, dt: float) -> Array:
        """L̇ in world, shape (3,) [N·m].

        Args:
            momentum: L of the reference about its CoM in world, shape (3,) [kg·m²/s].
            dt: Tick [s].
        """
        if self._last is not None:
            limit = self._config.limit
            rate = np.clip((momentum - self._last) / dt, -limit, limit)
            share = 1.0 - math.exp(-dt / self._config.filter_time)
            self._rate = self._rate + share * (rate - self._rate)
        self._last = momentum
        return self._rate
