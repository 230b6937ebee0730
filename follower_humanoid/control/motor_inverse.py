"""Voltage from torque: the corrected motor equations (12), (13) solved for the voltage, per joint.

What the controllers believe about the motors; the plant has its own parameters. Terminal
inductance is neglected, as in eq. (15). With gear ratio N, on the output side of the gear:

    K_t = N C_m / R,   k_e = C_e N,   b = B N²,   A = J_r N²
    u = (τ + A q̈ + b q̇) / K_t + k_e q̇

where τ is what reaches the joint. The caller adds A to the diagonal of the mass matrix on actuated
rows, so that τ + A q̈, the `motor_torque` below, comes out of its own equation of motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import RobotModel


@dataclass(frozen=True)
class MotorModel:
    """Nominal motor data of the controllers: one motor for all joints, two gears."""

    resistance: float = parameter(0.608, "terminal resistance R", "ohm", 0.01, 10.0)
    torque_constant: float = parameter(0.0934, "torque per ampere C_m", "N·m/A", 0.001, 1000.0)
    back_emf: float = parameter(0.0934, "voltage per rotor speed C_e", "V·s/rad", 0.0, 1000.0)
    rotor_inertia: float = parameter(5.36e-5, "rotor inertia J_r", "kg·m²", 0.0, 1000.0)
    viscous: float = parameter(1.0e-5, "viscous loss B at the rotor", "N·m·s/rad", 0.0, 10.0)
    gear: float = parameter(50.0, "gear ratio N of all joints but the toes", "", 1.0, 500.0)
    gear_toe: float = parameter(20.0, "gear ratio N of the toe joints", "", 1.0, 500.0)
    voltage_limit: float = parameter(48.0, "largest voltage magnitude", "V", 1.0, 500.0)


class MotorInverse:
    """Motor constants of some joints on the output side, and the voltage that makes a torque.

    Attributes:
        torque_per_volt: K_t, shape (n,) [N·m/V].
        back_emf: k_e, shape (n,) [V·s/rad].
        rotor_inertia: A, reflected, shape (n,) [kg·m²].
        viscous: b, reflected, shape (n,) [N·m·s/rad].
        damping: b + K_t k_e: what a joint feels at constant voltage, shape (n,) [N·m·s/rad].
        voltage_limit: [V].
    """

    def __init__(self, motor: MotorModel, robot: RobotModel, joints: NDArray[np.intp] | None = None) -> None:
        """For the given indices into the 45 actuated joints, in their order; all 45 by default."""
        toes = [name.endswith("_toe_pitch") for name in robot.joint_names]
        gear = np.where(toes, motor.gear_toe, motor.gear)
        if joints is not None:
            gear = gear[joints]
        self.torque_per_volt: Array = gear * motor.torque_constant / motor.resistance
        self.back_emf: Array = gear * motor.back_emf
        self.rotor_inertia: Array = gear**2 * motor.rotor_inertia
        self.viscous: Array = gear**2 * motor.viscous
        self.damping: Array = self.viscous + self.torque_per_volt * self.back_emf
        self.voltage_limit = motor.voltage_limit

    def voltage(self, motor_torque: Array, velocity: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Voltage within the limit: `u = (motor_torque + b q̇)/K_t + k_e q̇`, cut.

        Args:
            motor_torque: τ + A q̈, shape (n,) [N·m].
            velocity: q̇, shape (n,) [rad/s].

        Returns:
            (u, shape (n,) [V]; True where the limit cut it, shape (n,)).

        Reference: Savić et al. 2016, eqs. (12), (13), sign of (13) corrected.
        """
        voltage, cut = np.empty(len(motor_torque)), np.empty(len(motor_torque), dtype=bool)
        _voltage(
            motor_torque, velocity, self.damping, self.torque_per_volt, self.voltage_limit, voltage, cut
        )
        return voltage, cut

    def motor_torque(self, voltage: Array, velocity: Array) -> Array:
        """τ + A q̈ that a voltage makes at a velocity; the inverse of `voltage` where nothing is cut."""
        return self.torque_per_volt * voltage - self.damping * velocity


@kernel(
    "void(float64[::1], float64[::1], float64[::1], float64[::1], float64, float64[::1], boolean[::1])"
)
def _voltage(
    motor_torque: Array, velocity: Array, damping: Array, torque_per_volt: Array, limit: float,
    voltage: Array, saturated: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Writes the voltages and where they are cut, for `MotorInverse.voltage`."""
    for joint in range(motor_torque.size):
        wanted = (motor_torque[joint] + damping[joint] * velocity[joint]) / torque_per_volt[joint]
        voltage[joint] = min(max(wanted, -limit), limit)
        saturated[joint] = voltage[joint] != wanted
