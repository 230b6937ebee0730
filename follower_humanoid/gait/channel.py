"""Channels: the coordinates that motion primitives move, each re-aimed at every tick.

A primitive says where its channel must be and how much time is left; the channel answers with the next
position, velocity and acceleration. Because every tick starts from the channel's own state, a
target or a duration may change at any instant without a jump.
"""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array


@kernel("float64[:,::1](float64[::1], float64[::1], float64[::1], float64[::1], float64, float64)")
def along_quintic(
    position: Array, velocity: Array, acceleration: Array, target: Array, T: float, t: float
) -> Array:
    """State at time t of the quintic that ends at rest on the target at time T.

    x(t) = x + v t + a t²/2 + c3 t³ + c4 t⁴ + c5 t⁵ with x(T) = target, ẋ(T) = ẍ(T) = 0.

    Args:
        position, velocity, acceleration: State x, v, a at time 0, shape (n,).
        target: Shape (n,).
        T, t: [s].

    Returns:
        Position, velocity and acceleration, shape (3, n).
    """
    state = np.empty((3, len(position)))
    for i in range(len(position)):
        gap, v, a = target[i] - position[i], velocity[i], acceleration[i]
        c3 = (10.0 * gap - 6.0 * v * T - 1.5 * a * T**2) / T**3
        c4 = (-15.0 * gap + 8.0 * v * T + 1.5 * a * T**2) / T**4
        c5 = (6.0 * gap - 3.0 * v * T - 0.5 * a * T**2) / T**5
        state[0, i] = position[i] + t * (v + t * (0.5 * a + t * (c3 + t * (c4 + t * c5))))
        state[1, i] = v + t * (a + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))
        state[2, i] = a + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))
    return state


class MinimumJerkChannel:
    """A coordinate that reaches its target at rest along the quintic of least jerk (Flash & Hogan 1985).

    Attributes:
        position, velocity, acceleration: Shape (n,), in the units of the coordinate.
    """

    def __init__(self, position: Array) -> None:
        self.reset(position)

    def reset(self, position: Array) -> None:
        """Puts the channel at rest at a position."""
        self.position: Array = np.array(position, dtype=float)
        self.velocity: Array = np.zeros(len(self.position))
        self.acceleration: Array = np.zeros(len(self.position))

    def advance(self, target: Array, remaining: float, dt: float) -> None:
        """One tick along the quintic from the present state to rest at the target.

        Args:
            target: Shape (n,).
            remaining: Time until the target must be reached [s].
            dt: Tick [s].
        """
        if remaining <= dt:
            self.reset(target)
            return
        self.position, self.velocity, self.acceleration = along_quintic(
            self.position, self.velocity, self.acceleration, target, remaining, dt
        )

    def hold(self, dt: float, settling: float = 0.05) -> None:
        """No primitive owns the channel: what speed is left fades within `settling` [s]."""
        self.acceleration = np.zeros(len(self.position))
        if self.velocity.any():
            self.velocity = self.velocity * max(0.0, 1.0 - dt / settling)
            self.position = self.position + dt * self.velocity


class ConstantSpeedChannel:
    """A coordinate that reaches its target at the speed that gets it there in time.

    Attributes:
        position, velocity: Shape (n,).
    """

    def __init__(self, position: Array) -> None:
        self.reset(position)

    def reset(self, position: Array) -> None:
        """Puts the channel at rest at a position."""
        self.position: Array = np.array(position, dtype=float)
        self.velocity: Array = np.zeros(len(self.position))

    def advance(self, target: Array, remaining: float, dt: float) -> None:
        """One tick towards the target; see `MinimumJerkChannel.advance`."""
        if remaining <= dt:
            self.reset(target)
            return
        self.velocity = (target - self.position) / remaining
        self.position = self.position + dt * self.velocity

    def hold(self, dt: float) -> None:
        """No primitive owns the channel: it stays."""
        self.velocity = np.zeros(len(self.position))
