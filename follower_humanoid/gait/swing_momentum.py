"""How fast the reference motion changes its angular momentum: mostly the swing leg's doing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array


@kernel("float64[::1](float64[::1], float64[::1], float64[::1], float64, float64, float64)")
def filtered_rate(new: Array, old: Array, rate: Array, dt: float, limit: float, share: float) -> Array:
    """r + s (clip((x − x_old)/dt) − r): the change per time, limited to ±limit, behind a low-pass.

    Args:
        new, old: x now and a tick ago, shape (n,).
        rate: r, what came out a tick ago, shape (n,).
        dt: Tick [s].
        limit: Largest change per second.
        share: s of the low-pass, 0…1.
    """
    out = np.empty(len(new))
    for i in range(len(new)):
        change = min(max((new[i] - old[i]) / dt, -limit), limit)
        out[i] = rate[i] + share * (change - rate[i])
    return out


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
            share = 1.0 - math.exp(-dt / self._config.filter_time)
            rate_now = filtered_rate(momentum, self._last, rate_now, dt, self._config.limit, share)
        self._last, self._rate = momentum, rate_now
        return rate_now
