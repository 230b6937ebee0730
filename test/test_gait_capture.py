"""Capture steps: a push moves and hurries the landing; without one nothing is touched. Limits of the gait."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, IdealRobot, WalkerBench, inputs_of, vertical

from follower_humanoid.core.samples import SIDES, Array, Gait, Point, Side
from follower_humanoid.gait.capture import CaptureConfig, footprint_weight, landing_shift, shifted
from follower_humanoid.gait.composition import MotionComposition
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.limits import GaitLimits, limited
from follower_humanoid.gait.preview import planned_dcm

CONFIG = CaptureConfig()
OMEGA = 3.4
LANDING = FootPose(Side.LEFT, 0.4, 0.09, 0.0)


@pytest.mark.parametrize("progress", [0.1, 0.5, 0.75])
def test_the_weight_is_what_a_shifted_footprint_does_to_the_planned_dcm(progress: float) -> None:
    bench = WalkerBench()
    while bench.walker.half_step is None or bench.walker.half_step.swing_progress < progress:
        bench.tick(AHEAD)
    walker = bench.walker
    weight = footprint_weight(*walker.landing_times(), OMEGA)
    before = planned_dcm(walker.zmp.position, walker.plan_ahead(AHEAD).zmp, OMEGA, math.inf)
    assert walker.landing is not None
    walker.landing = shifted(walker.landing, np.array([0.1, 0.05]))
    after = planned_dcm(walker.zmp.position, walker.plan_ahead(AHEAD).zmp, OMEGA, math.inf)
    outward = walker.landing.side.sign
    np.testing.assert_allclose(after - before, weight * np.array([0.1, outward * 0.05]), rtol=1e-6)


def test_the_weight_of_a_sudden_change_is_its_discount() -> None:
    assert footprint_weight(0.5, 0.0, OMEGA) == pytest.approx(math.exp(-OMEGA * 0.5))
    assert footprint_weight(0.5, 1e-5, OMEGA) == pytest.approx(math.exp(-OMEGA * 0.5), rel=1e-4)
    assert footprint_weight(0.0, 0.5, OMEGA) < 1.0


def test_an_error_within_the_reserve_is_left_to_the_zmp() -> None:
    for error in ([0.049, 0.0], [0.0, 0.021], [-0.049, -0.021]):
        np.testing.assert_array_equal(landing_shift(np.array(error), LANDING, 0.5, CONFIG), np.zeros(2))


def test_what_goes_beyond_moves_the_landing_just_so_far_that_the_plan_meets_it() -> None:
    shift = landing_shift(np.array([0.08, 0.042]), LANDING, 0.5, CONFIG)
    np.testing.assert_allclose(shift, [0.03 / 0.5, 0.02 / 0.5])
    backward = landing_shift(np.array([-0.08, 0.0]), LANDING, 0.5, CONFIG)
    np.testing.assert_allclose(backward, [-0.06, 0.0])


def test_shifts_have_limits_and_inwards_the_narrowest() -> None:
    far = np.array([5.0, 5.0])
    np.testing.assert_allclose(landing_shift(far, LANDING, 0.5, CONFIG), [CONFIG.forward, CONFIG.outward])
    np.testing.assert_allclose(landing_shift(-far, LANDING, 0.5, CONFIG), [-CONFIG.forward, -CONFIG.inward])
    hopeless = landing_shift(np.array([0.06, 0.0]), LANDING, 1e-12, CONFIG)
    np.testing.assert_allclose(hopeless, [CONFIG.amplification * 0.01, 0.0])


def test_left_and_right_are_mirror_images_and_axes_are_those_of_the_foot() -> None:
    error = np.array([0.09, -0.05])
    right = replace(LANDING, side=Side.RIGHT)
    one = landing_shift(error, LANDING, 0.5, CONFIG)
    two = landing_shift(error * [1.0, -1.0], right, 0.5, CONFIG)
    np.testing.assert_allclose(one, two)
    c, s = math.cos(2.0), math.sin(2.0)
    turned = np.array([[c, -s], [s, c]]) @ error
    np.testing.assert_allclose(landing_shift(turned, replace(LANDING, yaw=2.0), 0.5, CONFIG), one)


def test_a_landing_is_shifted_in_its_own_axes() -> None:
    moved = shifted(replace(LANDING, yaw=math.pi / 2), np.array([0.1, 0.05]))
    assert (moved.x, moved.y) == pytest.approx((0.35, 0.19))
    right = shifted(FootPose(Side.RIGHT, 0.4, -0.09, 0.0), np.array([0.0, 0.05]))
    assert right.y == pytest.approx(-0.14)
    assert moved.yaw == pytest.approx(math.pi / 2)


@cache
def _swinging() -> IdealRobot:
    ideal = IdealRobot(dt=0.01)
    while ideal.time < 1.7:
        ideal.tick(AHEAD)
    return ideal


def pushed(error: tuple[float, float]) -> tuple[IdealRobot, float, FootPose]:
    """The rest of the first step with a DCM measured off its plan, how long it took and where it landed."""
    ideal = copy.deepcopy(_swinging())
    begin, number = ideal.time, len(ideal.steps())
    composition = ideal.composition
    while len(ideal.steps()) == number:
        last = ideal.outputs[-1]
        dcm = Point(last.dcm_reference.xyz + np.array([*error, 0.0]))
        loads = {f"{side.value}_foot": vertical(700.0 * ideal.loads[side]) for side in SIDES}
        values = {"joints": ideal.joints, "odometry": ideal.base, "gait": AHEAD, "dcm": dcm, **loads}
        out = composition.step(inputs_of(MotionComposition, **values), ideal.time)
        ideal.time += ideal.dt
        ideal.joints, ideal.base = out.reference, out.base
        total = out.contacts.left + out.contacts.right
        ideal.loads = {Side.LEFT: out.contacts.left / total, Side.RIGHT: out.contacts.right / total}
        ideal.outputs.append(out)
        error = (0.0, 0.0)  # the push was short: the reference has taken it over
    step = ideal.steps()[-1]
    return (
        ideal,
        ideal.time - begin,
        FootPose(step.side, float(step.position[0]), float(step.position[1]), step.yaw),
    )


def test_a_dcm_on_its_plan_changes_nothing() -> None:
    _, usual, foot = pushed((0.0, 0.0))
    assert usual == pytest.approx(3.1 - 1.7, abs=0.05)
    assert (foot.x, foot.y) == pytest.approx((0.4, -0.09), abs=2e-3)


def joint_jump(ideal: IdealRobot) -> Array:
    rates = np.array([out.reference.velocity for out in ideal.outputs])
    return np.asarray(np.abs(np.diff(rates, axis=0)))


def test_a_push_makes_the_foot_land_sooner_and_further_out() -> None:
    _, usual, _ = pushed((0.0, 0.0))
    ideal, hurried, foot = pushed((0.0, -0.05))
    assert foot.side is Side.RIGHT
    assert hurried < 0.6 * usual
    assert foot.y < -0.13
    assert foot.y > -0.09 - CONFIG.outward - 0.01
    assert np.isfinite(joint_jump(ideal)).all()


def test_a_push_forward_makes_the_step_longer() -> None:
    _, _, foot = pushed((0.09, 0.0))
    assert foot.x > 0.45


def test_limits_of_the_walking_parameters() -> None:
    limits = GaitLimits()
    assert limited(AHEAD, limits) == AHEAD
    assert limited(STAND, limits) == STAND
    wild = Gait(1e6, 0.3, 1e6, 1e6, 0.2)
    cut = limited(wild, limits)
    assert (cut.walk_speed, cut.step_length, cut.step_height) == (
        limits.fastest,
        limits.longest,
        limits.highest,
    )
    assert (cut.walk_dir, cut.heading) == (0.3, 0.2)
    for slow in (-1.0, 0.05, math.nan):
        assert limited(replace(AHEAD, walk_speed=slow), limits).walk_speed == 0.0
    low = limited(replace(AHEAD, step_length=-1.0, step_height=0.0), limits)
    assert (low.step_length, low.step_height) == (0.0, limits.lowest)
