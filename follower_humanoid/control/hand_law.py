"""What the hands shall do, in the axes of their task: go back to their places, and give way to forces.

    v_ref = ẋ_d + K_P x_err + K_D ẋ_err            back to the place, corrected eqs. (17), (18)
    f = F + D_m ė + K_m e + wall at the reach      what moves the masses H_m, eq. (3)

The springs' end moves with what eq. (17) adds to ẋ_d, and e is its distance from the hand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from follower_humanoid.control.arm_config import ArmControllerConfig
from follower_humanoid.control.hand_reference import HandReference
from follower_humanoid.control.hand_task import HandMotion, Mask
from follower_humanoid.control.impedance import Impedance
from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array


class HandDemand(NamedTuple):
    """What is asked of both hands at one tick, left first, in task axes.

    Attributes:
        stretch: e of the springs, shape (2, 3) [m].
        velocity: v_ref of the arm alone: less what the body does to the hand, shape (2, 3) [m/s].
        force: f, shape (2, 3) [N].
    """

    stretch: Array
    velocity: Array
    force: Array


class HandLaw:
    """The law of hands that keep a place.

    Attributes:
        return_force: Largest force of the springs on the way back, shape (3,) [N].
    """

    def __init__(self, config: ArmControllerConfig, impedance: Impedance, period: float) -> None:
        """`config`: of which nothing that is used here changes at run time; `impedance`: H_m, D_m, K_m;
        `period`: control tick [s].
        """
        self._config, self._impedance, self._period = config, impedance, period
        self.return_force = np.array(config.return_force)
        self._demand = HandDemand(np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((2, 3)))

    def step(self, reference: HandReference, hands: HandMotion, felt: Array, stopped: Mask) -> HandDemand:
        """The demand of one tick, valid until the next; moves the springs' ends on.

        Args:
            reference: Places, their rates, and the springs' ends.
            hands: Where the hands are.
            felt: F, shape (2, 3) [N].
            stopped: Which hands do not return now, shape (2,).
        """
        config, wanted, demand = self._config, self._impedance, self._demand
        _hand_law(
            reference.place, reference.rate, reference.virtual, hands.place, hands.place_rate, hands.carried,
            felt, stopped, wanted.inertia, wanted.damping, wanted.stiffness, self.return_force,
            config.return_proportional, config.return_differential, config.reach, config.reach_stiffness,
            self._period, *demand,
        )  # fmt: skip
        return demand


@kernel_part
def return_velocity(
    error: Array, error_rate: Array, stretch: Array, proportional: float, differential: float,
    stiffness: Array, limit: Array, stopped: Mask,
) -> Array:  # fmt: skip
    """Hand velocity that leads back to the place: `v_ref = K_P x_err + K_D ẋ_err`.

    The point that the impedance's springs pull to moves with it, which makes it integral action:
    under a constant force the hand yields, then returns with the time constant (1 + K_D)/K_P.
    An axis rests where it would stretch its spring beyond a force limit: a hand that somebody holds
    away from its place would otherwise pull ever harder.

    Args:
        error: x_err = x_d − x, shape (n, 3) [m].
        error_rate: Its rate, shape (n, 3) [m/s].
        stretch: Of the springs, shape (n, 3) [m].
        proportional: K_P [1/s].
        differential: K_D.
        stiffness: Of the springs, shape (3,) [N/m].
        limit: Of their force, shape (3,) [N].
        stopped: Which hands do not return now, shape (n,).

    Returns:
        v_ref, shape (n, 3) [m/s].

    Reference: Savić et al. 2016, eqs. (17), (18).
    """
    velocity = np.zeros(error.shape)
    for hand in range(error.shape[0]):
        for axis in range(0 if stopped[hand] else 3):
            back = proportional * error[hand, axis] + differential * error_rate[hand, axis]
            force = stiffness[axis] * stretch[hand, axis]
            if abs(force) < limit[axis] or back * force <= 0.0:
                velocity[hand, axis] = back
    return velocity


@kernel_part
def range_force(error: Array, error_rate: Array, reach: float, stiffness: float, mass: float) -> Array:
    """Force that keeps a hand within a ball around its place: a soft wall, critically damped outwards.

    Args:
        error: Place minus hand, shape (arms, 3) [m].
        error_rate: Shape (arms, 3) [m/s].
        reach: Radius of the ball [m].
        stiffness: Of the wall [N/m].
        mass: Of the hand, which sets the damping [kg].

    Returns:
        Shape (arms, 3) [N]; zero inside the ball.
    """
    force = np.zeros(error.shape)
    damping = 2.0 * math.sqrt(stiffness * mass)
    for arm in range(error.shape[0]):
        distance = math.sqrt(error[arm, 0] ** 2 + error[arm, 1] ** 2 + error[arm, 2] ** 2)
        if distance <= reach:
            continue
        leaving = 0.0
        for axis in range(3):
            leaving += error_rate[arm, axis] * error[arm, axis] / distance
        inwards = stiffness * (distance - reach) + damping * max(leaving, 0.0)
        for axis in range(3):
            force[arm, axis] = inwards * error[arm, axis] / distance
    return force


@kernel(
    "void(float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1], float64[:,::1],"
    " float64[:,::1], boolean[::1], float64[::1], float64[::1], float64[::1], float64[::1],"
    " float64, float64, float64, float64, float64, float64[:,::1], float64[:,::1], float64[:,::1])"
)
def _hand_law(
    place: Array, rate: Array, virtual: Array, hand_place: Array, hand_rate: Array, carried: Array,
    felt: Array, stopped: Mask, inertia: Array, damping: Array, stiffness: Array, return_force: Array,
    proportional: float, differential: float, reach: float, reach_stiffness: float, period: float,
    stretch: Array, velocity: Array, force: Array,
) -> None:  # fmt: skip
    """Writes a `HandDemand`; moves `virtual`, the springs' ends."""
    error, error_rate = place - hand_place, rate - hand_rate
    stretch[:] = virtual - hand_place
    back = return_velocity(
        error, error_rate, stretch, proportional, differential, stiffness, return_force, stopped
    )
    force[:] = range_force(error, error_rate, reach, reach_stiffness, inertia[0])
    for hand in range(2):
        for axis in range(3):
            wanted = rate[hand, axis] + back[hand, axis]
            velocity[hand, axis] = wanted - carried[hand, axis]
            virtual[hand, axis] += period * (wanted - rate[hand, axis])
            force[hand, axis] += damping[axis] * (wanted - hand_rate[hand, axis])
            force[hand, axis] += stiffness[axis] * stretch[hand, axis] + felt[hand, axis]
