"""Sharing the ground force between the feet: nothing lost, within the soles, friction and plan."""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from gait_bench import frame_at

from follower_humanoid.balance.dcm_law import SoleConfig, shared, wrench_in_sole
from follower_humanoid.balance.zmp import measured_zmp, moved_to_origin
from follower_humanoid.core.samples import SIDES, Array, ContactPlan, Side, Wrench

CONFIG = SoleConfig()
BOTH = ContactPlan(1.0, 1.0)
WEIGHT = 716.0


def soles(yaw: float = 0.0, stride: float = 0.0, tilt: float = 0.0) -> dict[Side, Array]:
    rotation = pin.rpy.rpyToMatrix(tilt, -tilt, yaw)
    c, s = math.cos(yaw), math.sin(yaw)

    def place(x: float, y: float) -> Array:
        return frame_at(np.array([c * x - s * y, s * x + c * y, -0.001]), rotation)

    return {Side.LEFT: place(stride, 0.09), Side.RIGHT: place(0.0, -0.09)}


class Shares(NamedTuple):
    """Parts of a force, where they act and what they make together."""

    share: dict[Side, float]
    point: dict[Side, Array]
    zmp: Array


def share_feet(zmp: Array, places: dict[Side, Array], plan: ContactPlan, config: SoleConfig) -> Shares:
    points = np.empty((3, 2))
    left = shared(zmp, places[Side.LEFT], places[Side.RIGHT], astuple(plan), astuple(config), points)
    share = {Side.LEFT: left, Side.RIGHT: 1.0 - left}
    return Shares(share, dict(zip(SIDES, points, strict=False)), points[2])


def foot_wrench(share: float, point: Array, force: Array, yaw: float, place: Array) -> Wrench:
    wrench = np.empty((2, 3))
    wrench_in_sole(share, point, force, yaw, place, CONFIG.friction, wrench)
    return Wrench(wrench[0], wrench[1])


def in_sole(point: Array, place: Array) -> Array:
    yaw = math.atan2(place[0, 1], place[0, 0])
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, s], [-s, c]]) @ (point - place[3, :2])


@pytest.mark.parametrize("yaw", [0.0, 0.6, -2.5])
@pytest.mark.parametrize("stride", [0.0, 0.4])
def test_any_zmp_is_shared_without_loss_and_inside_the_soles(yaw: float, stride: float) -> None:
    rng = np.random.default_rng(1)
    places = soles(yaw, stride)
    for _ in range(50):
        wanted = rng.normal(0.2, 0.4, 2)
        shares = share_feet(wanted, places, BOTH, CONFIG)
        assert shares.share[Side.LEFT] + shares.share[Side.RIGHT] == pytest.approx(1.0)
        assert all(0.0 <= shares.share[side] <= 1.0 for side in SIDES)
        for side in SIDES:
            forward, left = in_sole(shares.point[side], places[side])
            assert CONFIG.back - 1e-9 <= forward <= CONFIG.front + 1e-9
            assert abs(left) <= CONFIG.side + 1e-9
        made = sum(shares.share[side] * shares.point[side] for side in SIDES)
        np.testing.assert_allclose(shares.zmp, made, atol=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.6, -2.5])
@pytest.mark.parametrize("stride", [0.0, 0.4])
def test_a_zmp_within_reach_is_reached(yaw: float, stride: float) -> None:
    rng = np.random.default_rng(2)
    places = soles(yaw, stride)
    c, s = math.cos(yaw), math.sin(yaw)
    for _ in range(50):
        part = rng.uniform(0.0, 1.0)
        forward = rng.uniform(CONFIG.back, CONFIG.front) - CONFIG.center
        # Somewhere on the line between the middles of the soles, then along the feet.
        middle = CONFIG.center * np.array([c, s])
        wanted = part * places[Side.LEFT][3, :2] + (1 - part) * places[Side.RIGHT][3, :2]
        wanted = wanted + middle + 0.5 * forward * np.array([c, s])
        np.testing.assert_allclose(share_feet(wanted, places, BOTH, CONFIG).zmp, wanted, atol=1e-9)


def test_between_the_middles_of_the_feet_the_loads_are_by_distance() -> None:
    places = soles()
    for part in (0.0, 0.3, 0.5, 1.0):
        wanted = np.array([CONFIG.center, -0.09 + 0.18 * part])
        shares = share_feet(wanted, places, BOTH, CONFIG)
        assert shares.share[Side.LEFT] == pytest.approx(part)


@pytest.mark.parametrize("side", SIDES)
def test_a_foot_in_the_air_carries_nothing(side: Side) -> None:
    plan = ContactPlan(0.0, 1.0) if side is Side.LEFT else ContactPlan(1.0, 0.0)
    places = soles(stride=0.3)
    stance = side.other
    for wanted in (np.array([0.3, 0.1]), np.array([0.0, -0.1]), np.array([0.15, 0.0])):
        shares = share_feet(wanted, places, plan, CONFIG)
        assert shares.share[side] == 0.0
        assert shares.share[stance] == 1.0
        np.testing.assert_array_equal(shares.zmp, shares.point[stance])
    inside = places[stance][3, :2] + np.array([0.06, 0.01])
    np.testing.assert_allclose(share_feet(inside, places, plan, CONFIG).zmp, inside)


