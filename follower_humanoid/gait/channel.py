"""Channels: the coordinates that motion primitives move, each re-aimed at every tick.

A primitive says where its channel must be and how much time is left; the channel answers with the next
position, velocity and acceleration. Because every tick starts from the channel's own state, a
target or a duration may change at any instant without a jump.
"""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.core.kernel import kernel, kernel_part
from follower_humanoid.core.samples import Array


@kernel_part
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


GENTLY = 0.2  # a stop takes at least this times the speed: some 10 m/s² [s²/m], [s²/rad]


@kernel_part
def time_not_beyond(position: Array, velocity: Array, acceleration: Array, target: Array, T: float) -> float:
    """The time T, or less where the quintic of `along_quintic` would go beyond its target and come back.

    A coordinate under way that is given more time would otherwise swing out. With the gap D to the target,
    v and a along it, x⃛(T) ≥ 0 asks for 30 D − 12 v T − 1.5 a T² ≥ 0: times up to the first root.
    """
    D = v = a = 0.0
    for i in range(len(position)):
        D += (target[i] - position[i]) ** 2
    D = max(math.sqrt(D), 1e-9)
    for i in range(len(position)):
        along = (target[i] - position[i]) / D
        v += along * velocity[i]
        a += along * acceleration[i]
    inner = 144.0 * v**2 + 180.0 * a * D
    if inner < 0.0:
        return T  # it slows down before the target by itself
    outer = 12.0 * v + math.sqrt(inner)
    if outer < 1e-9:
        return T
    # The first root, in the form that needs no division by a.
    soon = 60.0 * D / outer
    return min(T, max(soon, GENTLY * v))


SAMPLES = 8  # of an acceleration that has its extremes in between


@kernel("float64[:,::1](float64[::1], float64[::1], float64[::1], float64[::1], float64, float64)")
def least_jerk_tick(
    position: Array, velocity: Array, acceleration: Array, target: Array, remaining: float, dt: float
) -> Array:
    """State after a tick `dt` [s] on the way to rest at the target in `remaining` [s] or sooner.

    Arguments and what is returned as in `along_quintic`.
    """
    time = time_not_beyond(position, velocity, acceleration, target, remaining)
    if time <= dt:
        arrived = np.zeros((3, len(position)))
        arrived[0] = target
        return arrived
    return along_quintic(position, velocity, acceleration, target, time, dt)


@kernel("float64(float64[::1], float64[::1], float64[::1], float64[::1], float64)")
def hardest_to_come(
    position: Array, velocity: Array, acceleration: Array, target: Array, remaining: float
) -> float:
    """Largest acceleration still to come on the way of `least_jerk_tick`, its start left out."""
    T = time_not_beyond(position, velocity, acceleration, target, remaining)
    largest = 0.0
    for n in range(1, SAMPLES):
        to_come = along_quintic(position, velocity, acceleration, target, T, T * n / SAMPLES)[2]
        largest = max(largest, math.sqrt(np.sum(to_come**2)))
    return largest


@kernel("float64[:,::1](float64[::1], float64[::1], float64, float64)")
def constant_speed_tick(position: Array, target: Array, remaining: float, dt: float) -> Array:
    """Position and velocity after a tick `dt` [s] on the straight way to a target in `remaining` [s].

    Args:
        position, target: Shape (n,).
        remaining, dt: [s].

    Returns:
        Shape (2, n); at rest on the target if it is reached within the tick.
    """
    state = np.zeros((2, len(position)))
    for i in range(len(position)):
        if remaining <= dt:
            state[0, i] = target[i]
        else:
            state[1, i] = (target[i] - position[i]) / remaining
            state[0, i] = position[i] + dt * state[1, i]
    return state


class MinimumJerkChannel:
    """A coordinate that reaches its target at rest along the quintic of least jerk (Flash & Hogan 1985).

    Attributes:
        position, velocity, acceleration: Shape (n,), in the units of the coordinate.
    """

    def __init__(self, position: Array) -> None:
        self.position: Array = np.array(position, dtype=float)
        self.velocity = self.acceleration = self._none = np.zeros(len(self.position))

    def advance(self, target: Array, remaining: float, dt: float) -> None:
        """One tick along the quintic from the present state to rest at the target.

        Args:
            target: Shape (n,).
            remaining: Time until the target must be reached [s].
            dt: Tick [s].
        """
        state = least_jerk_tick(self.position, self.velocity, self.acceleration, target, remaining, dt)
        self.position, self.velocity, self.acceleration = state[0], state[1], state[2]

    def effort(self, target: Array, remaining: float) -> float:
        """Largest acceleration on the way to a target that must be reached in `remaining` [s]."""
        if remaining <= 0.0:
            return 0.0
        return float(hardest_to_come(self.position, self.velocity, self.acceleration, target, remaining))

    def hold(self, dt: float, settling: float = 0.05) -> None:
        """No primitive owns the channel: what speed is left fades within `settling` [s]."""
        self.acceleration = self._none
        if any(self.velocity.tolist()):
            self.velocity = self.velocity * max(0.0, 1.0 - dt / settling)
            self.position = self.position + dt * self.velocity


class ConstantSpeedChannel:
    """A coordinate that reaches its target at the speed that gets it there in time.

    Attributes:
        position, velocity: Shape (n,).
    """

    def __init__(self, position: Array) -> None:
        self.position: Array = np.array(position, dtype=float)
        self.velocity = self._none = np.zeros(len(self.position))

    def advance(self, target: Array, remaining: float, dt: float) -> None:
        """One tick towards the target; see `MinimumJerkChannel.advance`."""
        state = constant_speed_tick(self.position, target, remaining, dt)
        self.position, self.velocity = state[0], state[1]

    def hold(self, dt: float) -> None:
        """No primitive owns the channel: it stays."""
        del dt
        self.velocity = self._none
