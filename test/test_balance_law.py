"""The DCM law in closed loop with the pendulum, with and without hand forces; attitude; angular momentum."""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import frame_at

from follower_humanoid.balance.attitude import AttitudeConfig, attitude_feedback
from follower_humanoid.balance.dcm_law import (
    DcmConfig,
    SoleConfig,
    corrected,
    desired_force,
    desired_zmp,
    measured_dcm,
    shared,
    wrench_in_sole,
)
from follower_humanoid.balance.hand_forces import HandEffect, hand_effect
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.gait.pendulum import momentum_shift, natural_frequency
from follower_humanoid.gait.swing_momentum import MomentumConfig, MomentumRate
from follower_humanoid.robot.model import GRAVITY

MASS, HEIGHT, DT = 73.0, 0.85, 0.001
OMEGA = natural_frequency(HEIGHT)
GAIN = 3.0
NONE = (0.0, 0.0, 0.0)
HANDS = {
    "free": [],
    "pulled": [(Wrench(np.array([15.0, 8.0, 0.0]), np.zeros(3)), np.array([0.4, 0.2, 1.0]))],
    "loaded": [
        (Wrench(np.array([0.0, 0.0, -100.0]), np.zeros(3)), np.array([0.4, y, 1.0])) for y in (0.2, -0.2)
    ],
    "lifted and twisted": [
        (Wrench(np.array([-10.0, 5.0, 60.0]), np.array([2.0, -4.0, 1.0])), np.array([0.4, -0.2, 1.1]))
    ],
}
every_hand = pytest.mark.parametrize("hands", HANDS)


class CenterState(NamedTuple):
    """CoM of the robot in world."""

    com: Array
    velocity: Array


def state(com: Array, velocity: Array) -> CenterState:
    return CenterState(np.append(com, HEIGHT), np.append(velocity, 0.0))


def dcm_of(now: CenterState, effect: HandEffect) -> Array:
    return measured_dcm(*now, effect.kappa, effect.gamma, OMEGA)


def force_of(
    now: CenterState, wanted: CenterState, zmp: Array, turning: Array, effect: HandEffect, config: DcmConfig
) -> Array:
    return desired_force(MASS, *now, *wanted, MASS * OMEGA**2, zmp, *effect, turning, astuple(config))


def plan(time: float) -> tuple[Array, Array]:
    """A ZMP that sways and the DCM that belongs to it: ξ̇ = ω(ξ − p)."""
    w = 2.0
    zmp = np.array([0.05 * math.sin(w * time), 0.08 * math.cos(w * time)])
    rate = w * np.array([0.05 * math.cos(w * time), -0.08 * math.sin(w * time)])
    # For p = a sin(wt): the bounded solution is (p + ṗ/ω)/(1 + w²/ω²).
    return zmp, (zmp + rate / OMEGA) / (1.0 + (w / OMEGA) ** 2)


def closed_loop(effect: HandEffect, com: Array, velocity: Array, seconds: float) -> list[Array]:
    """DCM error over time with the force of the law acting on a point mass under gravity and hands."""
    errors = []
    for tick in range(round(seconds / DT)):
        zmp_plan, dcm_plan = plan(tick * DT)
        now = state(com, velocity)
        dcm = dcm_of(now, effect)
        errors.append(dcm - dcm_plan)
        zmp = desired_zmp(dcm, dcm_plan, zmp_plan, OMEGA, GAIN)
        force = force_of(now, now, zmp, np.zeros(2), effect, DcmConfig(height_damping=0.0))
        acceleration = (force + effect.force)[:2] / MASS
        # Exact for the linear pendulum would be cosh; at 1 ms this is as good.
        com, velocity = com + DT * velocity + 0.5 * DT**2 * acceleration, velocity + DT * acceleration
    return errors


def attitude_answer(
    error: tuple[float, float, float], spin: tuple[float, float, float], momentum_rate: float = 0.0
) -> tuple[Array, float]:
    """Shift and yaw moment with the gains' defaults; half of the rate is in what is wanted."""
    config, halved = AttitudeConfig(), 0.5 * np.array(spin)
    return attitude_feedback(
        error, halved, -halved, np.array([0.0, 0.0, momentum_rate]), MASS * GRAVITY, astuple(config)
    )


