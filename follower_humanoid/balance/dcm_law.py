"""The DCM balance law: where the ZMP must be so that the DCM comes back to its plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.balance.hand_forces import HandEffect
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import GRAVITY


@dataclass(frozen=True)
class DcmConfig:
    """Gains of the DCM law and of the pelvis attitude."""

    proportional: float = parameter(3.0, "decay rate of a DCM error", "1/s", 0, 20)
    attitude_stiffness: float = parameter(120.0, "pelvis attitude feedback", "1/s²", 0, 1000)
    attitude_damping: float = parameter(22.0, "pelvis rate feedback", "1/s", 0, 200)
    inertia: float = parameter(8.0, "inertia that the attitude feedback turns", "kg·m²", 0.1, 50)
    yaw_limit: float = parameter(25.0, "largest yaw moment asked of the feet", "N·m", 0, 100)
    momentum_limit: float = parameter(200.0, "largest rate of the swing leg's angular momentum", "N·m", 0, 1000)
    momentum_filter: float = parameter(0.01, "low-pass of that rate", "s", 1e-4, 1)
    height_stiffness: float = parameter(60.0, "CoM height feedback", "1/s²", 0, 500)
    height_damping: float = parameter(16.0, "CoM vertical speed feedback", "1/s", 0, 100)
    attitude_reach: float = parameter(0.03, "largest ZMP shift for the attitude", "m", 0, 0.1)


@dataclass(frozen=True, slots=True)
class CenterState:
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
    return np.array((state.com[:2] + state.velocity[:2] / omega + hands.gamma) / hands.kappa)


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
    return np.array(zmp_reference + (1.0 + gain / omega) * (dcm - dcm_reference))


def attitude_shift(
    error: Array, angular_velocity: Array, mass: float, config: DcmConfig
) -> Array:
    """The shift of the ZMP that turns the pelvis upright.

    ΔM = I(k_p e − k_d ω) needs the ground force at p + (−ΔM_y, ΔM_x)/(m g).

    Args:
        error: Rotation vector from measured to desired pelvis attitude, in world, shape (3,) [rad].
        angular_velocity: Pelvis minus desired, in world, shape (3,) [rad/s].
        mass: Robot mass [kg].
        config: Gains.

    Returns:
        Shape (2,) [m].
    """
    moment = config.inertia * (config.attitude_stiffness * error - config.attitude_damping * angular_velocity)
    shift = np.array([-moment[1], moment[0]]) / (mass * GRAVITY)
    return np.clip(shift, -config.attitude_reach, config.attitude_reach)


def yaw_moment(error: Array, angular_velocity: Array, momentum_rate: float, config: DcmConfig) -> float:
    """What the feet must add about the vertical so that the pelvis does not turn with the swing leg.

    M_z = L̇_ref,z + I(k_p e_z − k_d ω_z), within what friction under the soles can do.

    Args:
        error, angular_velocity: As in `attitude_shift`.
        momentum_rate: L̇_z of the reference motion about its CoM [N·m].
        config: Gains.

    Returns:
        [N·m]
    """
    feedback = config.attitude_stiffness * error[2] - config.attitude_damping * angular_velocity[2]
    moment = momentum_rate + config.inertia * float(feedback)
    return min(max(moment, -config.yaw_limit), config.yaw_limit)


def desired_force(
    state: CenterState, height: float, height_velocity: float, zmp: Array, momentum_rate: Array, hands: HandEffect,
    omega: float, mass: float, config: DcmConfig,
) -> Array:
    """What the ground must do to the feet in total.

    F_xy = m ω²(c + γ − κ p − λ̇) − Σ f_hand,xy and F_z = m(g + k_p e_z − k_d ė_z) − Σ f_hand,z.

    Args:
        state: Measured CoM.
        height, height_velocity: Reference of the CoM height [m], [m/s].
        zmp: Desired ZMP before the attitude shift, in world, shape (2,) [m].
        momentum_rate: λ̇, what the swing leg's angular momentum does, shape (2,) [m].
        hands: Effect of the hand forces.
        omega: Natural frequency [1/s].
        mass: Robot mass [kg].
        config: Gains.

    Returns:
        Force on the robot in world, shape (3,) [N].
    """  # fmt: skip
    lever = state.com[:2] + hands.gamma - hands.kappa * zmp - momentum_rate
    horizontal = mass * omega**2 * lever - hands.force[:2]
    lift = config.height_stiffness * (height - state.com[2])
    lift += config.height_damping * (height_velocity - state.velocity[2])
    vertical = mass * (GRAVITY + lift) - hands.force[2]
    return np.array([horizontal[0], horizontal[1], max(float(vertical), 0.0)])
