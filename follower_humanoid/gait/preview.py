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
    # Plain numbers: NumPy's calls would cost more than the arithmetic.
    x, y = zmp.tolist()
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
    return np.array([dcm_x, dcm_y])


def com_after(
    zmp: Array, com: Array, dcm: Array, first: list[ZmpLeg], rest: list[ZmpLeg], omega: float, horizon: float
) -> Array:
    """Where the CoM will be when the first pieces of the ZMP plan have passed.

    c = (ξ + ζ)/2 with the DCM ξ from what follows and the convergent component ζ = c − ċ/ω from what
    went before: ζ̇ = ω(p − ζ) is the DCM's equation with time reversed.

    Args:
        zmp, com, dcm: Now, in world, shape (2,) [m].
        first: Pieces until the time asked for.
        rest: Pieces after it.
        omega: Natural frequency [1/s].
        horizon: See `planned_dcm` [s].

    Returns:
        CoM over the ground, shape (2,) [m].
    """
    points = [zmp]
    for target, _ in first:
        points.append(points[-1] if target is None else target)
    backwards: list[ZmpLeg] = [(points[i], duration) for i, (_, duration) in reversed(list(enumerate(first)))]
    elapsed = sum(duration for _, duration in first)
    dcm_then = planned_dcm(points[-1], rest, omega, horizon)
    convergent_now = 2.0 * com - dcm
    convergent = planned_dcm(points[-1], backwards, omega, math.inf)
    convergent = convergent + math.exp(-omega * elapsed) * (convergent_now - zmp)
    return 0.5 * (dcm_then + convergent)