@every_hand
def test_a_dcm_error_decays_at_the_chosen_rate(hands: str) -> None:
    effect = hand_effect(HANDS[hands], MASS)
    _, dcm = plan(0.0)
    resting = effect.kappa * (dcm + np.array([0.03, -0.02])) - effect.gamma
    errors = closed_loop(effect, resting, np.zeros(2), 1.0)
    np.testing.assert_allclose(errors[0], [0.03, -0.02], atol=1e-12)
    for tick in (200, 500, 999):
        expected = np.array([0.03, -0.02]) * math.exp(-GAIN * tick * DT)
        np.testing.assert_allclose(errors[tick], expected, atol=3e-4)


@every_hand
def test_on_the_plan_the_zmp_is_the_planned_one_and_the_com_rests_against_the_hands(hands: str) -> None:
    effect = hand_effect(HANDS[hands], MASS)
    point = np.array([0.1, -0.03])
    com = effect.resting_com(point)
    dcm = dcm_of(state(com, np.zeros(2)), effect)
    np.testing.assert_allclose(dcm, point, atol=1e-12)
    zmp = desired_zmp(dcm, point, point, OMEGA, GAIN)
    np.testing.assert_allclose(zmp, point, atol=1e-12)
    now = state(com, np.zeros(2))
    force = force_of(now, now, zmp, np.zeros(2), effect, DcmConfig())
    np.testing.assert_allclose(force + effect.force, [0.0, 0.0, MASS * GRAVITY], atol=1e-9)


def test_the_force_through_the_zmp_leaves_no_moment_about_the_com() -> None:
    # Without hands the ground force points from the ZMP to the CoM, but for the swing leg's momentum.
    free = hand_effect([], MASS)
    now, zmp = state(np.array([0.06, 0.01]), np.array([0.1, 0.0])), np.array([0.02, 0.05])
    force = force_of(now, now, zmp, np.zeros(2), free, DcmConfig())
    np.testing.assert_allclose(np.cross(np.append(zmp, 0.0) - now.com, force), np.zeros(3), atol=1e-9)
    rate = np.array([8.0, -12.0, 0.0])
    force = force_of(now, now, zmp, momentum_shift(rate, MASS), free, DcmConfig())
    moment = np.cross(np.append(zmp, 0.0) - now.com, force)
    np.testing.assert_allclose(moment[:2], rate[:2], atol=1e-9)


def test_height_is_brought_back_and_force_never_pulls() -> None:
    free, config = hand_effect([], MASS), DcmConfig()
    low = CenterState(np.array([0.0, 0.0, HEIGHT - 0.01]), np.array([0.0, 0.0, -0.1]))
    wanted = state(np.zeros(2), np.zeros(2))
    force = force_of(low, wanted, np.zeros(2), np.zeros(2), free, config)
    expected = GRAVITY + config.height_stiffness * 0.01 + config.height_damping * 0.1
    assert force[2] == pytest.approx(MASS * expected)
    thrown = CenterState(np.array([0.0, 0.0, HEIGHT + 0.5]), np.zeros(3))
    assert force_of(thrown, wanted, np.zeros(2), np.zeros(2), free, config)[2] == 0.0


def test_the_error_is_measured_minus_plan_as_the_law_needs_it() -> None:
    # A DCM ahead of its plan needs a ZMP still further ahead: that brakes.
    zmp = desired_zmp(np.array([0.02, 0.0]), np.zeros(2), np.zeros(2), OMEGA, GAIN)
    assert zmp[0] == pytest.approx(0.02 * (1.0 + GAIN / OMEGA))


