"""How much the robot stands, found by bisection (`./scripts/benchmark --limits`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from follower_humanoid.bench.disturbances import DIRECTIONS, FIG4_PULL, SETTLING, one_run, walk
from follower_humanoid.bench.disturbed import Course, Push, Trial


@dataclass(frozen=True)
class Limit:
    """One line of the table of limits.

    Attributes:
        what: What was made larger.
        largest: The largest that was survived.
        unit: Of it.
        open: True if the end of the range was survived too.
    """

    what: str
    largest: float
    unit: str
    open: bool

    def __str__(self) -> str:
        """As shown in the table."""
        return f"{'≥ ' if self.open else ''}{self.largest:.3g} {self.unit}"


def bisect(
    survives: Callable[[float], bool], low: float, high: float, resolution: float
) -> tuple[float, bool]:
    """The largest value that is survived, and whether even `high` is.

    Takes for granted that `low` is survived and that what is survived is below what is not.

    Args:
        survives: Tries a value.
        low, high: Range.
        resolution: How far the answer may be below the true limit.
    """
    if survives(high):
        return high, True
    while high - low > resolution:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if survives(middle) else (low, middle)
    return low, False


def push_limits() -> Iterator[Limit]:
    """Largest impulse of 0.1 s on the pelvis while it stands and while it walks, per direction."""
    fast = Course(left=(1.0, 0.0, 0.0))
    yield from _push_limits("standing", Trial(Course()), 1.0, (20.0, 60.0))
    yield from _push_limits("at 0.5 m/s", Trial(fast, walk(0.30, 0.6)), 4.65, (10.0, 50.0))


def _push_limits(name: str, trial: Trial, instant: float, span: tuple[float, float]) -> Iterator[Limit]:
    trial.run(instant - 0.02)
    for angle in DIRECTIONS:

        def survives(impulse: float, angle: float = angle) -> bool:
            push = Push(instant, impulse * np.array([math.cos(angle), math.sin(angle)]))
            return trial.branch(instant + push.time + SETTLING, push).settled

        largest, more = bisect(survives, *span, 5.0)
        yield Limit(f"push {name}, towards {math.degrees(angle):.0f}°", largest, "N·s", more)
    trial.close()


def speed_limit() -> Iterator[Limit]:
    """Fastest walk, half-steps of 0.6 s, ten seconds without a fall."""

    def survives(speed: float) -> bool:
        return not one_run(Course(left=(1.0, 0.0, 0.0)), 10.0, walk(0.6 * speed, 0.6)).fall

    largest, more = bisect(survives, 0.75, 1.05, 0.05)
    yield Limit("walk", largest, "m/s", more)


def hand_limits() -> Iterator[Limit]:
    """Largest steady force on each hand for 15 s, in five directions, besides 10 N down."""
    directions = {
        "ahead": (1.0, 0.0, 0.0), "back": (-1.0, 0.0, 0.0), "to the left": (0.0, 1.0, 0.0),
        "to the right": (0.0, -1.0, 0.0), "down": (0.0, 0.0, -1.0),
    }  # fmt: skip
    for name, direction in directions.items():

        def survives(force: float, direction: tuple[float, float, float] = direction) -> bool:
            x, y, z = (force * part for part in direction)
            hand = (x, y, z - 10.0)
            return not one_run(Course(left=hand, right=hand), 15.0).fall

        largest, more = bisect(survives, 10.0, 50.0 if direction[2] == 0.0 else 130.0, 10.0)
        yield Limit(f"force on each hand, {name}", largest, "N", more)


def payload_limit() -> Iterator[Limit]:
    """Largest mass in each hand, unknown to the controllers, with which it walks fig. 4 for 12 s."""

    def survives(mass: float) -> bool:
        load = {"simulator": {"body.left_hand_load": mass, "body.right_hand_load": mass}}
        return not one_run(Course(left=FIG4_PULL), 12.0, load).fall

    largest, more = bisect(survives, 3.0, 11.0, 1.0)
    yield Limit("mass in each hand, fig. 4", largest, "kg", more)


LIMITS: dict[str, Callable[[], Iterator[Limit]]] = {
    "push": push_limits,
    "speed": speed_limit,
    "hands": hand_limits,
    "payload": payload_limit,
}
