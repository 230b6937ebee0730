"""Where feet land: length, direction, mirror symmetry, limits, and never across the other foot."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from follower_humanoid.core.samples import SIDES, Gait, Side
from follower_humanoid.gait.feet import (
    FootPose,
    FootstepConfig,
    beside,
    half_step_length,
    landing_pose,
    mean_yaw,
    midpoint,
    wrap_angle,
)

CONFIG = FootstepConfig()
DIRECTIONS = np.radians([-180, -135, -90, -36.87, 0, 20, 90, 150, 179])


def gait(direction: float, heading: float | None = None, length: float = 1.0, speed: float = 1.0) -> Gait:
    return Gait(speed, direction, length, 1.0, direction if heading is None else heading)


def mirrored(foot: FootPose) -> FootPose:
    """Reflected in the plane y = 0."""
    return FootPose(foot.side.other, foot.x, -foot.y, -foot.yaw, foot.z)


def apart(stance: FootPose, landing: FootPose) -> float:
    """How far the landing sole lies to its own side of the stance sole, along its own left axis [m]."""
    away = np.array([landing.x - stance.x, landing.y - stance.y])
    return float(landing.side.sign * (-math.sin(landing.yaw) * away[0] + math.cos(landing.yaw) * away[1]))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("factor", [0.5, 1.0, 1.25])
def test_half_step_length_lies_exactly_along_the_landing_heading(
    side: Side, direction: float, factor: float
) -> None:
    stance = FootPose(side, 0.7, -0.2, direction)
    landing = landing_pose(stance, gait(direction, length=factor), CONFIG)
    assert landing.side is side.other
    assert half_step_length(landing, stance) == pytest.approx(0.40 * factor, abs=1e-12)
    assert apart(stance, landing) == pytest.approx(CONFIG.stance_width, abs=1e-12)
    assert landing.yaw == pytest.approx(direction)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("turn", [-0.6, -0.3, -0.1, 0.1, 0.3, 0.6])
def test_half_step_length_is_kept_while_turning(side: Side, turn: float) -> None:
    stance = FootPose(side, 0.0, 0.0, 0.4)
    landing = landing_pose(stance, gait(0.4 + turn), CONFIG)
    assert half_step_length(landing, stance) == pytest.approx(0.40, abs=1e-12)


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("turn", [-0.3, 0.0, 0.2])
def test_left_and_right_are_mirror_images(direction: float, turn: float) -> None:
    stance = FootPose(Side.LEFT, 0.3, 0.1, 0.2)
    heading = 0.2 + turn
    landing = landing_pose(stance, gait(direction, heading), CONFIG)
    other = landing_pose(mirrored(stance), gait(-direction, -heading), CONFIG)
    for field in ("x", "y", "yaw", "z"):
        assert getattr(other, field) == pytest.approx(getattr(mirrored(landing), field), abs=1e-12)
    assert other.side is landing.side.other


@pytest.mark.parametrize("offset", [-2.3, 0.0, 1.1, math.pi])
def test_a_step_does_not_depend_on_where_in_the_world_it_is_made(offset: float) -> None:
    stance = FootPose(Side.RIGHT, 0.0, 0.0, 0.0)
    landing = landing_pose(stance, gait(0.3, 0.1), CONFIG)
    c, s = math.cos(offset), math.sin(offset)
    moved = landing_pose(FootPose(Side.RIGHT, 4.0, -3.0, offset), gait(0.3 + offset, 0.1 + offset), CONFIG)
    assert moved.x == pytest.approx(4.0 + c * landing.x - s * landing.y)
    assert moved.y == pytest.approx(-3.0 + s * landing.x + c * landing.y)
    assert wrap_angle(moved.yaw - offset) == pytest.approx(landing.yaw)


@pytest.mark.parametrize(
    ("yaw", "heading", "sign"), [(3.0, -3.0, 1), (-3.0, 3.0, -1), (0.0, 3.0, 1), (6.2, 0.1, 1)]
)
def test_turns_the_shortest_way(yaw: float, heading: float, sign: int) -> None:
    for side in SIDES:
        landing = landing_pose(FootPose(side, 0.0, 0.0, yaw), gait(heading), CONFIG)
        assert sign * (landing.yaw - yaw) > 0.0
        assert abs(landing.yaw - yaw) <= CONFIG.turn_per_step + 1e-12


def test_turning_is_limited_outwards_and_more_so_inwards() -> None:
    right_stance = FootPose(Side.RIGHT, 0.0, 0.0, 0.0)
    assert landing_pose(right_stance, gait(1.5), CONFIG).yaw == pytest.approx(CONFIG.turn_per_step)
    assert landing_pose(right_stance, gait(-1.5), CONFIG).yaw == pytest.approx(-CONFIG.turn_inward)


@pytest.mark.parametrize("side", SIDES)
def test_a_turn_repeated_reaches_its_heading_and_stays(side: Side) -> None:
    foot = FootPose(side, 0.0, 0.0, 0.0)
    for _ in range(8):
        foot = landing_pose(foot, gait(2.0), CONFIG)
    assert foot.yaw == pytest.approx(2.0)


def test_standing_places_the_feet_together() -> None:
    for side in SIDES:
        stance = FootPose(side, 1.0, 2.0, 0.7)
        place = beside(stance, CONFIG)
        assert place == landing_pose(stance, replace(gait(0.7), walk_speed=0.0), CONFIG)
        assert half_step_length(place, stance) == pytest.approx(0.0, abs=1e-12)
        assert apart(stance, place) == pytest.approx(CONFIG.stance_width)
        assert place.yaw == stance.yaw


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("travel", np.radians(np.arange(-180, 181, 15)))
def test_feet_never_cross_whatever_the_direction_of_travel(side: Side, travel: float) -> None:
    for turn in (-0.4, 0.0, 0.4):
        stance = FootPose(side, 0.0, 0.0, 0.0)
        landing = landing_pose(stance, gait(turn + travel, turn, length=1.25), CONFIG)
        assert apart(stance, landing) >= CONFIG.stance_width - 1e-12


@pytest.mark.parametrize("side", SIDES)
def test_backward_is_a_negative_length(side: Side) -> None:
    stance = FootPose(side, 0.0, 0.0, 0.5)
    landing = landing_pose(stance, gait(0.5 + math.pi, 0.5, length=0.6), CONFIG)
    assert half_step_length(landing, stance) == pytest.approx(-0.24, abs=1e-12)
    assert apart(stance, landing) == pytest.approx(CONFIG.stance_width)


def test_sideways_the_outer_foot_steps_out_and_the_other_closes_up() -> None:
    to_the_left = gait(math.pi / 2, 0.0, length=0.4)
    out = landing_pose(FootPose(Side.RIGHT, 0.0, 0.0, 0.0), to_the_left, CONFIG)
    assert (out.x, out.y) == pytest.approx((0.0, CONFIG.stance_width + 0.16))
    close = landing_pose(out, to_the_left, CONFIG)
    assert (close.x, close.y) == pytest.approx((0.0, out.y - CONFIG.stance_width))


def test_a_walk_goes_as_far_as_its_half_steps_say() -> None:
    for direction in DIRECTIONS:
        foot = FootPose(Side.RIGHT, 0.0, -0.09, float(direction))
        start = foot.xy
        for _ in range(10):
            foot = landing_pose(foot, gait(float(direction)), CONFIG)
        along = (foot.xy - start) @ np.array([math.cos(direction), math.sin(direction)])
        assert along == pytest.approx(4.0)


def test_wrap_midpoint_and_mean_yaw() -> None:
    rng = np.random.default_rng(3)
    for angle in rng.uniform(-20, 20, 50):
        wrapped = wrap_angle(angle)
        assert -math.pi <= wrapped <= math.pi
        assert math.cos(wrapped) == pytest.approx(math.cos(angle))
        assert math.sin(wrapped) == pytest.approx(math.sin(angle))
    left, right = FootPose(Side.LEFT, 0.2, 0.1, 3.1), FootPose(Side.RIGHT, 0.0, -0.1, -3.1)
    assert wrap_angle(mean_yaw(left.yaw, right.yaw) - math.pi) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(midpoint(left, right, 0.0), [0.1, 0.0], atol=1e-12)
    ahead = midpoint(replace(left, yaw=0.0), replace(right, yaw=0.0), 0.03)
    np.testing.assert_allclose(ahead, [0.13, 0.0], atol=1e-12)
    np.testing.assert_allclose(FootPose(Side.LEFT, 1.0, 2.0, math.pi / 2).point(0.1, 0.02), [0.98, 2.1])
