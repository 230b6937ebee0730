"""Capture steps: a push moves and hurries the landing; without one nothing is touched. Limits of the gait."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, IdealRobot, WalkerBench, inputs_of, vertical

from follower_humanoid.core.samples import SIDES, Array, Gait, Point, Side
from follower_humanoid.gait.capture import (
    Capture,
    CaptureConfig,
    SwingOutlook,
    capture,
    footprint_weight,
    shifted,
)
from follower_humanoid.gait.composition import MotionComposition
from follower_humanoid.gait.feet import EDGES, HEEL_TOE, FootPose, FootstepConfig
from follower_humanoid.gait.limits import GaitLimits, limited
from follower_humanoid.gait.preview import ZmpLeg, planned_dcm

CONFIG = CaptureConfig()
OMEGA = 3.4
LANDING = FootPose(Side.LEFT, 0.4, 0.09, 0.0)


@cache
def swing(progress: float) -> SwingOutlook:
    """A swing of the left or right foot of a straight walk, so far gone; 0: the foot still stands."""
    bench = WalkerBench()
    while bench.walker.half_step is None or bench.walker.half_step.swing_progress < progress:
        bench.tick(AHEAD)
    outlook = bench.walker.outlook(bench.walker.plan_ahead(AHEAD))
    assert outlook is not None
    return outlook


def planned(outlook: SwingOutlook, time: float | None = None) -> Array:
    """The DCM that the plan needs now when the rest of the swing takes so long."""
    stretch = 1.0 if time is None else time / outlook.time
    pieces = [(target, stretch * duration) for target, duration in outlook.swing]
    return planned_dcm(outlook.zmp, [*outlook.lead, *pieces, *outlook.rest], OMEGA, math.inf)


def left_over(error: Array, outlook: SwingOutlook, wanted: Capture) -> Array:
    """(along, outward) of what time and place of the landing leave to the ZMP."""
    until = outlook.until_lift_off + wanted.time
    missing = planned(outlook) + error - planned(outlook, wanted.time)
    missing[1] *= outlook.landing.side.sign
    return np.asarray(missing - footprint_weight(until, outlook.transfer, OMEGA) * wanted.shift)


@pytest.mark.parametrize("progress", [0.1, 0.5, 0.75])
def test_the_weight_is_what_a_shifted_footprint_does_to_the_planned_dcm(progress: float) -> None:
    bench = WalkerBench()
    while bench.walker.half_step is None or bench.walker.half_step.swing_progress < progress:
        bench.tick(AHEAD)
    walker = bench.walker
    plan = walker.plan_ahead(AHEAD)
    outlook = walker.outlook(plan)
    assert outlook is not None and walker.landing is not None
    weight = footprint_weight(outlook.until_lift_off + outlook.time, outlook.transfer, OMEGA)
    before = planned_dcm(walker.zmp.position, plan.zmp, OMEGA, math.inf)
    walker.landing = shifted(walker.landing, np.array([0.1, 0.05]))
    after = planned_dcm(walker.zmp.position, walker.plan_ahead(AHEAD).zmp, OMEGA, math.inf)
    outward = walker.landing.side.sign
    np.testing.assert_allclose(after - before, weight * np.array([0.1, outward * 0.05]), rtol=1e-6)


def test_the_weight_of_a_sudden_change_is_its_discount() -> None:
    assert footprint_weight(0.5, 0.0, OMEGA) == pytest.approx(math.exp(-OMEGA * 0.5))
    assert footprint_weight(0.5, 1e-5, OMEGA) == pytest.approx(math.exp(-OMEGA * 0.5), rel=1e-4)
    assert footprint_weight(0.0, 0.5, OMEGA) < 1.0


@pytest.mark.parametrize("progress", [0.0, 0.1, 0.5, 0.75])
def test_an_error_within_the_reach_of_the_zmp_leaves_the_step_alone(progress: float) -> None:
    outlook = swing(progress)
    held = 1.0 - math.exp(-OMEGA * (outlook.until_lift_off + outlook.time))
    for along, across in ((0.9, 0.0), (0.0, 0.9), (-0.9, -0.9)):
        error = held * np.array([along * CONFIG.zmp_along, across * CONFIG.zmp_across])
        wanted = capture(planned(outlook) + error, outlook, OMEGA, CONFIG)
        assert (wanted.cost, wanted.offset) == (0.0, 0.0)
        assert wanted.time == pytest.approx(outlook.time)
        np.testing.assert_array_equal(wanted.shift, np.zeros(2))


@pytest.mark.parametrize("progress", [0.1, 0.3, 0.6])
def test_what_is_said_to_be_caught_is_within_the_reach_of_the_zmp(progress: float) -> None:
    outlook = swing(progress)
    rng = np.random.default_rng(3)
    caught = 0
    for _ in range(60):
        error = rng.uniform(-0.1, 0.1, 2)
        wanted = capture(planned(outlook) + error, outlook, OMEGA, CONFIG)
        held = 1.0 - math.exp(-OMEGA * (outlook.until_lift_off + wanted.time))
        reach = CONFIG.tolerance + held * np.array([CONFIG.zmp_along, CONFIG.zmp_across])
        beyond = np.maximum(np.abs(left_over(error, outlook, wanted)) - reach, 0.0)
        growth = math.exp(OMEGA * (outlook.until_lift_off + wanted.time))
        assert growth * math.hypot(*beyond) == pytest.approx(wanted.offset, abs=1e-9)
        caught += wanted.offset < 1e-9
    assert caught > 5


def test_a_push_towards_the_swing_foot_is_met_sooner_and_further_out() -> None:
    outlook = swing(0.1)
    push = np.array([0.0, outlook.landing.side.sign * 0.09])
    both = capture(planned(outlook) + push, outlook, OMEGA, CONFIG)
    place_only = capture(planned(outlook) + push, outlook, OMEGA, replace(CONFIG, timing=False))
    assert both.time < 0.6 * outlook.time
    assert both.shift[1] > 0.02
    assert place_only.time == pytest.approx(outlook.time)
    assert both.offset < 0.1 * place_only.offset
    assert both.cost < place_only.cost


def test_a_walk_that_is_stopped_may_land_behind_its_stance_foot() -> None:
    outlook = replace(swing(0.1), foot=swing(0.1).landing.xy)
    wanted = capture(planned(outlook) - np.array([0.5, 0.0]), outlook, OMEGA, CONFIG)
    assert wanted.shift[0] < -FootstepConfig().half_step_length


def test_shifts_have_limits_and_inwards_the_narrowest() -> None:
    outlook = replace(swing(0.1), foot=swing(0.1).landing.xy)  # so that the way to go is no limit
    sign = outlook.landing.side.sign
    for along, outward in ((5.0, 5.0), (-5.0, -5.0)):
        wanted = capture(planned(outlook) + np.array([along, sign * outward]), outlook, OMEGA, CONFIG)
        assert abs(wanted.shift[0]) <= CONFIG.forward + 1e-12
        assert -CONFIG.inward - 1e-12 <= wanted.shift[1] <= CONFIG.outward + 1e-12
        assert wanted.offset > 1.0


def test_a_foot_is_not_sent_further_than_it_gets_in_time() -> None:
    outlook = swing(0.05)
    rng = np.random.default_rng(4)
    for _ in range(40):
        wanted = capture(planned(outlook) + rng.uniform(-0.3, 0.3, 2), outlook, OMEGA, CONFIG)
        way = math.dist(shifted(outlook.landing, wanted.shift).xy, outlook.foot)
        assert way <= CONFIG.swing_speed * wanted.time + 1e-9
        assert wanted.time >= min(CONFIG.quickest * outlook.left, outlook.time) - 1e-9
        assert wanted.time <= CONFIG.slowest * outlook.time + 1e-9


def test_left_and_right_are_mirror_images() -> None:
    def reflected(outlook: SwingOutlook) -> SwingOutlook:
        def pieces(legs: list[ZmpLeg]) -> list[ZmpLeg]:
            return [(None if target is None else target * flip, time) for target, time in legs]

        flip = np.array([1.0, -1.0])
        foot = outlook.landing
        return replace(
            outlook, zmp=outlook.zmp * flip, lead=pieces(outlook.lead), swing=pieces(outlook.swing),
            rest=pieces(outlook.rest), foot=outlook.foot * flip, moved=outlook.moved * flip,
            landing=FootPose(foot.side.other, foot.x, -foot.y, -foot.yaw),
        )  # fmt: skip

    outlook = swing(0.3)
    for error in ([0.09, -0.05], [-0.06, 0.08]):
        one = capture(planned(outlook) + error, outlook, OMEGA, CONFIG)
        other = reflected(outlook)
        two = capture(planned(other) + np.array(error) * [1.0, -1.0], other, OMEGA, CONFIG)
        np.testing.assert_allclose(one.shift, two.shift, atol=1e-12)
        assert one.time == pytest.approx(two.time)


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


def beyond_the_sole(ideal: IdealRobot, asked: Array) -> Array:
    """How far the DCM is behind the reference, which has taken over the push: its ZMP ends at the sole."""
    motion = ideal.composition._motion
    half = motion.walker.half_step if motion is not None else None
    if half is None or not half.single_support:
        return np.zeros(2)
    stance = half.stance  # heads along x
    low, high = np.array([HEEL_TOE[0], EDGES[0]]), np.array([HEEL_TOE[1], EDGES[1]])
    possible = stance.xy + np.clip(asked - stance.xy, low, high)
    return np.asarray((math.exp(OMEGA * ideal.dt) - 1.0) * (asked - possible))


def pushed(error: Sequence[float] | Array) -> tuple[IdealRobot, float, FootPose]:
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
        error = beyond_the_sole(ideal, out.zmp_reference.xyz[:2])
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
    ideal, hurried, foot = pushed((0.0, -CONFIG.zmp_across - 0.025))  # more than the ZMP can meet
    assert foot.side is Side.RIGHT
    assert hurried < 0.6 * usual
    assert foot.y < -0.13
    assert foot.y > -0.09 - CONFIG.outward - 0.01
    assert np.isfinite(joint_jump(ideal)).all()


def test_a_push_forward_makes_the_step_longer() -> None:
    _, _, foot = pushed((0.15, 0.0))  # with the ZMP at the toes it would still run away
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
