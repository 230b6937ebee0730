"""Sliding mode with boundary layer and disturbance estimator: the control input `a` of eq. (16)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array


@dataclass(frozen=True)
class SlidingModeConfig:
    """Gains of the sliding mode controller."""

    slope: float = parameter(20.0, "λ of the sliding surface s = ė + λe", "1/s", 0, 200)
    reaching: float = parameter(40.0, "proportional reaching rate", "1/s", 0, 500)
    switching: float = parameter(10.0, "switching amplitude", "rad/s²", 0, 500)
    boundary: float = parameter(0.3, "boundary layer of s", "rad/s", 1e-3, 10)
    estimate: bool = parameter(True, "estimate disturbances and work against them")
    estimator: float = parameter(40.0, "integration rate of the disturbance estimate", "1/s²", 0, 500)
    estimate_limit: float = parameter(60.0, "largest disturbance estimate", "rad/s²", 0, 1000)


class SlidingMode:
    """a = q̈_d + σ (λ ė + k s + η sat(s/φ) + d̂), s = ė + λ e, d̂' = l s.

    e is desired minus measured; σ weighs each joint. The estimate d̂ is what is left of model error and
    unmeasured force; it rests where the motor is at its voltage limit.

    Reference: Savić et al. 2016, joint motion control module in section "The RAMP-based framework for
    cooperative transportation", and ref. [5] there.

    Attributes:
        estimate: d̂, shape (n,) [rad/s²].
    """

    def __init__(self, config: SlidingModeConfig, joints: int) -> None:
        self._config = config
        self.estimate: Array = np.zeros(joints)

    def acceleration(
        self,
        error: Array,
        error_velocity: Array,
        feedforward: Array,
        weight: Array,
        saturated: NDArray[np.bool_],
        dt: float,
    ) -> Array:
        """One tick.

        Args:
            error: e, shape (n,) [rad].
            error_velocity: ė, shape (n,) [rad/s].
            feedforward: q̈_d, shape (n,) [rad/s²].
            weight: σ, shape (n,).
            saturated: Where the last voltage was cut: the estimate rests there.
            dt: Tick [s].

        Returns:
            a, shape (n,) [rad/s²].
        """  # fmt: skip
        c = self._config
        acceleration = np.empty(len(error))
        _sliding_mode(
            error, error_velocity, feedforward, weight, saturated, self.estimate,
            c.slope, c.reaching, c.switching, c.boundary,
            c.estimator * dt if c.estimate else 0.0, c.estimate_limit, acceleration,
        )  # fmt: skip
        return acceleration


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], boolean[::1], float64[::1],"
    " float64, float64, float64, float64, float64, float64, float64[::1])"
)
def _sliding_mode(
    error: Array, error_velocity: Array, feedforward: Array, weight: Array, saturated: NDArray[np.bool_],
    estimate: Array, slope: float, reaching: float, switching: float, boundary: float, growth: float,
    estimate_limit: float, acceleration: Array,
) -> None:  # fmt: skip
    """Writes a of `SlidingMode` for one tick; `estimate` moves on, `growth` is l Δt."""
    for joint in range(error.size):
        s = error_velocity[joint] + slope * error[joint]
        if not saturated[joint]:
            grown = estimate[joint] + growth * s
            estimate[joint] = min(max(grown, -estimate_limit), estimate_limit)
        feedback = slope * error_velocity[joint] + reaching * s
        feedback += switching * min(max(s / boundary, -1.0), 1.0) + estimate[joint]
        acceleration[joint] = feedforward[joint] + weight[joint] * feedback
