"""The pelvis goes as high as both legs reach, falls in time and rises slowly."""

from __future__ import annotations

import math

import pytest

from follower_humanoid.gait.pelvis_height import PelvisConfig, PelvisHeight, Reach

CONFIG = PelvisConfig()
STANDING = 0.84
ANKLE = 0.08
DT = 0.002


def test_feet_below_the_hips_leave_the_standing_height() -> None:
    pelvis = PelvisHeight(CONFIG, STANDING)
    assert pelvis.admissible([Reach(ANKLE, 0.0), Reach(ANKLE, 0.02)]) == STANDING
    assert pelvis.admissible([]) == STANDING


@pytest.mark.parametrize("horizontal", [0.3, 0.35, 0.4])
def test_no_leg_is_asked_for_more_than_its_reach(horizontal: float) -> None:
    pelvis = PelvisHeight(CONFIG, STANDING)
    height = pelvis.admissible([Reach(ANKLE, 0.0), Reach(ANKLE, horizontal)])
    assert height < STANDING
    assert math.hypot(height - ANKLE, horizontal) == pytest.approx(CONFIG.leg_reach)


def test_a_lifted_foot_asks_for_less() -> None:
    pelvis = PelvisHeight(CONFIG, STANDING)
    flat, lifted = (pelvis.admissible([Reach(ANKLE + lift, 0.4)]) for lift in (0.0, 0.05))
    assert lifted == pytest.approx(flat + 0.05)


def test_an_impossible_reach_ends_at_the_lowest_height() -> None:
    pelvis = PelvisHeight(CONFIG, STANDING)
    assert pelvis.admissible([Reach(ANKLE, 2.0)]) == CONFIG.lowest


def test_the_height_falls_like_a_critically_damped_filter_without_overshoot() -> None:
    pelvis = PelvisHeight(CONFIG, STANDING)
    goal, heights = 0.74, []
    for _ in range(1000):
        pelvis.advance(goal, DT)
        heights.append(pelvis.height)
        t, w = len(heights) * DT, CONFIG.bandwidth
        exact = goal + (STANDING - goal) * (1 + w * t) * math.exp(-w * t)
        assert pelvis.height == pytest.approx(exact, abs=1e-3)
    assert min(heights) > goal - 1e-6
    assert heights[-1] == pytest.approx(goal, abs=1e-4)


def test_it_rises_no_faster_than_told_and_arrives() -> None:
    pelvis = PelvisHeight(CONFIG, 0.80)
    last, speeds = pelvis.height, []
    for _ in range(round(5.0 / DT)):
        pelvis.advance(0.82, DT)
        speeds.append((pelvis.height - last) / DT)
        assert pelvis.velocity == pytest.approx(speeds[-1], abs=1e-9)
        last = pelvis.height
    assert max(speeds) <= CONFIG.rise_speed + 1e-9
    assert pelvis.height == pytest.approx(0.82, abs=1e-4)
