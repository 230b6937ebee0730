"""Voltage-driven DC motors behind gears: Savić et al. 2016, eqs. (12) and (13), sign corrected.

    u = R i + C_e ω + L di/dt        τ = C_m i − B ω − J_r ω̇        ω = N q̇

Integrated linearly implicitly: current and back-EMF are those at the end of the physics step, so
that the loop through the rotor's inertia has no lag. On the output side, with Z = R + L/h:

    τ = τ_u − D (q̇ + h q̈) − A q̈
    τ_u = N C_m (u + L i/h)/Z,    D = N² (C_m C_e/Z + B),    A = N² J_r
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import RobotModel


@dataclass(frozen=True)
class MotorConfig:
    """One motor type for all joints, toes with a lower gear."""

    named_set: str = parameter(
        "own", "own: the values below; paper: the values of the paper's authors", choices=("own", "paper")
    )
    resistance: float = parameter(0.608, "terminal resistance R", "Ω", 1e-3, 100.0)
    inductance: float = parameter(0.423e-3, "terminal inductance L", "H", 0.0, 1.0)
    torque_constant: float = parameter(0.0934, "torque constant C_m, rotor side", "N·m/A", 1e-6, 1e3)
    back_emf_constant: float = parameter(0.0934, "back-EMF constant C_e, rotor side", "V·s/rad", 0.0, 1e3)
    rotor_inertia: float = parameter(5.36e-5, "rotor inertia J_r, rotor side", "kg·m²", 0.0, 1e3)
    viscous_loss: float = parameter(1.0e-5, "viscous loss B, rotor side", "N·m·s/rad", 0.0, 10.0)
    gear: float = parameter(50.0, "gear ratio N", "", 1e-3, 1e4)
    toe_gear: float = parameter(20.0, "gear ratio of the toe joints", "", 1e-3, 1e4)
    voltage_limit: float = parameter(48.0, "largest voltage, either sign", "V", 0.0, 1e3)

    def chosen(self) -> MotorConfig:
        """The values of the named set."""
        return PAPER_MOTORS if self.named_set == "paper" else self


# The paper's authors' values, given on the output side (so no gear): near velocity sources.
PAPER_MOTORS = replace(
    MotorConfig(),
    named_set="paper", resistance=1.6, inductance=2.3e-3, torque_constant=75.5, back_emf_constant=72.2,
    rotor_inertia=73.9, viscous_loss=0.00923, gear=1.0, toe_gear=1.0, voltage_limit=200.0,
)  # fmt: skip


@kernel(
    "void(float64[::1], float64[::1], float64, float64, float64, float64[::1], float64[::1], float64[::1], "
    "float64[::1], float64[::1], float64[::1], float64[::1])"
)
def _begin(
    voltage: Array, current: Array, limit: float, keep: float, current_per_volt: float,
    torque_per_current: Array, damping: Array, velocity: Array,
    clipped: Array, open_current: Array, drive: Array, forces: Array,
) -> None:  # fmt: skip
    """Writes what is known before q̈ is: the voltage that acts, (u + L i/h)/Z and τ_u; adds τ_u − D q̇.

    Args:
        voltage, current: u, i.
        limit: Of the voltage.
        keep: L/h.
        current_per_volt: 1/Z.
        torque_per_current: N C_m.
        damping, velocity: D, q̇.
        clipped, open_current, drive: Written.
        forces: Changed.
    """
    for n in range(voltage.shape[0]):
        clipped[n] = max(min(voltage[n], limit), -limit)
        open_current[n] = (current[n] * keep + clipped[n]) * current_per_volt
        drive[n] = open_current[n] * torque_per_current[n]
        forces[n] += drive[n] - damping[n] * velocity[n]


@kernel(
    "void(float64[::1], float64[::1], float64, float64[::1], float64[::1], float64[::1], float64[::1], "
    "float64[::1], float64[::1], float64[::1])"
)
def _finish(
    acceleration: Array, velocity: Array, step: float, open_current: Array, drive: Array,
    current_per_velocity: Array, damping: Array, inertia: Array, current: Array, torque: Array,
) -> None:  # fmt: skip
    """Writes current and torque at the end of a step: i = open − (N C_e/Z) q̇⁺, eq. (13) with q̇⁺ and q̈."""
    for n in range(drive.shape[0]):
        end_velocity = velocity[n] + step * acceleration[n]
        current[n] = open_current[n] - current_per_velocity[n] * end_velocity
        torque[n] = drive[n] - damping[n] * end_velocity - inertia[n] * acceleration[n]


class Motors:
    """The 45 motors, output side.

    Attributes:
        inertia: Reflected rotor inertia A, shape (45,) [kg·m²].
        damping: Implicit damping D, shape (45,) [N·m·s/rad].
        drive: Torque τ_u of this step, shape (45,) [N·m].
        current: Shape (45,) [A].
        voltage: As clipped at the last step, shape (45,) [V].
    """

    def __init__(self, config: MotorConfig, robot: RobotModel, step: float) -> None:
        """Motors at rest; `step` is the physics step [s]."""
        motor = config.chosen()
        toe = np.array(["toe" in name for name in robot.joint_names])
        gear = np.where(toe, motor.toe_gear, motor.gear)
        self._step = step
        self._keep = motor.inductance / step
        impedance = motor.resistance + self._keep
        self.voltage_limit = motor.voltage_limit
        self.resistance = motor.resistance
        self.torque_per_current: Array = gear * motor.torque_constant
        self.current_per_volt = 1.0 / impedance
        self.current_per_velocity: Array = gear * motor.back_emf_constant / impedance
        self.inertia: Array = gear**2 * motor.rotor_inertia
        self.damping: Array = self.torque_per_current * self.current_per_velocity
        self.damping += gear**2 * motor.viscous_loss
        self._open_current = np.zeros_like(gear)
        self.current = np.zeros_like(gear)
        self.drive = np.zeros_like(gear)
        self.voltage = np.zeros_like(gear)

    def hold(self, torque: Array) -> None:
        """Sets the currents that hold a static torque, shape (45,) [N·m]."""
        self.current[:] = torque / self.torque_per_current
        self.voltage[:] = self.resistance * self.current

    def begin(self, voltage: Array, velocity: Array, forces: Array) -> None:
        """Begins a step: adds the torque at q̈ = 0, τ_u − D q̇, to the joints' forces.

        Args:
            voltage: Of this step, clipped to the limit, shape (45,) [V].
            velocity: Joint velocity, shape (45,) [rad/s].
            forces: Changed, shape (45,) [N·m].
        """
        _begin(
            voltage, self.current, self.voltage_limit, self._keep, self.current_per_volt,
            self.torque_per_current, self.damping, velocity,
            self.voltage, self._open_current, self.drive, forces,
        )  # fmt: skip

    def finish(self, acceleration: Array, velocity: Array) -> Array:
        """Ends the step: updates the currents, returns eq. (13)'s torque on the joints, (45,) [N·m].

        Args:
            acceleration: Joint acceleration of this step, shape (45,) [rad/s²].
            velocity: Joint velocity at its beginning, shape (45,) [rad/s].
        """
        torque = np.empty(len(self.drive))
        _finish(
            acceleration, velocity, self._step, self._open_current, self.drive, self.current_per_velocity,
            self.damping, self.inertia, self.current, torque,
        )  # fmt: skip
        return torque
