"""Controlled gravity compensation: the arm carries itself and goes where it is led, eqs. (9), (10)."""

from __future__ import annotations

import numpy as np

from follower_humanoid.control.impedance import Impedance
from follower_humanoid.core.samples import Array


def compensation(inertia: Array, damping: float) -> Impedance:
    """The behaviour `H_m ẍ + D_m ẋ = F`: eq. (3) without a spring.

    A force F leads the hand at the speed F/D_m; let go, it stops within a few H_m/D_m and stays.

    Args:
        inertia: H_m, shape (3,) [kg].
        damping: D_m, the same along all axes [N·s/m].

    Reference: Savić et al. 2016, eqs. (9), (10).
    """
    return Impedance(inertia, np.full(3, damping), np.zeros(3))


def leading_force(felt: Array, payload: float) -> Array:
    """What leads a hand: the measured force less the weight that the arm shall carry.

    Args:
        felt: Measured force on each hand, axes with z up, shape (2, 3) [N].
        payload: Weight in each hand [N].
    """
    force: Array = felt.copy()
    force[:, 2] += payload
    return force
