"""Hard to topple: what the robot must survive, row by row (`./scripts/benchmark --robust`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from follower_humanoid.bench.check import NO_FALL, Check, at_least, at_most
from follower_humanoid.bench.disturbed import Course, Ending, Push, Trial
from follower_humanoid.core.samples import Array, Gait
from follower_humanoid.graph.simulate import Parameters

DIRECTIONS = tuple(math.radians(angle) for angle in range(0, 360, 45))
SETTLING = 3.0  # time after a push within which the robot must stand or walk on [s]
FIG4_PULL = (5.0, 0.0, -10.0)
FIG4_TIME = 22.0


def walk(length: float, time: float) -> dict[str, dict[str, Any]]:
    """Parameters of a walk with half-steps of so many metres and seconds, whatever the pull."""
    return {
        "motion_composition": {
            "walker.half_step_time": time, "footsteps.half_step_length": length, "walker.stand_time": 0.7,
        },
        "gait_mapping": {"divisor": 1000.0},
    }  # fmt: skip


def pushes(course: Course, parameters: Parameters, impulse: float, instants: list[float]) -> Iterator[Check]:
    """An impulse of 0.1 s on the pelvis in eight directions at each instant."""
    trial = Trial(course, parameters)
    for instant in instants:
        trial.run(instant - 0.02)
        survived, failed = 0, []
        for angle in DIRECTIONS:
            push = Push(instant, impulse * np.array([math.cos(angle), math.sin(angle)]))
            ending = trial.branch(instant + push.time + SETTLING, push)
            survived += ending.settled
            if not ending.settled:
                failed.append(f"{math.degrees(angle):.0f}°: {ending.fall or 'not settled'}")
        words = f"{survived} of {len(DIRECTIONS)}" + "".join(f"; {line}" for line in failed)
        yield Check(f"{impulse:g} N·s at {instant:.2f} s", "8 of 8, settled in 3 s", words, not failed)
    trial.close()


def pushes_standing() -> Iterator[Check]:
    """25 N·s while it stands."""
    yield from pushes(Course(), {}, 25.0, [1.0])


def pushes_paper_speed() -> Iterator[Check]:
    """10 N·s at four instants of a half-step of fig. 4: 0.15 m/s."""
    yield from pushes(Course(left=FIG4_PULL), {}, 10.0, [6.0, 6.8, 7.6, 8.4])


def pushes_fast(length: float, time: float) -> Iterator[Check]:
    """20 N·s at four instants of a half-step of so many metres and seconds."""
    instants = [4.5 + time * quarter / 4 for quarter in range(4)]
    yield from pushes(Course(left=(1.0, 0.0, 0.0)), walk(length, time), 20.0, instants)


def one_run(course: Course, duration: float, parameters: Parameters | None = None) -> Ending:
    """A whole run."""
    trial = Trial(course, parameters)
    ending = trial.run(duration)
    trial.close()
    return ending


def no_fall(ending: Ending, duration: float) -> Check:
    """The run lasted as long as asked."""
    return Check(NO_FALL, f"{duration:g} s", ending.fall or f"{ending.time:.2f} s", not ending.fall)


class RandomGait:
    """All four walking parameters change at random instants.

    Speed 0.5–1.5, length 0.5–1.25, height 0.5–2, direction by up to ±0.8 rad.
    """

    PER_MINUTE = 20.0

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._next = 1.0
        self._gait = Gait(1.0, 0.0, 1.0, 1.0, 0.0)

    def __call__(self, time: float) -> Gait:
        """The walking parameters at a time [s]; times must not go back."""
        while time >= self._next:
            draw = self._random
            heading = self._gait.heading + float(draw.uniform(-0.8, 0.8))
            heading = math.remainder(heading, 2.0 * math.pi)
            self._gait = Gait(
                walk_speed=float(draw.uniform(0.5, 1.5)), walk_dir=heading,
                step_length=float(draw.uniform(0.5, 1.25)), step_height=float(draw.uniform(0.5, 2.0)),
                heading=heading,
            )  # fmt: skip
            self._next += float(draw.exponential(60.0 / self.PER_MINUTE))
        return self._gait


def random_changes(duration: float = 300.0, seed: int = 1) -> Iterator[Check]:
    """Random walking parameters, 20 changes a minute."""
    ending = one_run(Course(gait=RandomGait(seed)), duration)
    yield no_fall(ending, duration)
    yield at_least("half-steps", ending.steps, duration / 8.0)


def fast_walk(length: float, time: float, steps: int) -> Iterator[Check]:
    """So many half-steps straight ahead."""
    duration = 1.5 + time * (steps + 1)
    ending = one_run(Course(left=(1.0, 0.0, 0.0)), duration, walk(length, time))
    yield no_fall(ending, duration)
    yield at_least("half-steps", ending.steps, steps)
    yield at_least("smallest ZMP margin", ending.margin, 0.0, "mm", 1e3)


def always(gait: Gait) -> Callable[[float], Gait]:
    """The same walking parameters all the time."""
    return lambda time: gait


def other_ways() -> Iterator[Check]:
    """Backward, sideways, turning in place."""
    backward = one_run(Course(gait=always(Gait(0.5, math.pi, 0.5, 1.0, 0.0))), 20.0)
    yield from _gone("backward, steps of 0.2 m", backward, np.array([-0.9, 0.0]))
    for sign, word in ((1.0, "left"), (-1.0, "right")):
        gait = Gait(0.375, sign * math.pi / 2, 0.375, 1.0, 0.0)
        sideways = one_run(Course(gait=always(gait)), 20.0)
        yield from _gone(f"to the {word}, steps of 0.15 m", sideways, np.array([0.0, sign * 0.3]))
    turned = one_run(Course(gait=turn_in_place), 30.0)
    yield from _gone("turning in place", turned, np.zeros(2))
    yield at_most("turning in place: way", float(np.hypot(*turned.place[:2])), 0.3, "m")
    off = math.degrees(abs(turned.place[2] - math.pi / 2))
    yield at_most("turning in place: heading off 90°", off, 3.0, "°")
    marched = one_run(Course(gait=march_in_place), 11.0)
    yield from _gone("marching and turning in place", marched, np.zeros(2))
    yield at_most("marching and turning in place: way", float(np.hypot(*marched.place[:2])), 0.3, "m")
    yield at_least("marching and turning in place: smallest ZMP margin", marched.margin, 0.0, "mm", 1e3)


def turn_in_place(time: float) -> Gait:
    """By 90° in steps of next to no length, 3.1 s each, then stands."""
    return Gait(0.1 if time < 22.0 else 0.0, math.pi / 2, 0.1, 1.0, math.pi / 2)


def march_in_place(time: float) -> Gait:
    """By 90° in half-steps of no length, as quick as they may be, then stands."""
    return Gait(1.0 if time < 7.0 else 0.0, math.pi / 2, 0.0, 1.0, math.pi / 2)


def _gone(what: str, ending: Ending, least: Array) -> Iterator[Check]:
    yield Check(f"{what}: {NO_FALL}", "no fall", ending.fall or "none", not ending.fall)
    for i, name in enumerate(("x", "y")):
        if least[i] != 0.0:
            words = f"{ending.place[i]:.2f} m"
            good = ending.place[i] * np.sign(least[i]) >= abs(least[i])
            yield Check(f"{what}: {name}", f"at least {least[i]:g} m", words, bool(good))


def hand_forces() -> Iterator[Check]:
    """Steady forces on both hands: twenty half-steps, or standing where the law does not walk."""
    for force in ((15.0, 0.0, -10.0), (-15.0, 0.0, -10.0), (0.0, 15.0, -10.0), (0.0, -15.0, -10.0)):
        duration = 4.0 + 20 * 3.1
        ending = one_run(Course(left=force, right=force), duration)
        name = f"({force[0]:g}, {force[1]:g}, {force[2]:g}) N on each hand"
        good = not ending.fall and ending.steps >= 20
        yield Check(name, "20 half-steps", ending.fall or f"{ending.steps}", good)
    down = one_run(Course(left=(0.0, 0.0, -50.0), right=(0.0, 0.0, -50.0)), 10.0)
    good = down.settled and down.steps == 0
    yield Check("50 N down on each hand", "stands", down.fall or f"{down.steps} steps", good)


NOISE = {
    "sensors.wrist_force_noise": 0.5, "sensors.foot_force_noise": 0.5,
    "sensors.position_noise": 1e-4, "sensors.velocity_noise": 1e-2, "sensors.gyro_noise": 1e-2,
}  # fmt: skip
PLANTS: dict[str, dict[str, Any]] = {
    "mass + 10 %": {"body.mass_scale": 1.1},
    "mass - 10 %": {"body.mass_scale": 0.9},
    "3 kg in each hand, unknown": {"body.left_hand_load": 3.0, "body.right_hand_load": 3.0},
    "sensor noise": NOISE,
    "friction 0.4": {"ground.friction": 0.4},
    "floor falling by 2°": {"ground.slope": math.radians(2.0)},
    "floor rising by 2°": {"ground.slope": -math.radians(2.0)},
}
DELAY = 3  # ticks of 2 ms: not less than 5 ms


def other_plants() -> Iterator[Check]:
    """Fig. 4 with a body, sensors or a floor that the controllers do not know of."""
    for name, parameters in PLANTS.items():
        yield _fig4(name, Course(left=FIG4_PULL), {"simulator": parameters})
    slope = {"simulator": {"ground.slope": math.radians(2.0)}}
    yield _fig4("floor falling by 2°, turning across it", Course(left=(0.0, 5.0, -10.0)), slope)
    yield _fig4("commands 6 ms late", Course(left=FIG4_PULL, delay=DELAY), {})


def _fig4(name: str, course: Course, parameters: Parameters) -> Check:
    ending = one_run(course, FIG4_TIME, parameters)
    words = ending.fall or f"{ending.steps} half-steps, margin {1e3 * ending.margin:.0f} mm"
    return Check(f"fig. 4, {name}", "no fall, 6 half-steps", words, not ending.fall and ending.steps >= 6)


ROWS: dict[str, Callable[[], Iterator[Check]]] = {
    "push standing": pushes_standing,
    "push at paper speed": pushes_paper_speed,
    "push at 0.5 m/s": lambda: pushes_fast(0.30, 0.6),
    "push at 0.5 m/s, steps of 0.35 m": lambda: pushes_fast(0.35, 0.7),
    "push at 0.5 m/s, steps of 0.40 m": lambda: pushes_fast(0.40, 0.8),
    "random changes": random_changes,
    "0.5 m/s": lambda: fast_walk(0.35, 0.7, 40),
    "0.75 m/s": lambda: fast_walk(0.45, 0.6, 20),
    "other ways": other_ways,
    "hand forces": hand_forces,
    "other plants": other_plants,
}
