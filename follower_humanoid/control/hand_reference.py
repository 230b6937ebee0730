"""What the arm controller wants of the hands from tick to tick: goals, and how they are come back to.

A hand's *goal* is where it belongs: the place of the first tick, or the target somebody sends. The
*anchor* is the point that is controlled to: goal + offset. The offset is zero until a hand has been
led away; afterwards it is what lies between hand and goal, and glides to zero, so that no mode
switch and no jump of a target pulls at the arm. The posture has an offset of its own.

A goal has the velocity that its target says while that moves on. Where no target comes, or the same
place again, the velocity fades: a hand rests at the last target, not ahead of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.control.hand_task import HandMotion, Mask
from follower_humanoid.core.samples import Array, Odometry

# A target that moves further than its velocity says by more than this has jumped [m].
_JUMP = 1e-3
# A goal that stays where it is loses its velocity in this time [s].
_FADE = 0.2
# An offset decays with this rate where it is too small for the speed limit to matter [1/s].
_LAST_RATE = 5.0


@dataclass(frozen=True)
class GlideLimits:
    """How fast offsets may go to zero.

    Attributes:
        hand: [m/s].
        posture: [rad/s].
        rise: Time in which a glide comes to its speed [s].
    """

    hand: float
    posture: float
    rise: float


class HandReference:
    """References of both hands, left first. Axes of places: pelvis-yaw.

    Attributes:
        place: Anchor, x_d of eq. (18), shape (2, 3) [m].
        rate: Its rate of change, shape (2, 3) [m/s].
        virtual: Place that the springs of the impedance pull to: the anchor, displaced by the
            integral of what eq. (17) adds to v_ref, shape (2, 3) [m].
        posture: q_0, shape (2, 7) [rad].
        saturated: Which arm has a motor at its voltage limit, shape (2,).
        all_loaded: The first wrenches of both hands have come.
    """

    def __init__(
        self, place: Array, posture: Array, limits: GlideLimits, period: float, any_posture: bool = False
    ) -> None:
        """The hands belong where they are.

        Args:
            place, posture: Of the hands now, shapes (2, 3) [m] and (2, 7) [rad].
            limits: How fast offsets may go to zero.
            period: Control tick [s].
            any_posture: A hand that has been led keeps the posture it came to.
        """
        self._any_posture = any_posture
        self.place, self.posture, self.virtual = place.copy(), posture, place.copy()
        self.rate = np.zeros((2, 3))
        self.saturated: Mask = np.zeros(2, dtype=bool)
        self._loaded, self.all_loaded = [False, False], False
        self._goal, self._goal_rate = self.place, np.zeros((2, 3))
        self._said_rate = np.zeros((2, 3))  # what the targets say
        self._still = [_FADE, _FADE]  # how long each goal has stayed where it is, at most that long [s]
        self._first_posture = posture
        self._offset, self._posture_offset = np.zeros((2, 3)), np.zeros((2, 7))
        self._limits, self._period = limits, period
        self._gliding = np.zeros(2)  # how long each hand has been gliding [s]
        self._free = True  # all offsets are zero

    def take_load(self, felt: Array, measured: tuple[bool, bool], limit: Array, stiffness: Array) -> None:
        """Lets the springs carry the first force measured: the robot starts with the object in hand.

        Args:
            felt: Force on each hand, shape (2, 3) [N].
            measured: Whose force has been measured.
            limit: Of what the springs take over, shape (3,) [N].
            stiffness: Of the springs, shape (3,) [N/m].
        """
        for hand, known in enumerate(measured):
            if known and not self._loaded[hand]:
                self.virtual[hand] -= np.clip(felt[hand], -limit, limit) / stiffness
                self._loaded[hand] = True
        self.all_loaded = all(self._loaded)

    def receive(self, targets: tuple[Odometry | None, Odometry | None]) -> None:
        """Takes the targets of this tick; None: none has come."""
        for hand, target in enumerate(targets):
            if target is None:
                if self._still[hand] < _FADE:
                    self._stay(hand)
                continue
            self._said_rate[hand] = target.linear_velocity
            if np.array_equal(target.position, self._goal[hand]):
                self._stay(hand)
                continue
            self._still[hand] = 0.0
            expected = self._goal[hand] + self._period * self._goal_rate[hand]
            goal, rate = self._goal.copy(), self._goal_rate.copy()
            goal[hand], rate[hand] = target.position, target.linear_velocity
            jump = goal[hand] - expected
            if math.sqrt(jump @ jump) > _JUMP:
                self._offset[hand] -= jump
                self._gliding[hand] = 0.0
                self._free = False
            self._goal, self._goal_rate = goal, rate
            self._move(hand, goal[hand] + self._offset[hand], rate[hand])

    def glide(self, yielding: Mask) -> None:
        """Brings offsets nearer to zero, except of hands that are being led."""
        if self._free:
            return
        for hand in range(2):
            if yielding[hand]:
                continue
            self._gliding[hand] += self._period
            share = min(1.0, self._gliding[hand] / self._limits.rise)
            back = -share * _decay_rate(self._offset[hand], self._limits.hand) * self._offset[hand]
            self._offset[hand] += self._period * back
            turn = share * _decay_rate(self._posture_offset[hand], self._limits.posture)
            self._posture_offset[hand] -= self._period * turn * self._posture_offset[hand]
            self._move(hand, self._goal[hand] + self._offset[hand], self._goal_rate[hand] + back)
        self.posture = self._first_posture + self._posture_offset

    def follow(self, yielding: Mask, hands: HandMotion, posture: Array) -> None:
        """Lets go: the references of hands that are being led are where these are."""
        self._free = False
        place, rate, virtual = self.place.copy(), self.rate.copy(), self.virtual.copy()
        place[yielding] = virtual[yielding] = hands.place[yielding]
        rate[yielding] = 0.0
        self.place, self.rate, self.virtual = place, rate, virtual
        self._offset[yielding] = (hands.place - self._goal)[yielding]
        if self._any_posture:
            self._first_posture = np.where(yielding[:, None], posture, self._first_posture)
        self._posture_offset[yielding] = (posture - self._first_posture)[yielding]
        self._gliding[yielding] = 0.0
        self.posture = self._first_posture + self._posture_offset

    def move_posture(self, velocity: Array) -> None:
        """Lets the wanted posture move on with q̇_d, shape (2, 7) [rad/s]."""
        self._first_posture = self._first_posture + self._period * velocity
        self.posture = self._first_posture + self._posture_offset

    def _stay(self, hand: int) -> None:
        """The goal stays where it is for one more tick."""
        self._still[hand] = min(self._still[hand] + self._period, _FADE)
        rate = self._goal_rate.copy()
        rate[hand] = (1.0 - self._still[hand] / _FADE) * self._said_rate[hand]
        self._goal_rate = rate
        self._move(hand, self._goal[hand] + self._offset[hand], rate[hand])

    def _move(self, hand: int, place: Array, rate: Array) -> None:
        """Moves an anchor and takes the springs' end along."""
        places, rates, virtual = self.place.copy(), self.rate.copy(), self.virtual.copy()
        virtual[hand] += place - places[hand]
        places[hand], rates[hand] = place, rate
        self.place, self.rate, self.virtual = places, rates, virtual


def _decay_rate(offset: Array, speed: float) -> float:
    """Rate of an exponential decay that is nowhere faster than a speed [1/s]."""
    size = math.sqrt(offset @ offset)
    return min(_LAST_RATE, speed / size) if size > 0.0 else 0.0
