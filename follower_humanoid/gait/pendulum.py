"""The linear inverted pendulum that the reference motion follows (Kajita; Englsberger: DCM)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.gait.swing_momentum import MomentumConfig, MomentumRate
from follower_humanoid.robot.model import GRAVITY

MOMENTUM = MomentumConfig(limit=0.3, filter_time=0.01)  # largest shift of the ZMP by λ̇ [m], low-pass [s]


class PendulumState(NamedTuple):
    """CoM, DCM and the ZMP that moves them, in world, shape (2,) each.

    Attributes:
        com: [m].
        com_velocity: [m/s].
        dcm: ξ = c + ċ/ω [m].
        zmp: [m].
    """

    com: Array
    com_velocity: Array
    dcm: Array
    zmp: Array


@kernel(
    "float64[:,::1](float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[::1],"
    " float64, float64, float64, float64)"
)
def swung(
    com: Array, dcm: Array, zmp_plan: Array, dcm_plan: Array, momentum: Array, momentum_rate: Array,
    omega: float, convergence: float, reach: float, dt: float,
) -> Array:  # fmt: skip
    """One tick of `ReferencePendulum.advance` from com and dcm on, with λ and λ̇ of the reference motion.

    Returns:
        The new CoM, its velocity, the new DCM, and the ZMP, shape (4, 2).
    """
    gain = 1.0 + convergence / omega
    shift_x = gain * (dcm[0] - dcm_plan[0] + omega * momentum[0])
    shift_y = gain * (dcm[1] - dcm_plan[1] + omega * momentum[1])
    distance = math.hypot(shift_x, shift_y)
    cut = reach / distance if distance > reach else 1.0
    # Exact solution of c̈ = ω²(c − p − λ̇) over dt with p + λ̇ constant.
    growth = math.exp(omega * dt)
    cosh, sinh = 0.5 * (growth + 1.0 / growth), 0.5 * (growth - 1.0 / growth)
    state = np.empty((4, 2))
    for i, shift in enumerate((shift_x, shift_y)):
        zmp = zmp_plan[i] - omega * momentum[i] + cut * shift
        pivot = zmp + momentum_rate[i]
        com_then = pivot + cosh * (com[i] - pivot) + sinh * (dcm[i] - com[i])
        dcm_then = pivot + growth * (dcm[i] - pivot)
        state[0, i], state[1, i] = com_then, omega * (dcm_then - com_then)
        state[2, i], state[3, i] = dcm_then, zmp
    return state


class ReferencePendulum:
    """Follows a DCM plan that may jump, with a ZMP that makes the motion possible.

    When walking starts, stops or changes, the planned DCM jumps. The reference DCM cannot: it is
    steered to the plan by p = p_plan + (1 + k/ω)(ξ − ξ_plan), so that the gap decays as e^{−kt} and
    reference CoM, DCM and ZMP stay consistent with ξ̇ = ω(ξ − p − λ̇), ċ = ω(ξ − c).

    λ = (L_y, −L_x)/(m g) is what the angular momentum L about the CoM, mostly the swing leg's, does:
    p = c − c̈/ω² − λ̇. Without it in the plan the ZMP would carry the whole of λ̇; with ξ_plan lowered
    by ω λ only ω λ is left, a fraction of it for swings that are short against 1/ω.
    """

    def __init__(self, com: Array) -> None:
        """Starts at rest above its ZMP; `com` is over the ground, shape (2,) [m]."""
        self._momentum_rate = MomentumRate(MOMENTUM, start=np.zeros(2))
        self.state = PendulumState(np.array(com), np.zeros(2), np.array(com), np.array(com))

    def take_over(self, dcm: Array) -> None:
        """The robot is where a push has brought it: the reference goes on from there.

        Args:
            dcm: Measured DCM, shape (2,) [m].
        """
        self.state = self.state._replace(dcm=dcm)

    def advance(
        self,
        zmp_plan: Array,
        dcm_plan: Array,
        momentum: Array,
        omega: float,
        convergence: float,
        reach: float,
        dt: float,
    ) -> PendulumState:
        """One tick under constant ZMP, integrated exactly.

        Args:
            zmp_plan: Planned ZMP, shape (2,) [m].
            dcm_plan: Planned DCM, shape (2,) [m].
            momentum: λ of the reference motion, shape (2,) [m·s].
            omega: Natural frequency [1/s].
            convergence: Decay rate k of the gap to the plan [1/s].
            reach: Largest distance of the ZMP from the planned one [m].
            dt: Tick [s].
        """
        old = self.state
        rate = self._momentum_rate.step(momentum, dt)
        new = swung(old.com, old.dcm, zmp_plan, dcm_plan, momentum, rate, omega, convergence, reach, dt)
        self.state = PendulumState(new[0], new[1], new[2], new[3])
        return self.state


def momentum_shift(angular_momentum: Array, mass: float) -> Array:
    """λ = (L_y, −L_x)/(m g) of an angular momentum about the CoM, shape (2,) [m·s].

    Args:
        angular_momentum: L in world, shape (3,) [kg·m²/s].
        mass: [kg].
    """
    x, y, _ = angular_momentum.tolist()
    return np.array([y / (mass * GRAVITY), -x / (mass * GRAVITY)])


def natural_frequency(height: float) -> float:
    """ω = √(g/z) of a pendulum of height z [1/s]."""
    return math.sqrt(GRAVITY / max(height, 0.1))