@pytest.mark.parametrize("allowed", [0.2, 0.5, 0.9])
def test_loads_change_hands_only_as_the_plan_lets_them(allowed: float) -> None:
    places = soles()
    far_left = share_feet(np.array([0.03, 0.09]), places, ContactPlan(allowed, 1.0), CONFIG)
    assert far_left.share[Side.LEFT] == pytest.approx(allowed)
    far_right = share_feet(np.array([0.03, -0.09]), places, ContactPlan(1.0, allowed), CONFIG)
    assert far_right.share[Side.RIGHT] == pytest.approx(allowed)


def test_left_and_right_are_mirror_images() -> None:
    rng = np.random.default_rng(3)
    flip = np.array([1.0, -1.0])
    for _ in range(20):
        wanted = rng.normal(0.0, 0.15, 2)
        plan = ContactPlan(rng.uniform(0.5, 1), rng.uniform(0.5, 1))
        one = share_feet(wanted, soles(), plan, CONFIG)
        two = share_feet(wanted * flip, soles(), ContactPlan(plan.right, plan.left), CONFIG)
        np.testing.assert_allclose(two.zmp, one.zmp * flip, atol=1e-12)
        assert two.share[Side.RIGHT] == pytest.approx(one.share[Side.LEFT])


def test_feet_at_the_same_place_share_evenly() -> None:
    place = frame_at(np.zeros(3), np.eye(3))
    shares = share_feet(np.array([0.02, 0.0]), dict.fromkeys(SIDES, place), BOTH, CONFIG)
    assert shares.share == dict.fromkeys(SIDES, 0.5)


@pytest.mark.parametrize("tilt", [0.0, 0.03])
def test_the_wrenches_make_the_force_the_zmp_and_the_yaw_moment(tilt: float) -> None:
    rng = np.random.default_rng(4)
    places = soles(0.4, 0.3, tilt)
    for _ in range(20):
        force, yaw = np.append(rng.normal(0, 40, 2), WEIGHT + rng.normal(0, 50)), float(rng.normal(0, 10))
        shares = share_feet(rng.normal(0.1, 0.1, 2), places, BOTH, CONFIG)
        wrenches = {
            side: foot_wrench(shares.share[side], shares.point[side], force, yaw, places[side])
            for side in SIDES
        }
        zmp = measured_zmp(*(wrenches[s] for s in SIDES), *(places[s] for s in SIDES), 50.0)
        np.testing.assert_allclose(zmp, shares.zmp, atol=1e-9)
        total, moment = np.sum(
            [moved_to_origin(wrenches[s].force, wrenches[s].torque, places[s]) for s in SIDES], axis=0
        )
        np.testing.assert_allclose(total, force, atol=1e-9)
        about_zmp = moment - np.cross(np.append(shares.zmp, 0.0), total)
        np.testing.assert_allclose(about_zmp, [0.0, 0.0, yaw], atol=1e-9)


@pytest.mark.parametrize("side", SIDES)
def test_each_foots_own_zmp_is_its_point(side: Side) -> None:
    places = soles(-0.3, 0.2)
    point = places[side][3, :2] + np.array([0.05, 0.01])
    wrench = foot_wrench(0.7, point, np.array([30.0, -10.0, WEIGHT]), 0.0, places[side])
    nothing = Wrench(np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(measured_zmp(wrench, nothing, places[side], places[side], 50.0), point)


def test_friction_is_respected_and_the_direction_kept() -> None:
    place = soles()[Side.LEFT]
    wrench = foot_wrench(1.0, np.array([0.05, 0.09]), np.array([600.0, -800.0, WEIGHT]), 0.0, place)
    tangential = wrench.force[:2]
    assert np.linalg.norm(tangential) == pytest.approx(0.6 * WEIGHT)
    np.testing.assert_allclose(tangential / np.linalg.norm(tangential), [0.6, -0.8])
    assert wrench.force[2] == pytest.approx(WEIGHT)
    within = foot_wrench(1.0, np.array([0.05, 0.09]), np.array([60.0, -80.0, WEIGHT]), 0.0, place)
    np.testing.assert_allclose(within.force, [60.0, -80.0, WEIGHT])


def test_no_weight_no_wrench() -> None:
    place = soles()[Side.RIGHT]
    for share, force in ((0.0, np.array([50.0, 0.0, WEIGHT])), (1.0, np.array([50.0, 10.0, 0.0]))):
        wrench = foot_wrench(share, np.array([0.1, 0.0]), force, 0.0, place)
        np.testing.assert_array_equal(wrench.force, np.zeros(3))
        np.testing.assert_allclose(wrench.torque, np.zeros(3), atol=1e-12)
