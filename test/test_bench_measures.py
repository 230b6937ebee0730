"""Measures of a run, on runs that are made up so that the answer is known."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from gait_bench import robot, vertical

from follower_humanoid.bench.kinematics import Motion
from follower_humanoid.bench.measures import (
    at_ticks,
    first_load_shift,
    ground_zmp,
    moving_mean,
    newton_residual,
    peak_voltage,
    rms,
    stop_distance,
    wrench_error,
    zmp_error,
    zmp_margins,
)
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Point, Sample, Side, Wrench
from follower_humanoid.graph.record import Run, RunRecorder
from follower_humanoid.robot.model import GRAVITY

TICK = 0.002
NOTHING = Wrench(np.zeros(3), np.zeros(3))
SOLE = np.array([[-0.07, 0.05], [-0.07, -0.05], [0.12, 0.05], [0.12, -0.05], [0.19, 0.04], [0.19, -0.04]])


def run_of(**topics: list[Sample]) -> Run:
    """A run from lists of samples, one per tick; two underscores in a name stand for a slash."""
    recorder = RunRecorder(TICK, robot().joint_names, robot().urdf)
    for name, samples in topics.items():
        for tick, sample in enumerate(samples):
            recorder.add(name.replace("__", "/"), tick, sample)
    return recorder.finish()


def motion(ticks: int, **values: Any) -> Motion:
    """Feet at ±9 cm, level, all else at zero."""
    both = {
        "sole": {side: np.tile([0.0, side.sign * 0.09, 0.0], (ticks, 1)) for side in SIDES},
        "sole_rotation": {side: np.tile(np.eye(3), (ticks, 1, 1)) for side in SIDES},
        "contacts": np.tile(
            np.vstack(
                [np.column_stack((SOLE + np.array([0.0, side.sign * 0.09]), np.zeros(6))) for side in SIDES]
            ),
            (ticks, 1, 1),
        ),
        "times": np.arange(ticks) * TICK,
        "com": np.zeros((ticks, 3)),
        "momentum": np.zeros((ticks, 6)),
        "gripper": {side: np.zeros((ticks, 3)) for side in SIDES},
    }
    empty = dict.fromkeys(field.name for field in dataclasses.fields(Motion))
    return Motion(**{**empty, **both, **values})


def still(ticks: int) -> dict[str, list[Sample]]:
    """Joints and base that do not move."""
    joints = Joints(np.zeros(45), np.zeros(45), np.zeros(45))
    base = Odometry(np.array([0.0, 0.0, 0.9]), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))
    return {"joint_states": [joints] * ticks, "odom": [base] * ticks}


def unloaded(ticks: int) -> dict[str, list[Sample]]:
    names = (
        "left_foot__wrench",
        "right_foot__wrench",
        "left_hand__applied",
        "right_hand__applied",
        "base__applied",
    )
    return {name: [NOTHING] * ticks for name in names}


def ground(x: float, y: float) -> Point:
    return Point(np.array([x, y, 0.0]))


def test_rms_and_moving_mean() -> None:
    assert rms(np.array([3.0, -4.0])) == pytest.approx(math.sqrt(12.5))
    assert math.isnan(rms(np.zeros(0)))
    values = np.random.default_rng(1).normal(size=(20, 2))
    expected = [values[k : k + 5].mean(axis=0) for k in range(16)]
    np.testing.assert_allclose(moving_mean(values, 5), expected, atol=1e-12)


def test_values_at_ticks_are_taken_exactly_or_not_at_all() -> None:
    recorder = RunRecorder(TICK, robot().joint_names, robot().urdf)
    for tick in (2, 3, 6):
        recorder.add("zmp", tick, ground(tick, 0.0))
    found = at_ticks(recorder.finish()["zmp"], "xyz", np.array([0, 2, 3, 4, 6, 9]))[:, 0]
    np.testing.assert_array_equal(found, [np.nan, 2.0, 3.0, np.nan, 6.0, np.nan])


def pushed(force: float, forward: float, left: float) -> Wrench:
    """A vertical force at a point of a level sole, told at the sole origin."""
    return Wrench(np.array([0.0, 0.0, force]), np.array([left * force, -forward * force, 0.0]))


def feet(ticks: int, x: float, y: float, share: float = 0.5) -> dict[str, list[Sample]]:
    """Both feet loaded so that the ZMP lies at (x, y): each has its own there, moved by where it stands."""
    weight, middle = 700.0, 0.09 * (2.0 * share - 1.0)
    left, right = pushed(share * weight, x, y - middle), pushed((1.0 - share) * weight, x, y - middle)
    return {"left_foot__wrench": [left] * ticks, "right_foot__wrench": [right] * ticks}


@pytest.mark.parametrize(
    ("place", "margin"),
    [
        ((0.05, 0.0), 0.12),
        ((0.15, 0.0), 0.04),
        ((0.05, 0.13), 0.01),
        ((0.05, 0.16), -0.02),
        ((-0.10, 0.0), -0.03),
    ],
)
def test_margin_is_positive_inside_the_feet_and_negative_outside(
    place: tuple[float, float], margin: float
) -> None:
    run = run_of(**still(2), **feet(2, *place))
    np.testing.assert_allclose(ground_zmp(run, motion(2)), [place, place], atol=1e-12)
    np.testing.assert_allclose(zmp_margins(run, motion(2)), margin, atol=1e-9)


def test_zmp_is_told_in_world_whatever_way_the_soles_point() -> None:
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    posed = motion(1, sole_rotation=dict.fromkeys(SIDES, turned[None]))
    run = run_of(**still(1), left_foot__wrench=[pushed(600.0, 0.05, 0.01)], right_foot__wrench=[NOTHING])
    np.testing.assert_allclose(ground_zmp(run, posed)[0], [-0.01, 0.09 + 0.05], atol=1e-12)


def test_only_loaded_feet_and_points_on_the_ground_count() -> None:
    # 2 % of the weight is too little to count as a foot that carries, 5 % is not.
    light, heavy = (
        zmp_margins(run_of(**still(1), **feet(1, 0.05, 0.03, share)), motion(1)) for share in (0.98, 0.95)
    )
    assert light[0] == pytest.approx(-0.01)  # the left foot's inner edge is at 4 cm
    assert heavy[0] > 0.03
    assert math.isnan(zmp_margins(run_of(**still(1), **unloaded(1)), motion(1))[0])
    raised = motion(1)
    raised.contacts[:, [4, 5], 2] = 0.01  # left toes in the air
    alone = run_of(**still(1), left_foot__wrench=[pushed(700.0, 0.15, 0.0)], right_foot__wrench=[NOTHING])
    assert zmp_margins(alone, raised)[0] == pytest.approx(-0.03)


def test_zmp_error_is_told_along_and_across_the_heading_and_after_the_delay() -> None:
    ticks, yaw = 6, 0.5
    c, s = math.cos(yaw), math.sin(yaw)
    wanted = [ground(0.01 * k, 0.0) for k in range(ticks)]
    # Two ticks later the ZMP is 3 mm short along the heading and 4 mm to its right.
    places = [(0.01 * (k - 2) - 0.003 * c + 0.004 * s, -0.003 * s - 0.004 * c) for k in range(ticks)]
    loads = [feet(1, *place) for place in places]
    topics = {name: [load[name][0] for load in loads] for name in loads[0]}
    run = run_of(**still(ticks), **topics, zmp_reference=wanted)
    posed = motion(ticks, pelvis_yaw=np.full(ticks, yaw))
    assert zmp_error(run, posed, "zmp_reference", 2) == pytest.approx((0.003, 0.004))
    assert zmp_error(run, posed, "zmp_reference", 1)[0] > 0.005


def test_the_first_shift_of_load_is_found() -> None:
    topics = {"left_foot__wrench": [vertical(350.0)] * 3 + [vertical(390.0)] * 4,
              "right_foot__wrench": [vertical(350.0)] * 3 + [vertical(310.0)] * 4}  # fmt: skip
    assert first_load_shift(run_of(**topics), 50.0) == pytest.approx(3 * TICK)
    assert first_load_shift(run_of(**topics), 100.0) == math.inf


def test_peak_voltage_and_distance_to_the_stops() -> None:
    legs, arms = robot().groups.legs, robot().groups.arms

    def volts(size: int, peak: float) -> Joints:
        effort = np.zeros(size)
        effort[3] = peak
        return Joints(np.zeros(size), np.zeros(size), effort)

    run = run_of(
        legs__command=[volts(len(legs), 3.0), volts(len(legs), -7.5)], arms__command=[volts(len(arms), 2.0)]
    )
    assert peak_voltage(run) == 7.5
    middle = 0.5 * (robot().lower + robot().upper)
    near = middle.copy()
    near[5] = robot().upper[5] - 0.01
    joints = [Joints(q, np.zeros(45), np.zeros(45)) for q in (middle, near, middle)]
    assert stop_distance(run_of(joint_states=joints), robot()) == (
        pytest.approx(0.01),
        robot().joint_names[5],
    )
    near[5] = robot().upper[5] + 0.02
    assert stop_distance(run_of(joint_states=joints), robot())[0] == pytest.approx(-0.02)


def test_error_of_a_sensed_force_per_axis_lag_and_filter() -> None:
    def pull(x: float) -> Wrench:
        return Wrench(np.array([x, 0.0, -10.0]), np.zeros(3))

    applied = [pull(float(k)) for k in range(8)]
    sensed = [pull(float(k) - 1.0 + 0.3) for k in range(8)]
    run = run_of(left_hand__wrench=sensed, left_hand__applied=applied)
    np.testing.assert_allclose(wrench_error(run, Side.LEFT, 1), [0.3, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(wrench_error(run, Side.LEFT, 0), [0.7, 0.0, 0.0], atol=1e-9)
    halved = wrench_error(run, Side.LEFT, 1, lambda error: 0.5 * error)
    np.testing.assert_allclose(halved, [0.15, 0.0, 0.0], atol=1e-9)


TICKS = 400
TIMES = np.arange(TICKS) * TICK
WEIGHT = np.array([0.0, 0.0, -robot().mass * GRAVITY])


def integral(force: Array, moment: Array | None = None) -> Array:
    """Momentum under a constant force and moment, shape (T, 6)."""
    moment = np.zeros(3) if moment is None else moment
    return np.asarray(TIMES[:, None] * np.concatenate((force, moment)))


def test_free_fall_leaves_no_residual() -> None:
    falling = motion(TICKS, momentum=integral(WEIGHT))
    run = run_of(**still(TICKS), **unloaded(TICKS))
    assert newton_residual(run, falling, robot()) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_force_that_was_left_out_shows_with_its_size() -> None:
    pushed = motion(TICKS, momentum=integral(WEIGHT + np.array([3.0, 0.0, 4.0]), np.array([0.0, 2.0, 0.0])))
    run = run_of(**still(TICKS), **unloaded(TICKS))
    assert newton_residual(run, pushed, robot()) == pytest.approx((5.0, 2.0), abs=1e-6)


def test_forces_at_feet_hands_and_base_are_taken_in_with_their_levers() -> None:
    rng = np.random.default_rng(4)
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    foot = Wrench(np.array([20.0, -5.0, 600.0]), np.array([3.0, -8.0, 1.0]))
    hand = Wrench(np.array([5.0, 2.0, -10.0]), np.array([0.5, 0.2, -0.1]))
    base = Wrench(np.array([0.0, 30.0, 0.0]), np.zeros(3))
    com, grip, sole, pelvis = rng.normal(0, 0.3, (4, 3))
    total = turned @ foot.force + hand.force + base.force + WEIGHT
    moment = turned @ foot.torque + np.cross(sole - com, turned @ foot.force)
    moment += hand.torque + np.cross(grip - com, hand.force) + np.cross(pelvis - com, base.force)
    posed = motion(
        TICKS,
        momentum=integral(total, moment),
        com=np.tile(com, (TICKS, 1)),
        gripper={side: np.tile(grip, (TICKS, 1)) for side in SIDES},
        sole={side: np.tile(sole, (TICKS, 1)) for side in SIDES},
        sole_rotation={side: np.tile(turned, (TICKS, 1, 1)) for side in SIDES},
    )
    odometry = Odometry(pelvis, np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))
    topics = {
        **still(TICKS), **unloaded(TICKS), "odom": [odometry] * TICKS, "left_foot__wrench": [foot] * TICKS,
        "right_hand__applied": [hand] * TICKS, "base__applied": [base] * TICKS,
    }  # fmt: skip
    assert newton_residual(run_of(**topics), posed, robot()) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_jerk_shorter_than_the_window_is_averaged() -> None:
    # A force of one tick that was published is matched by the jump of momentum over the same tick.
    momentum = integral(WEIGHT)
    momentum[200:, 0] += 50.0 * TICK
    topics = {**still(TICKS), **unloaded(TICKS)}
    topics["base__applied"] = [
        Wrench(np.array([50.0, 0.0, 0.0]), np.zeros(3)) if tick == 200 else NOTHING for tick in range(TICKS)
    ]
    force, _ = newton_residual(run_of(**topics), motion(TICKS, momentum=momentum), robot())
    assert force == pytest.approx(0.0, abs=1e-6)
    late = dict(topics, base__applied=[NOTHING] * TICKS)
    force, _ = newton_residual(run_of(**late), motion(TICKS, momentum=momentum), robot())
    assert 0.0 < force <= 50.0 * TICK / 0.25 + 1e-9
