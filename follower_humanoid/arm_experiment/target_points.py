"""Target-point planning: straight lines of the hand from one target point to the next.

Each line is travelled with the quintic profile `s(u) = 10 u³ − 15 u⁴ + 6 u⁵`: it begins and ends
at rest with no acceleration. v_ref of eq. (6) is its velocity. A hand that is led away from its
line is followed until it rests; then a new line leads from there to the same target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.samples import Array

# The quintic's peak velocity over its mean.
_PEAK = 1.875


@dataclass(frozen=True)
class TargetPoint:
    """Where to go.

    Attributes:
        place: Shape (3,) [m].
        speed: Peak speed on the way there [m/s].
        rest: How long to stay [s].
    """

    place: Array
    speed: float
    rest: float = 0.0


@dataclass(frozen=True)
class Line:
    """Straight motion from rest to rest.

    Attributes:
        begin, end: Shape (3,) [m].
        duration: [s].
    """

    begin: Array
    end: Array
    duration: float

    @staticmethod
    def towards(begin: Array, target: TargetPoint) -> Line:
        """The line to a target at its speed."""
        return Line(begin, target.place, _PEAK * _length(target.place - begin) / target.speed)

    def at(self, time: float) -> tuple[Array, Array]:
        """Place and velocity at a time since the beginning, shapes (3,) [m], (3,) [m/s]."""
        if time >= self.duration:
            return self.end, np.zeros(3)
        u = max(0.0, time / self.duration)
        share = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
        rate = 30.0 * u * u * (1.0 - u) ** 2 / self.duration
        way = self.end - self.begin
        return self.begin + share * way, rate * way


@dataclass(frozen=True)
class Leading:
    """When a hand counts as led away, and as let go.

    Attributes:
        leash: Distance between hand and line beyond which it is led [m].
        rest_speed: Speed below which it rests [m/s].
        rest_time: How long it must rest [s].
    """

    leash: float
    rest_speed: float
    rest_time: float


class TargetPlanner:
    """Goes through target points one by one.

    Attributes:
        done: True once the last point is reached.
        led: True while the hand is led away.
    """

    def __init__(
        self, begin: Array, points: tuple[TargetPoint, ...], leading: Leading, period: float
    ) -> None:
        """Starts at rest at `begin`, shape (3,) [m]; `period` between two steps [s]."""
        self._points, self._leading, self._period = points, leading, period
        self._index = 0
        self._line = Line.towards(begin, points[0])
        self._elapsed = 0.0
        self._quiet = 0.0
        self.done = False
        self.led = False

    def step(self, place: Array, speed: float) -> tuple[Array, Array]:
        """Place and velocity one period later.

        Args:
            place: Of the hand, measured, shape (3,) [m].
            speed: Of the hand, measured [m/s].
        """
        if self.led:
            return self._follow(place, speed), np.zeros(3)
        self._elapsed += self._period
        last = self._index == len(self._points) - 1
        if self._elapsed >= self._line.duration + self._points[self._index].rest:
            if last:
                self.done = True
            else:
                self._elapsed -= self._line.duration + self._points[self._index].rest
                self._index += 1
                self._line = Line.towards(self._line.end, self._points[self._index])
        planned, velocity = self._line.at(self._elapsed)
        if _length(planned - place) > self._leading.leash:
            self.led, self.done, self._quiet = True, False, 0.0
            self._begin_at(place)
            return self._follow(place, speed), np.zeros(3)
        return planned, velocity

    def _follow(self, place: Array, speed: float) -> Array:
        if speed > self._leading.rest_speed:
            self._quiet = 0.0
            self._begin_at(place)
            return place
        self._quiet += self._period
        if self._quiet >= self._leading.rest_time:
            self.led, self._elapsed = False, 0.0
        return self._line.begin

    def _begin_at(self, place: Array) -> None:
        self._line = Line.towards(place, self._points[self._index])


def _length(vector: Array) -> float:
    return math.sqrt(vector @ vector)
