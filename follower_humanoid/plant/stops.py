"""Hard stops at the joint ranges: stiff unilateral spring-dampers, linearly implicit.

Per stop:

    τ = −k (q⁺ − q_limit) − d q̇⁺,   q⁺ = q + h q̇⁺,   q̇⁺ = q̇ + h q̈,   never pulling.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.robot.model import BASE_DOF


@dataclass(frozen=True)
class StopConfig:
    """Hard stops at the joint ranges."""

    stiffness: float = parameter(1.0e5, "stiffness of a hard stop", "N·m/rad", 0.0, 1e7)
    damping: float = parameter(500.0, "damping of a hard stop", "N·m·s/rad", 0.0, 1e5)


@kernel("boolean(float64[::1], float64[::1], float64, float64[::1], float64[::1])")
def _any_beyond(position: Array, velocity: Array, step: float, lower: Array, upper: Array) -> bool:
    """True if any q + h q̇ lies outside its range."""
    for n in range(position.shape[0]):
        ahead = position[n] + step * velocity[n]
        if ahead < lower[n] or ahead > upper[n]:
            return True
    return False


class Stops:
    """Both ends of every joint's range.

    Attributes:
        active: True while any joint presses on a stop.
        torque: Torque of the stops in the last step with `active`, shape (45,) [N·m].
    """

    def __init__(self, config: StopConfig, lower: Array, upper: Array, step: float) -> None:
        """Stops at `lower` and `upper`, shape (45,) [rad]; `step` is the physics step [s]."""
        self._stiffness, self._damping, self._step = config.stiffness, config.damping, step
        self._implicit = step * step * config.stiffness + step * config.damping
        self._lower, self._upper = lower, upper
        self.torque = np.zeros_like(lower)
        self.active = False
        self._joints = np.zeros(0, dtype=np.intp)
        self._sign = np.zeros(0)
        self._trial = np.zeros(0)

    def begin(self, position: Array, velocity: Array) -> bool:
        """Finds the joints that will press on a stop; True if there are any."""
        self.active = _any_beyond(position, velocity, self._step, self._lower, self._upper)
        if self.active:
            ahead = position + self._step * velocity
            joints = np.flatnonzero((ahead < self._lower) | (ahead > self._upper))
            low = ahead[joints] < self._lower[joints]
            limit = np.where(low, self._lower[joints], self._upper[joints])
            self._joints, self._sign = joints, np.where(low, 1.0, -1.0)
            self._trial = -self._stiffness * (ahead[joints] - limit) - self._damping * velocity[joints]
        return self.active

    def add_to(self, matrix: Array, right_side: Array) -> None:
        """Adds the implicit stops to the effective mass, shape (51, 51), and forces, shape (51,)."""
        rows = self._joints + BASE_DOF
        matrix[rows, rows] += self._implicit
        right_side[rows] += self._trial

    def finish(self, acceleration: Array) -> bool:
        """Computes the torques; False if a stop would pull: it is released, solve again.

        Args:
            acceleration: Solution of the step, shape (45,) [rad/s²].
        """
        torque = self._trial - self._implicit * acceleration[self._joints]
        pushing = torque * self._sign >= 0.0
        self.torque.fill(0.0)
        self.torque[self._joints] = np.where(pushing, torque, 0.0)
        if pushing.all():
            return True
        self._joints, self._sign = self._joints[pushing], self._sign[pushing]
        self._trial = self._trial[pushing]
        return False
