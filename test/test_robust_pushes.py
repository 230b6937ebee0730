"""A short part of `benchmark --robust`: pushes that toppled it once, and what the benchmark is made of."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from follower_humanoid.bench.disturbances import SETTLING, RandomGait, walk
from follower_humanoid.bench.disturbed import Course, Ending, Push, Trial
from follower_humanoid.bench.limits import bisect
from follower_humanoid.core.samples import Joints, Wrench


def ending_of(trial: Trial, push: Push) -> Ending:
    return trial.branch(push.begin + 2.0, push)


def test_a_push_across_at_half_a_metre_per_second_is_caught_either_way() -> None:
    # Both ways at an instant of double support: over the coming stance foot, and away from it.
    trial = Trial(Course(left=(1.0, 0.0, 0.0)), walk(0.30, 0.6))
    trial.run(4.63)
    for sign in (1.0, -1.0):
        ending = ending_of(trial, Push(4.65, np.array([0.0, 20.0 * sign])))
        assert not ending.fall
        assert ending.steps > 5
    trial.close()


@pytest.mark.parametrize(
    ("length", "time", "instant", "impulse"), [(0.35, 0.7, 4.675, -20.0), (0.40, 0.8, 4.7, 20.0)]
)
def test_a_push_over_the_stance_foot_is_caught_in_slower_steps_too(
    length: float, time: float, instant: float, impulse: float
) -> None:
    # The DCM ends at the outer edge of the sole: all of it is needed, at once and for as long as it takes.
    trial = Trial(Course(left=(1.0, 0.0, 0.0)), walk(length, time))
    trial.run(instant - 0.02)
    push = Push(instant, np.array([0.0, impulse]))
    ending = trial.branch(instant + push.time + SETTLING, push)
    trial.close()
    assert ending.settled


def test_standing_it_takes_a_push_backwards_without_a_step() -> None:
    trial = Trial(Course())
    trial.run(0.3)
    ending = ending_of(trial, Push(0.32, np.array([-25.0, 0.0])))
    trial.close()
    assert ending.settled
    assert ending.steps == 0


def test_a_branch_leaves_the_trial_where_it_is() -> None:
    trial = Trial(Course())
    trial.run(0.02)
    pushed = trial.branch(0.1, Push(0.04, np.array([200.0, 0.0]), 0.02))
    plain = trial.run(0.1)
    trial.close()
    assert pushed.place[0] > plain.place[0] + 0.005
    assert abs(plain.place[0] - trial.run(0.0).place[0]) < 1e-12


def test_a_push_gives_its_impulse_and_ends() -> None:
    push = Push(1.0, np.array([3.0, -4.0]))
    impulse = sum(push.force(n * 0.002) for n in range(1000)) * 0.002
    np.testing.assert_allclose(impulse, [3.0, -4.0, 0.0])
    assert not push.force(0.998).any()


def test_a_course_stands_in_for_the_leader_and_makes_commands_late() -> None:
    course = Course(left=(1.0, 2.0, 3.0), delay=2)
    wrench = course("leader/left_hand/wrench", 0, Wrench(np.zeros(3), np.zeros(3)))
    np.testing.assert_array_equal(wrench.force, [1.0, 2.0, 3.0])
    commands = [Joints(np.zeros(1), np.zeros(1), np.full(1, float(n))) for n in range(5)]
    late = [course("legs/command", n, command) for n, command in enumerate(commands)]
    assert [float(command.effort[0]) for command in late] == [0.0, 0.0, 0.0, 1.0, 2.0]
    assert course("imu", 0, "as it was") == "as it was"


def test_random_walks_are_seeded_within_their_ranges_and_change_about_twenty_times_a_minute() -> None:
    gaits = [RandomGait(5)(t) for t in (100.0, 100.0)]
    assert gaits[0] == gaits[1] != RandomGait(6)(100.0)
    walk_ahead = RandomGait(7)
    seen = [walk_ahead(0.01 * n) for n in range(30000)]
    changes = [(a, b) for a, b in itertools.pairwise(seen) if a != b]
    assert 70 < len(changes) < 130
    for before, after in changes:
        turn = math.remainder(after.heading - before.heading, 2 * math.pi)
        assert abs(turn) <= 0.8 * 3 + 1e-9  # up to three changes may fall between two looks
        assert 0.5 <= after.walk_speed <= 1.5
        assert 0.5 <= after.step_length <= 1.25
        assert 0.5 <= after.step_height <= 2.0


def test_bisection_finds_the_limit_to_its_resolution() -> None:
    largest, more = bisect(lambda value: value < 33.0, 10.0, 50.0, 1.0)
    assert 32.0 <= largest < 33.0
    assert not more
    assert bisect(lambda value: True, 10.0, 50.0, 1.0) == (50.0, True)
