"""The DCM balance law: where the ZMP must be so that the DCM comes back to its plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import GRAVITY


@dataclass(frozen=True)
class DcmConfig:
    """Gains of the DCM law and of the CoM height."""

    proportional: float = parameter(3.0, "decay rate of a DCM error", "1/s", 0, 20)
    height_stiffness: float = parameter(60.0, "CoM height feedback", "1/s²", 0, 500)
    height_damping: float = parameter(16.0, "CoM vertical speed feedback", "1/s", 0, 100)


class CenterState(NamedTuple):
    """CoM of the robot in world.

    Attributes:
        com: Shape (3,) [m].
        velocity: Shape (3,) [m/s].
    """

    com: Array
    velocity: Array


def measured_dcm(state: CenterState, hands: HandEffect, omega: float) -> Array:
    """ξ = (c + ċ/ω + γ)/κ: the DCM with what the hands do taken in, shape (2,) [m].

    Args:
        state: Measured CoM.
        hands: Effect of the hand forces.
        omega: Natural frequency [1/s].
    """
    dcm = np.empty(2)
    _dcm(state.com, state.velocity, hands.gamma, hands.kappa, omega, dcm)
    return dcm


@kernel("void(float64[::1], float64[::1], float64[::1], float64, float64, float64[::1])")
def _dcm(com: Array, velocity: Array, gamma: Array, kappa: float, omega: float, dcm: Array) -> None:
    """Writes ξ of `measured_dcm`."""
    for axis in range(2):
        dcm[axis] = (com[axis] + velocity[axis] / omega + gamma[axis]) / kappa


def desired_zmp(dcm: Array, dcm_reference: Array, zmp_reference: Array, omega: float, gain: float) -> Array:
    """p = p_ref + (1 + k/ω)(ξ − ξ_ref): the DCM error decays as e^{−kt}.

    Args:
        dcm: Measured, in world, shape (2,) [m].
        dcm_reference, zmp_reference: Plan in world, shape (2,) [m].
        omega: Natural frequency [1/s].
        gain: Decay rate k [1/s].

    Returns:
        ZMP in world before any limit, shape (2,) [m].
    """
    zmp = np.empty(2)
    _zmp(dcm, dcm_reference, zmp_reference, 1.0 + gain / omega, zmp)
    return zmp


@kernel("void(float64[::1], float64[::1], float64[::1], float64, float64[::1])")
def _zmp(dcm: Array, dcm_reference: Array, zmp_reference: Array, factor: float, zmp: Array) -> None:
    """Writes p of `desired_zmp` for the factor 1 + k/ω."""
    for axis in range(2):
        zmp[axis] = zmp_reference[axis] + factor * (dcm[axis] - dcm_reference[axis])


def desired_force(
    state: CenterState,
    reference: CenterState,
    zmp: Array,
    momentum_rate: Array,
    hands: HandEffect,
    omega: float,
    mass: float,
    config: DcmConfig,
) -> Array:
    """What the ground must do to the feet in total.

    F_xy = m ω²(c + γ − κ p − λ̇) − Σ f_hand,xy and F_z = m(g + k_p e_z + k_d ė_z) − Σ f_hand,z.

    Args:
        state: Measured CoM.
        reference: Wanted CoM; only its height is followed here.
        zmp: Desired ZMP before the attitude shift, in world, shape (2,) [m].
        momentum_rate: λ̇, what the swing leg's angular momentum does, shape (2,) [m].
        hands: Effect of the hand forces.
        omega: Natural frequency [1/s].
        mass: Robot mass [kg].
        config: Gains.

    Returns:
        Force on the robot in world, shape (3,) [N].
    """  # fmt: skip
    force = np.empty(3)
    _force(
        state.com, state.velocity, reference.com, reference.velocity, zmp, momentum_rate,
        hands.gamma, hands.force, hands.kappa, mass * omega**2, mass,
        config.height_stiffness, config.height_damping, force,
    )  # fmt: skip
    return force


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[::1],"
    " float64[::1], float64[::1], float64, float64, float64, float64, float64, float64[::1])"
)
def _force(
    com: Array, velocity: Array, wanted_com: Array, wanted_velocity: Array, zmp: Array, momentum_rate: Array,
    gamma: Array, hands: Array, kappa: float, stiffness: float, mass: float,
    height_stiffness: float, height_damping: float, force: Array,
) -> None:  # fmt: skip
    """Writes F of `desired_force`; `stiffness` is m ω², `hands` the sum of the hands' forces."""
    for axis in range(2):
        lever = com[axis] + gamma[axis] - kappa * zmp[axis] - momentum_rate[axis]
        force[axis] = stiffness * lever - hands[axis]
    lift = height_stiffness * (wanted_com[2] - com[2])
    lift += height_damping * (wanted_velocity[2] - velocity[2])
    force[2] = max(mass * (GRAVITY + lift) - hands[2], 0.0)
