"""Equations (17), (18) corrected and the force of equation (3): what hands do that keep a place."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.control.arm_config import ArmControllerConfig
from follower_humanoid.control.hand_law import HandLaw, range_force, return_velocity
from follower_humanoid.control.hand_reference import GlideLimits, HandReference
from follower_humanoid.control.hand_task import unwritten_motion
from follower_humanoid.control.impedance import Impedance

TICK = 0.002


def back(error, rate, stretch, stopped: bool = False) -> np.ndarray:
    rows = (np.array([values], dtype=float) for values in (error, rate, stretch))
    stiffness, limit = np.array([100.0, 100.0, 3000.0]), np.array([60.0, 60.0, 200.0])
    return return_velocity(*rows, 0.8, 0.1, stiffness, limit, np.array([stopped]))[0]


REST = (0.0, 0.0, 0.0)


def test_return_velocity_leads_back() -> None:
    shift = np.array([0.05, 0.0, -0.01])  # the hand is ahead of and below its place
    np.testing.assert_allclose(back(-shift, REST, REST), [-0.04, 0, 0.008])
    np.testing.assert_allclose(back(REST, (-1.0, 0.0, 0.0), REST), [-0.1, 0, 0], err_msg="moving away")
    np.testing.assert_array_equal(back(-shift, REST, REST, stopped=True), 0.0)


def test_return_stops_at_its_force_limit_and_lets_go_of_it() -> None:
    # Springs at 61, 61 and 150 N; the second axis returns to where its spring is shorter.
    found = back((-0.1, 0.1, 0.1), REST, (-0.61, -0.61, 0.05))
    np.testing.assert_allclose(found, [0.0, 0.08, 0.08])


def test_range_force_is_a_wall_around_the_place() -> None:
    def wall(error: list[float], rate: list[float]) -> np.ndarray:
        return range_force(np.array([error]), np.array([rate]), 0.12, 2000.0, 3.0)[0]

    still = [0.0, 0.0, 0.0]
    np.testing.assert_array_equal(wall(still, still), 0)
    np.testing.assert_array_equal(wall([0.1, 0.0, 0.0], still), 0)
    np.testing.assert_allclose(wall([-0.13, 0.0, 0.0], still), [-20, 0, 0])
    leaving = wall([0.0, 0.13, 0.0], [0.0, 1.0, 0.0])
    returning = wall([0.0, 0.13, 0.0], [0.0, -1.0, 0.0])
    assert leaving[1] == pytest.approx(20 + 2 * np.sqrt(6000.0))
    assert returning[1] == pytest.approx(20), "no pull on the way back"


@pytest.mark.parametrize("seed", range(4))
def test_the_demand_is_equations_3_17_and_18_and_moves_the_springs(seed: int) -> None:
    rng, config = np.random.default_rng(seed), ArmControllerConfig(reach=0.2)
    wanted = Impedance.with_damping_ratio(np.array(config.inertia), np.array(config.stiffness), 1.0)
    reference = HandReference(rng.normal(size=(2, 3)), np.zeros((2, 7)), GlideLimits(0.1, 0.5, 0.5), TICK)
    reference.rate, reference.virtual = rng.normal(size=(2, 3)), reference.place + rng.normal(size=(2, 3))
    hands, felt, stopped = unwritten_motion(), rng.normal(size=(2, 3)), np.array([seed % 2 == 1, False])
    hands.place[:] = reference.place + 0.2 * rng.normal(size=(2, 3))
    hands.place_rate[:], hands.carried[:] = rng.normal(size=(2, 2, 3))
    law, spring = HandLaw(config, wanted, TICK), reference.virtual.copy()
    stretch, velocity, force = law.step(reference, hands, felt, stopped)
    error, error_rate = reference.place - hands.place, reference.rate - hands.place_rate
    back = reference.rate + return_velocity(
        error, error_rate, spring - hands.place, config.return_proportional, config.return_differential,
        wanted.stiffness, np.array(config.return_force), stopped,
    )  # fmt: skip
    np.testing.assert_allclose(stretch, spring - hands.place, atol=1e-14)
    np.testing.assert_allclose(velocity, back - hands.carried, atol=1e-14)
    np.testing.assert_allclose(reference.virtual, spring + TICK * (back - reference.rate), atol=1e-14)
    wall = range_force(error, error_rate, config.reach, config.reach_stiffness, config.inertia[0])
    expected = felt + wanted.force(stretch, back - hands.place_rate) + wall
    np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-11)
