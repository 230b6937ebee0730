"""What the walking graph must show: scenarios, and for each the required and the measured number."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from follower_humanoid.bench.check import NO_FALL, Check, at_least, at_most
from follower_humanoid.bench.kinematics import Motion, motion_of
from follower_humanoid.bench.measures import (
    first_load_shift,
    newton_residual,
    peak_voltage,
    stop_distance,
    wrench_error,
    zmp_error,
    zmp_margins,
)
from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.gait.mapping import GaitMappingConfig
from follower_humanoid.graph.half_steps import HalfStep, half_steps
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.resources import share_path
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.sensing.low_pass import LowPass


@dataclass(frozen=True)
class Evidence:
    """A run with what is derived from it once."""

    run: Run
    motion: Motion
    steps: list[HalfStep]
    robot: RobotModel

    @classmethod
    def of(cls, run: Run) -> Evidence:
        """Forward kinematics and steps of a run."""
        robot = RobotModel()
        motion = motion_of(run, robot=robot)
        return cls(run, motion, half_steps(run, motion.sole_at), robot)


@dataclass(frozen=True)
class Scenario:
    """A run to make and what to look at.

    Attributes:
        name: As in the table.
        leader: Force programme: built-in name, file under `config/`, or `none`.
        duration: Simulated time [s].
        checks: What must hold.
        brief: Part of the short form, which runs with the tests.
    """

    name: str
    leader: str
    duration: float
    checks: Callable[[Evidence], Iterator[Check]]
    brief: bool = False

    @property
    def programme(self) -> str:
        """Name or path for the leader."""
        return str(share_path(self.leader)) if "/" in self.leader else self.leader


def upright(e: Evidence, duration: float) -> Check:
    """The run lasted as long as asked; a fall ends it."""
    lasted = float(e.motion.times[-1]) + e.run.tick
    return Check(NO_FALL, f"{duration:g} s", f"{lasted:.2f} s", lasted > duration - 2 * e.run.tick)


def walking_checks(e: Evidence, lengths: list[float], heading: float) -> Iterator[Check]:
    """Limits of figs. 4 and 5."""
    counted = [step for step in e.steps if step.counted]
    begins = first_load_shift(e.run)
    yield at_most("first half-step begins after", begins, 0.5, "s")
    wanted = ", ".join(f"{100 * x:.0f}" for x in lengths)
    measured = ", ".join(f"{100 * s.length:.1f}" for s in counted)
    extra = len(counted) - len(lengths)
    worst = max((abs(s.length - x) for s, x in zip(counted, lengths, strict=False)), default=math.inf)
    good = extra in (0, 1) and worst <= 0.015
    yield Check("half-step lengths", f"{wanted} ± 1.5 cm", f"{measured} cm", good)
    landings = [begins] + [s.landing for s in counted]
    times = np.diff(landings)
    spread = f"{times.min():.2f} to {times.max():.2f} s" if len(times) else "none"
    steady = len(times) > 0 and bool(np.all(np.abs(times - 3.1) <= 0.31))
    yield Check("half-step times", "3.1 s ± 10 %", spread, steady)
    final = counted[-1].heading if counted else math.nan
    off = math.degrees(abs(final - heading))
    yield Check("heading", f"{math.degrees(heading):.2f} ± 2°", f"{math.degrees(final):.2f}°", off <= 2.0)
    yield from balance_checks(e)
    yield Check("stands at the end", "both feet carry, feet together", *_stands(e))


def balance_checks(e: Evidence) -> Iterator[Check]:
    """ZMP, margin, voltage."""
    margins = zmp_margins(e.run, e.motion)
    inside = float(np.mean(margins[np.isfinite(margins)] >= 0.025))
    yield at_least("ticks with the ZMP 25 mm inside", inside, 0.99, "%", 100)
    along, across = zmp_error(e.run, e.motion, "zmp_command", 1)
    yield at_most("ZMP from commanded, along", along, 0.012, "mm", 1e3)
    yield at_most("ZMP from commanded, across", across, 0.008, "mm", 1e3)
    along, across = zmp_error(e.run, e.motion, "zmp_reference", 2)
    yield at_most("ZMP from plan, along", along, 0.025, "mm", 1e3)
    yield at_most("ZMP from plan, across", across, 0.012, "mm", 1e3)
    peak = peak_voltage(e.run)
    yield Check("no voltage saturated", "< 48 V", f"{peak:.1f} V", peak < 48.0)


def body_checks(e: Evidence) -> Iterator[Check]:
    """Legs apart, joints off their stops, Newton and Euler hold."""
    yield at_least("distance between the legs", float(e.motion.leg_gap.min()), 0.01, "cm", 100)
    room, joint = stop_distance(e.run, e.robot)
    yield Check("no joint on its stop", "> 0 rad", f"{room:.3f} rad ({joint})", room > 0.0)
    force, moment = newton_residual(e.run, e.motion, e.robot)
    yield at_most("m(c̈ − g) = feet + applied", force, 2.0, "N")
    yield at_most("moments about the CoM", moment, 2.0, "N·m")


def sensing_checks(e: Evidence) -> Iterator[Check]:
    """Sensed against applied hand force."""
    for side in SIDES:
        raw = wrench_error(e.run, side, 0)
        yield at_most(f"sensed force error, {side.value} hand", float(raw.max()), 0.2, "N")
        mapped = wrench_error(e.run, side, 0, _mapping_filter(e.run.tick))
        yield at_most(f"after the mapping's filter, {side.value} hand", float(mapped.max()), 0.05, "N")


def fig4(e: Evidence) -> Iterator[Check]:
    """Fig. 4 of the paper."""
    yield upright(e, FIG_DURATION)
    yield from walking_checks(e, [0.50, 0.50, 0.46, 0.46, 0.46, 0.42, 0.42], 0.0)
    yield from sensing_checks(e)
    yield from body_checks(e)


def fig5(e: Evidence) -> Iterator[Check]:
    """Figs. 5 and 6 of the paper."""
    yield upright(e, FIG_DURATION)
    yield from walking_checks(e, [0.50] * 7, math.atan2(3, 4))
    yield from body_checks(e)


def standing(e: Evidence) -> Iterator[Check]:
    """No leader force."""
    yield upright(e, STAND_DURATION)
    yield Check("steps", "none", str(len(e.steps)), not e.steps)
    along, across = zmp_error(e.run, e.motion, "zmp_reference", 2)
    yield at_most("ZMP error", max(along, across), 0.003, "mm", 1e3)
    drift = float(np.max(np.linalg.norm(e.motion.com[:, :2] - e.motion.com[0, :2], axis=1)))
    yield at_most("drift of the CoM", drift, 0.005, "mm", 1e3)
    yield from body_checks(e)


def off_on_off(e: Evidence) -> Iterator[Check]:
    """Force off, on, off, on, off."""
    yield upright(e, OFF_ON_OFF_DURATION)
    early = [s for s in e.steps if s.landing < 1.0]
    first = [s for s in e.steps if s.counted and s.lift_off < 12.0]
    second = [s for s in e.steps if s.counted and s.lift_off >= 18.0]
    yield Check("no step before the force", "0", str(len(early)), not early)
    yield Check("steps of the first pull", "≥ 2", str(len(first)), len(first) >= 2)
    yield Check("stands in between", "both feet carry, feet together", *_stands(e, 17.9))
    yield Check("steps of the second pull", "≥ 2", str(len(second)), len(second) >= 2)
    yield Check("stands at the end", "both feet carry, feet together", *_stands(e))
    yield from body_checks(e)


def one_hand(e: Evidence) -> Iterator[Check]:
    """A pull on one hand only goes straight."""
    yield upright(e, ONE_HAND_DURATION)
    counted = [s for s in e.steps if s.counted]
    worst = max((abs(s.heading) for s in counted), default=math.inf)
    yield Check("half-steps", "≥ 5", str(len(counted)), len(counted) >= 5)
    yield at_most("heading", math.degrees(worst), 3.0, "°")
    yield from balance_checks(e)
    yield from body_checks(e)


def hand_horizontal(e: Evidence) -> Iterator[Check]:
    """5 N horizontally: the hand gives way and returns."""
    yield upright(e, HAND_DURATION)
    for side in SIDES:
        away = _displacement(e, side)[:, :2]
        distance = np.linalg.norm(away, axis=1)
        t = e.motion.times - 1.0
        peak = float(np.max(distance[(t > 0) & (t <= 1.0)]))
        late = float(np.max(distance[(t > 5.0) & (t < 7.0)]))
        yield at_least(f"peak within 1 s, {side.value} hand", peak, 0.020, "mm", 1e3)
        yield at_most(f"after 5 s, {side.value} hand", late, 0.005, "mm", 1e3)
    yield from body_checks(e)


def hand_vertical(e: Evidence) -> Iterator[Check]:
    """10 N vertically on either hand: it stays."""
    yield upright(e, HAND_DURATION)
    for side in SIDES:
        away = _displacement(e, side)[:, 2]
        yield at_most(
            f"vertical displacement, {side.value} hand", float(np.abs(away).max()), 0.005, "mm", 1e3
        )
    yield from body_checks(e)


def _displacement(e: Evidence, side: Side) -> Array:
    """Of the hand relative to the pelvis since the force began, shape (T, 3) [m]."""
    start = int(np.searchsorted(e.motion.times, 1.0))
    away = e.motion.hand[side] - e.motion.hand[side][start]
    away[:start] = 0.0
    return np.asarray(away)


def _stands(e: Evidence, time: float | None = None) -> tuple[str, bool]:
    """In words and as a verdict: feet side by side and both loaded."""
    row = len(e.motion.times) - 1 if time is None else int(np.searchsorted(e.motion.times, time))
    yaw = e.motion.sole_yaw[Side.LEFT][row]
    away = e.motion.sole[Side.LEFT][row] - e.motion.sole[Side.RIGHT][row]
    apart = abs(float(away[0] * math.cos(yaw) + away[1] * math.sin(yaw)))
    loads = [float(e.run[f"{side.value}_foot/wrench"].force[row, 2]) for side in SIDES]
    words = f"{1e3 * apart:.0f} mm apart along, loads {loads[0]:.0f} and {loads[1]:.0f} N"
    return words, apart < 0.03 and min(loads) > 100.0


def _mapping_filter(tick: float) -> Callable[[Array], Array]:
    """The mapping's own low-pass at its own rate."""
    period = NODES["gait_mapping"].period

    def smooth(values: Array) -> Array:
        low_pass = LowPass(GaitMappingConfig().filter_time, period * tick)
        return np.array([low_pass.step(value) for value in values[::period]])

    return smooth


FIG_DURATION = 30.0
STAND_DURATION = 60.0
OFF_ON_OFF_DURATION = 36.0
ONE_HAND_DURATION = 20.0
HAND_DURATION = 8.0

SCENARIOS: tuple[Scenario, ...] = (
    Scenario("fig. 4", "fig4", FIG_DURATION, fig4, brief=True),
    Scenario("fig. 5", "fig5", FIG_DURATION, fig5),
    Scenario("no leader force", "none", STAND_DURATION, standing),
    Scenario("off, on, off", "config/benchmark/off_on_off.yaml", OFF_ON_OFF_DURATION, off_on_off),
    Scenario("left hand only", "config/benchmark/left_hand.yaml", ONE_HAND_DURATION, one_hand),
    Scenario("right hand only", "config/benchmark/right_hand.yaml", ONE_HAND_DURATION, one_hand),
    Scenario(
        "hand, 5 N horizontal",
        "config/benchmark/hand_horizontal.yaml",
        HAND_DURATION,
        hand_horizontal,
        brief=True,
    ),
    Scenario(
        "hand, 10 N vertical", "config/benchmark/hand_vertical.yaml", HAND_DURATION, hand_vertical, brief=True
    ),
)
