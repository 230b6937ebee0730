"""What the motor drives do with commands, and without them.

A drive whose commands stop holds the references of the last one. A command may leave them out
(nan): then it holds the position it finds when the hold begins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Joints
from follower_humanoid.plant.motors import MotorConfig
from follower_humanoid.robot.model import Indices, RobotModel


@dataclass(frozen=True)
class HoldConfig:
    """Local loop of a drive whose commands have stopped."""

    stiffness: float = parameter(300.0, "voltage per position error", "V/rad", 0.0, 1e5)
    damping: float = parameter(5.0, "voltage per velocity error", "V·s/rad", 0.0, 1e4)
    stop_margin: float = parameter(0.0, "distance of a held position from the joint stops", "rad", 0.0, 0.5)
    velocity_limit: float = parameter(20.0, "largest velocity of a reference", "rad/s", 0.0, 100.0)


class Drives:
    """One group of motor drives: pass commanded voltages on, or hold the last references.

    Attributes:
        missed: Ticks without a usable command.
        holding: True while commands are missing.
        limited: References taken over for holding that were beyond joint range or velocity limit.
        slack: The robot has fallen: motors are short-circuited, which damps their joints.
    """

    def __init__(self, config: HoldConfig, motors: MotorConfig, robot: RobotModel, joints: Indices) -> None:
        """Drives of `joints` (indices into the 45)."""
        self._config, self.joints = config, joints
        motor = motors.chosen()
        toe = np.array(["toe" in robot.joint_names[j] for j in joints])
        self._back_emf = np.where(toe, motor.toe_gear, motor.gear) * motor.back_emf_constant
        self._limit = motor.voltage_limit
        lower, upper = robot.lower[joints], robot.upper[joints]
        margin = np.minimum(config.stop_margin, 0.5 * (upper - lower))  # of a short range: its middle
        self._lower, self._upper = lower + margin, upper - margin
        self.missed = self.limited = 0
        self.slack = False
        self.holding = False
        size = len(joints)
        self._load, self._reference = np.zeros(size), np.zeros(size)
        self._command: Joints | None = None

    def start(self, position: Array, voltage: Array) -> None:
        """Takes the standing posture as the last reference, held by `voltage`; shapes (45,)."""
        self._reference = position[self.joints].copy()
        self._load = voltage[self.joints].copy()
        self._command = None
        self.holding = True
        self.slack = False

    def slacken(self) -> None:
        """From here on no voltage, whatever is commanded."""
        self.slack = True

    def receive(self, command: Joints | None) -> None:
        """Takes the command of a control tick; None or numbers that are not finite: none."""
        if command is not None and math.isfinite(sum(command.effort.tolist())):
            self._command = command
            self.holding = False
            return
        self.missed += 1
        self.holding = True
        if self._command is not None:
            self._take_over(self._command)
            self._command = None

    def _take_over(self, command: Joints) -> None:
        """Prepares to hold the references of the last command and the load that it carried."""
        self._reference = np.clip(command.position, self._lower, self._upper)
        # What holds the load once the motion has ended: the voltage less its back-EMF share.
        limited = np.clip(command.effort, -self._limit, self._limit)
        velocity = np.where(np.isfinite(command.velocity), command.velocity, 0.0)
        fast = self._config.velocity_limit
        beyond = (self._reference != command.position) & np.isfinite(command.position)
        self.limited += int(bool(beyond.any() or (np.abs(velocity) > fast).any()))
        velocity = np.clip(velocity, -fast, fast)
        self._load = limited - self._back_emf * velocity

    def write(self, position: Array, velocity: Array, voltage: Array) -> None:
        """Writes this group's voltages of a physics step into `voltage`, shape (45,)."""
        if self.slack:
            voltage[self.joints] = 0.0
            return
        if self._command is not None:
            voltage[self.joints] = self._command.effort
            return
        self._reference = np.where(np.isfinite(self._reference), self._reference, position[self.joints])
        error = self._reference - position[self.joints]
        voltage[self.joints] = (
            self._load + self._config.stiffness * error - self._config.damping * velocity[self.joints]
        )
