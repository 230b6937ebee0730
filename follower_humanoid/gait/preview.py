"""Preview: the ZMP that the coming primitives will ask for, and the DCM that leads there.

The divergent component of motion (DCM) ξ = c + ċ/ω obeys ξ̇ = ω(ξ − p). Its only bounded solution is
the discounted future of the ZMP, ξ(t) = ω ∫ p(t + s) e^{−ωs} ds, which for a piecewise linear p is
ξ = p + Σ (slope/ω)(e^{−ωt₀} − e^{−ωt₁}) in closed form: no table, new at every tick.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from follower_humanoid.core.samples import Array

ZmpLeg = tuple[Array | None, float]
"""A piece of the ZMP plan: point to reach, shape (2,) [m], and the time it takes [s]; None = stay."""


def planned_dcm(zmp: Array, legs: Iterable[ZmpLeg], omega: float, horizon: float) -> Array:
    """The DCM that a piecewise linear ZMP plan needs now.

    Args:
        zmp: ZMP now in world, shape (2,) [m].
        legs: The plan, in order of time; after its end the ZMP rests.
        omega: Natural frequency √(g/z) of the linear inverted pendulum [1/s].
        horizon: What lies further ahead is left out [s].

    Returns:
        DCM in world, shape (2,) [m].
    """
    x, y = zmp.tolist()
    return np.array(_planned(x, y, legs, omega, horizon))


def _planned(x: float, y: float, legs: Iterable[ZmpLeg], omega: float, horizon: float) -> tuple[float, float]:
    """`planned_dcm` in plain numbers: NumPy's calls would cost more than the arithmetic."""
    dcm_x, dcm_y = x, y
    time, discount = 0.0, 1.0
    for target, duration in legs:
        if time >= horizon:
            break
        time += duration
        if target is None:
            discount = math.exp(-omega * time)
            continue
        if duration < 1e-6:
            weight = discount
        else:
            later = math.exp(-omega * time)
            weight = (discount - later) / (omega * duration)
            discount = later
        next_x, next_y = target.tolist()
        dcm_x += weight * (next_x - x)
        dcm_y += weight * (next_y - y)
        x, y = next_x, next_y
    return dcm_x, dcm_y


def com_after(
    zmp: Array, com: Array, dcm: Array, first: list[ZmpLeg], rest: list[ZmpLeg], omega: float, horizon: float
) -> Array:
    """Where the CoM will be when the first pieces of the ZMP plan have passed.

    c = (ξ + ζ)/2 with the DCM ξ from what follows and the convergent component ζ = c − ċ/ω from what
    went before: ζ̇ = ω(p − ζ).

    Args:
        zmp, com, dcm: Now, in world, shape (2,) [m].
        first: Pieces until the time asked for.
        rest: Pieces after it.
        omega: Natural frequency [1/s].
        horizon: See `planned_dcm` [s].

    Returns:
        CoM over the ground, shape (2,) [m].
    """
    x, y = zmp.tolist()
    (com_x, com_y), (dcm_x, dcm_y) = com.tolist(), dcm.tolist()
    convergent_x, convergent_y = 2.0 * com_x - dcm_x, 2.0 * com_y - dcm_y
    for target, duration in first:
        next_x, next_y = (x, y) if target is None else target.tolist()
        if duration >= 1e-6:
            # ζ(T) = p(T) − ṗ/ω + e^{−ωT} (ζ − p + ṗ/ω) with constant ṗ.
            decay, pace = math.exp(-omega * duration), 1.0 / (omega * duration)
            lag_x, lag_y = pace * (next_x - x), pace * (next_y - y)
            convergent_x = next_x - lag_x + decay * (convergent_x - x + lag_x)
            convergent_y = next_y - lag_y + decay * (convergent_y - y + lag_y)
        x, y = next_x, next_y
    dcm_x, dcm_y = _planned(x, y, rest, omega, horizon)
    return np.array([0.5 * (dcm_x + convergent_x), 0.5 * (dcm_y + convergent_y)])