@pytest.mark.parametrize("feedback", [True, False])
def test_the_law_is_its_steps_one_after_the_other(feedback: bool) -> None:
    rng = np.random.default_rng(6)
    dcm_config, soles = DcmConfig(proportional=GAIN), SoleConfig()
    usable = astuple(soles)
    for _ in range(30):
        now, wanted = (state(rng.normal(0.0, 0.02, 2), rng.normal(0.0, 0.1, 2)) for _ in range(2))
        dcm_plan, zmp_plan, shift, turning = rng.normal(0.0, 0.03, (4, 2))
        effect = hand_effect(HANDS["lifted and twisted"], MASS)
        places = [
            frame_at(np.array([rng.normal(0.0, 0.1), y, 0.0]), pin.rpy.rpyToMatrix(rng.normal(0, 0.1, 3)))
            for y in (0.09, -0.09)
        ]
        most, moment = tuple(rng.uniform(0.0, 1.0, 2)), float(rng.normal(0.0, 10.0))
        dcm, points = dcm_of(now, effect), np.empty((3, 2))
        zmp = desired_zmp(dcm, dcm_plan, zmp_plan, OMEGA, GAIN) if feedback else zmp_plan
        shared(zmp, *places, most, usable, points)
        pushed = now if feedback else wanted
        force = force_of(pushed, wanted, points[2].copy(), turning, effect, dcm_config)
        left = shared(zmp + shift, *places, most, usable, points)
        wrenches = np.empty((2, 2, 3))
        for n, share in enumerate((left, 1.0 - left)):
            wrench_in_sole(share, points[n], force, moment, places[n], soles.friction, wrenches[n])
        result = corrected(
            feedback, MASS, *now, OMEGA, *wanted, MASS * OMEGA**2, dcm_plan, zmp_plan, *effect,
            turning, shift, moment, *places, most, astuple(dcm_config), usable,
        )  # fmt: skip
        np.testing.assert_array_equal(result[:2], np.column_stack(((dcm, points[2]), (0.0, 0.0))))
        np.testing.assert_array_equal(result[2:], wrenches.reshape(4, 3))


def test_attitude_shift_turns_the_pelvis_back() -> None:
    config = AttitudeConfig()
    # Tilted forward by 0.01 (rotation +y): the error towards upright is −0.01 about y.
    shift, _ = attitude_answer((0.0, -0.01, 0.0), NONE)
    moment = config.inertia * config.stiffness * 0.01
    # A force m g that acts further forward turns backward, about −y.
    assert shift[0] == pytest.approx(moment / (MASS * GRAVITY))
    turned = np.cross([shift[0], shift[1], 0.0], [0.0, 0.0, MASS * GRAVITY])
    np.testing.assert_allclose(turned, [0.0, -moment, 0.0], atol=1e-9)
    sideways, _ = attitude_answer((0.01, 0.0, 0.0), NONE)
    np.testing.assert_allclose(
        np.cross(np.append(sideways, 0.0), [0.0, 0.0, MASS * GRAVITY]), [moment, 0.0, 0.0], atol=1e-9
    )
    falling, _ = attitude_answer(NONE, (0.0, 0.1, 0.0))
    assert falling[0] > 0.0
    wild, _ = attitude_answer((1.0, -1.0, 0.0), NONE)
    np.testing.assert_allclose(np.abs(wild), config.zmp_limit)


def test_yaw_moment_feeds_forward_the_swing_and_brings_the_heading_back_within_friction() -> None:
    config = AttitudeConfig()
    assert attitude_answer(NONE, NONE, 7.0)[1] == 7.0
    _, back = attitude_answer((0.0, 0.0, 0.01), (0.0, 0.0, 0.02))
    assert back == pytest.approx(config.inertia * (config.stiffness * 0.01 - config.damping * 0.02))
    for much in (1e3, -1e3):
        assert attitude_answer(NONE, NONE, much)[1] == math.copysign(config.yaw_limit, much)


def test_momentum_rate_is_the_derivative_behind_its_low_pass() -> None:
    config = MomentumConfig(filter_time=0.01)
    rate, slope = MomentumRate(config), np.array([10.0, -5.0, 2.0])
    out = [rate.step(slope * tick * DT, DT) for tick in range(200)]
    np.testing.assert_array_equal(out[0], np.zeros(3))
    # A derivative that sets in at once comes through as 1 − e^{−t/T}.
    for tick in (10, 30):
        np.testing.assert_allclose(out[tick], slope * (1.0 - math.exp(-tick * DT / 0.01)), rtol=1e-9)
    np.testing.assert_allclose(out[-1], slope, rtol=1e-6)


def test_momentum_rate_is_limited_and_can_be_left_out() -> None:
    for limit in (20.0, 0.0):
        rate = MomentumRate(MomentumConfig(limit=limit, filter_time=1e-4))
        rate.step(np.zeros(3), DT)
        np.testing.assert_allclose(
            np.abs(rate.step(np.array([5.0, -5.0, 5.0]), DT)), limit, atol=limit * 1e-3
        )
