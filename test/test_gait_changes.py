"""Walking parameters that change at any instant are taken over as fast as the walk can follow."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, IdealRobot, WalkerBench

from follower_humanoid.balance.support_polygon import polygon_margin
from follower_humanoid.core.samples import Gait
from follower_humanoid.gait.changes import ChangesConfig, GaitChanges, ZmpRoom, between
from follower_humanoid.gait.motion_config import CompositionConfig
from follower_humanoid.gait.preview import planned_dcm
from follower_humanoid.robot.model import GRAVITY

DT = 0.01
OMEGA = math.sqrt(GRAVITY / 0.85)
ROOM = ZmpRoom(OMEGA, 4.0, 0.03, 0.09)
LONG = replace(AHEAD, step_length=1.25, walk_speed=1.25)


class Restless:
    """All walking parameters change every second, from one end of their ranges to the other."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._next, self._gait = 1.0, AHEAD

    def __call__(self, time: float) -> Gait:
        if time >= self._next:
            draw = self._random
            heading = self._gait.heading + draw.choice([-0.8, 0.0, 0.8])
            speed, length = draw.choice([0.5, 1.5]), draw.choice([0.5, 1.25])
            self._gait = Gait(speed, heading, length, draw.choice([0.5, 2.0]), heading)
            self._next += draw.uniform(0.5, 1.5)
        return self._gait


def strains(eased: bool, seed: int, seconds: float = 25.0) -> tuple[float, float]:
    """Smallest margin of the reference ZMP to its support polygon [m], hardest swing [m/s²]."""
    robot = IdealRobot(dt=DT, config=CompositionConfig(changes=ChangesConfig(eased=eased)))
    gait = Restless(seed)
    margin, hardest = math.inf, 0.0
    while robot.time < seconds:
        robot.tick(gait(robot.time))
        motion = robot.composition._motion
        half = motion.walker.half_step
        margin = min(margin, polygon_margin(motion.walker.support(), motion.pendulum.state.zmp))
        if half is not None and half.single_support:
            hardest = max(hardest, float(np.linalg.norm(half.swing.place.acceleration)))
        if margin < -1.0:
            break
    return margin, hardest


@pytest.mark.parametrize("seed", [1, 2])
def test_changes_one_upon_the_other_ask_for_no_zmp_outside_and_no_jerk_of_the_foot(seed: int) -> None:
    margin, hardest = strains(True, seed)
    assert margin > 0.0
    assert hardest < 12.0


def test_taken_over_at_once_the_same_changes_ask_for_a_zmp_outside() -> None:
    margin, _ = strains(False, 1)
    assert margin < -0.02


class Walking:
    """An undisturbed walk without a body, and the walking parameters that it takes over."""

    def __init__(self, progress: float, gait: Gait = AHEAD) -> None:
        self.bench = WalkerBench(dt=0.005)
        self.changes = GaitChanges(ChangesConfig(), STAND, 4.0)
        self.used = STAND
        while (half := self.bench.walker.half_step) is None or half.swing_progress < progress:
            self.tick(gait)

    def tick(self, gait: Gait) -> Gait:
        """The DCM is where the plan wants it: a pendulum that follows at once."""
        walker = self.bench.walker
        legs = walker.plan_with(self.used).zmp
        dcm = planned_dcm(walker.zmp.position, legs, OMEGA, 4.0)
        self.used = self.changes.step(gait, walker, dcm, ROOM)
        self.bench.tick(self.used)
        return self.used


@pytest.mark.parametrize("progress", [0.02, 0.3])
def test_what_is_within_reach_is_taken_over_at_once(progress: float) -> None:
    for gait in (replace(AHEAD, step_height=2.0), replace(AHEAD, walk_dir=0.3, heading=0.3), LONG):
        assert Walking(progress).tick(gait) == gait


def test_twice_the_length_just_before_the_foot_lands_waits_for_the_next_half_step() -> None:
    walking = Walking(0.75, replace(AHEAD, step_length=0.5))
    wanted = replace(AHEAD, step_length=1.25)
    assert walking.tick(wanted).step_length < 0.6
    walker = walking.bench.walker
    while not walker.taken:
        walking.tick(wanted)
    first = walker.taken[0][0]
    assert first.x < 0.3
    while walking.used != wanted:
        assert walker.swinging is None, "both feet carry: now is the time"
        walking.tick(wanted)
    while len(walker.taken) < 2:
        walking.tick(wanted)
    assert walker.taken[1][0].x - first.x == pytest.approx(0.5, abs=1e-6)


def test_a_stop_that_comes_too_late_for_one_half_step_is_that_of_the_next() -> None:
    quick = replace(AHEAD, walk_speed=3.0)
    walking = Walking(0.75, quick)
    assert walking.tick(STAND) == quick
    walker = walking.bench.walker
    while not walker.taken:
        walking.tick(STAND)
    walking.tick(STAND)
    assert walking.used == STAND
    for _ in range(400):
        walking.tick(STAND)
    assert [counted for _, counted in walker.taken] == [True, False]


def test_before_the_first_foot_has_left_the_ground_a_stop_counts_at_once() -> None:
    walking = Walking(-1.0)
    for _ in range(100):
        walking.tick(AHEAD)
    walking.tick(STAND)
    assert walking.bench.walker.half_step is None


def test_one_that_can_wait_is_not_eased_when_easing_is_off() -> None:
    walking = Walking(0.75)
    walking.changes = GaitChanges(ChangesConfig(eased=False), AHEAD, 4.0)
    assert walking.tick(LONG) == LONG


def test_between_two_headings_lies_the_short_way_round() -> None:
    old, new = replace(AHEAD, heading=3.0, walk_dir=3.0), replace(AHEAD, heading=-3.0, walk_dir=-3.0)
    half = between(old, new, 0.5)
    assert abs(math.remainder(half.heading - math.pi, 2.0 * math.pi)) < 1e-9
    assert half.walk_dir == half.heading
    assert between(old, new, 1.0) == new


def test_the_zmp_has_more_room_on_both_feet_less_the_nearer_the_lift_off_and_none_at_touchdown() -> None:
    assert ROOM.reach(1.0, 3.0) == pytest.approx(0.09)
    assert ROOM.reach(1e-6, 3.0) == pytest.approx(0.03, rel=1e-3)
    assert ROOM.reach(0.0, 3.0) == pytest.approx(0.03, rel=1e-3)
    assert ROOM.reach(0.0, 0.0) == 0.0
    assert np.all(np.diff([ROOM.reach(time, time + 1.0) for time in np.linspace(0.01, 0.5, 20)]) >= 0.0)


@pytest.mark.parametrize("moment", [0.0, 0.2, 0.4])
def test_marching_in_place_ends_with_a_closing_step_and_the_zmp_inside(moment: float) -> None:
    robot = IdealRobot(dt=DT)
    robot.run(4.0 + moment, lambda time: replace(AHEAD, step_length=0.0))
    walker = robot.composition._motion.walker
    taken, margin = len(walker.taken), math.inf
    while walker.half_step is not None:
        robot.tick(STAND)
        margin = min(margin, polygon_margin(walker.support(), robot.composition._motion.pendulum.state.zmp))
    assert margin > 0.0
    assert [counted for _, counted in walker.taken[taken:]][-1] is False
    for _ in range(200):
        robot.tick(STAND)
        margin = min(margin, polygon_margin(walker.support(), robot.composition._motion.pendulum.state.zmp))
    assert margin > 0.0
