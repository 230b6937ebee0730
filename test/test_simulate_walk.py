"""The first seconds of the paper's fig. 4 on real physics: it stands, starts and lifts its foot, honestly."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.bench.kinematics import Motion, motion_of
from follower_humanoid.bench.measures import (
    newton_residual,
    peak_voltage,
    stop_distance,
    wrench_error,
    zmp_error,
    zmp_margins,
)
from follower_humanoid.core.samples import SIDES, Side
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.robot.model import GRAVITY, RobotModel

SECONDS = 2.6


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate("fig4", SECONDS)


@pytest.fixture(scope="module")
def motion(run: Run) -> Motion:
    return motion_of(run)


def test_the_run_lasts_as_long_as_asked(run: Run) -> None:
    assert run.notes == ()
    assert len(run["joint_states"]) == round(SECONDS / run.tick)
    assert run.duration == pytest.approx(SECONDS - run.tick)


def test_it_begins_standing_still_with_its_weight_on_both_feet(run: Run) -> None:
    weight = RobotModel().mass * GRAVITY
    early = [run[f"{side.value}_foot/wrench"].force[:50, 2] for side in SIDES]
    np.testing.assert_allclose(early[0] + early[1], weight, rtol=0.10)
    assert np.abs(run["joint_states"].velocity[0]).max() == 0.0


def test_it_starts_to_walk_within_half_a_second(run: Run) -> None:
    begin = run["gait"].times[run["gait"].walk_speed > 0.0][0]
    assert 0.2 <= begin <= 0.5
    assert run["gait"].walk_speed[-1] == pytest.approx(1.25, abs=0.01)
    active = [names for names in (sample.names for sample in run["primitives"].samples) if names]
    assert active[0] == ("lean",)


def test_the_right_foot_lifts_off_and_swings_forward_while_the_left_one_carries(
    run: Run, motion: Motion
) -> None:
    load = {side: run[f"{side.value}_foot/wrench"].force[:, 2] for side in SIDES}
    air = load[Side.RIGHT] < 5.0
    assert 1.2 < motion.times[air][0] < 2.2
    assert load[Side.LEFT][air].min() > 500.0
    sole = motion.sole[Side.RIGHT]
    assert sole[:, 2].max() > 0.03
    assert sole[-1, 0] > sole[0, 0] + 0.05
    still = motion.sole[Side.LEFT]
    assert np.abs(still - still[0]).max() < 0.01


def test_zmp_stays_inside_and_near_what_is_commanded(run: Run, motion: Motion) -> None:
    margins = zmp_margins(run, motion)
    assert np.mean(margins >= 0.025) > 0.99
    assert max(zmp_error(run, motion, "zmp_command", 1)) < 0.012


def test_newton_and_euler_hold_for_what_was_recorded(run: Run, motion: Motion) -> None:
    force, moment = newton_residual(run, motion, RobotModel())
    assert force < 2.0
    assert moment < 2.0


def test_no_voltage_saturates_and_no_joint_is_on_its_stop(run: Run) -> None:
    assert peak_voltage(run) < 48.0
    room, joint = stop_distance(run, RobotModel())
    assert room > 0.02, joint


def test_the_pull_is_sensed(run: Run) -> None:
    for side in SIDES:
        assert wrench_error(run, side, 0).max() < 0.5  # with the jerk of its beginning
    np.testing.assert_allclose(run["left_hand/wrench"].force[-200:].mean(axis=0), [5, 0, -10], atol=0.2)


def test_legs_keep_apart(motion: Motion) -> None:
    assert motion.leg_gap.min() > 0.01
