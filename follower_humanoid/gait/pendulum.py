"""The linear inverted pendulum that the reference motion follows (Kajita; Englsberger: DCM)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import GRAVITY


@dataclass(frozen=True, slots=True)
class PendulumState:
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


class ReferencePendulum:
    """Follows a DCM plan that may jump, with a ZMP that makes the motion possible.

    When walking starts, stops or changes, the planned DCM jumps. The reference DCM cannot: it is
    steered to the plan by p = p_plan + (1 + k/ω)(ξ − ξ_plan), so that the gap decays as e^{−kt} and
    reference CoM, DCM and ZMP stay consistent with ξ̇ = ω(ξ − p), ċ = ω(ξ − c).
    """

    def __init__(self, com: Array, convergence: float, reach: float) -> None:
        """Starts at rest above its ZMP.

        Args:
            com: CoM over the ground, shape (2,) [m].
            convergence: Decay rate k of the gap to the plan [1/s].
            reach: Largest distance of the ZMP from the planned one [m].
        """
        self._convergence = convergence
        self._reach = reach
        self.state = PendulumState(np.array(com), np.zeros(2), np.array(com), np.array(com))

    def advance(self, zmp_plan: Array, dcm_plan: Array, omega: float, dt: float) -> PendulumState:
        """One tick under constant ZMP, integrated exactly.

        Args:
            zmp_plan: Planned ZMP, shape (2,) [m].
            dcm_plan: Planned DCM, shape (2,) [m].
            omega: Natural frequency [1/s].
            dt: Tick [s].
        """
        old = self.state
        shift = (1.0 + self._convergence / omega) * (old.dcm - dcm_plan)
        distance = math.hypot(shift[0], shift[1])
        if distance > self._reach:
            shift = shift * (self._reach / distance)
        zmp = zmp_plan + shift
        # Exact solution of c̈ = ω²(c − p) over dt with p constant.
        growth = math.exp(omega * dt)
        dcm = zmp + growth * (old.dcm - zmp)
        cosh, sinh = 0.5 * (growth + 1.0 / growth), 0.5 * (growth - 1.0 / growth)
        com = zmp + cosh * (old.com - zmp) + (sinh / omega) * old.com_velocity
        self.state = PendulumState(com, omega * (dcm - com), dcm, zmp)
        return self.state


def natural_frequency(height: float) -> float:
    """ω = √(g/z) of a pendulum of height z [1/s]."""
    return math.sqrt(GRAVITY / max(height, 0.1))
