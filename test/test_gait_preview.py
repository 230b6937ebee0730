"""The planned DCM is the discounted future of the ZMP, and the CoM follows the pendulum's equation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from follower_humanoid.gait.preview import ZmpLeg, com_after, planned_dcm

OMEGA = 3.4
ZMP = np.array([0.05, -0.02])
PLAN: list[ZmpLeg] = [
    (np.array([0.05, 0.09]), 1.2),
    (None, 0.1),
    (np.array([0.15, 0.09]), 0.8),
    (np.array([0.40, -0.09]), 0.7),
    (np.array([0.50, -0.09]), 0.9),
]


def zmp_at(start: np.ndarray, plan: list[ZmpLeg], time: float) -> np.ndarray:
    """The piecewise linear plan at a time; it rests after its end."""
    point = start
    for target, duration in plan:
        goal = point if target is None else target
        if time < duration:
            return np.asarray(point + (goal - point) * time / duration)
        time -= duration
        point = goal
    return point


def discounted_future(
    start: np.ndarray, plan: list[ZmpLeg], after: float = 0.0, end: float = 60.0
) -> np.ndarray:
    """ω ∫ p(t + s) e^{−ωs} ds by the midpoint rule, what lies beyond `end` resting."""
    step = 2e-4
    s = np.arange(0.5 * step, end, step)[: round(10.0 / step)]
    values = np.array([zmp_at(start, plan, after + x) for x in s])
    tail = values[-1] * math.exp(-OMEGA * s[-1])
    return np.asarray(OMEGA * step * (np.exp(-OMEGA * s) @ values) + tail)


def test_planned_dcm_is_the_discounted_future_of_the_zmp() -> None:
    expected = discounted_future(ZMP, PLAN)
    np.testing.assert_allclose(planned_dcm(ZMP, PLAN, OMEGA, math.inf), expected, atol=1e-6)


def test_a_plan_that_rests_keeps_the_dcm_over_the_zmp() -> None:
    np.testing.assert_array_equal(planned_dcm(ZMP, [], OMEGA, 4.0), ZMP)
    np.testing.assert_array_equal(planned_dcm(ZMP, [(None, 3.0)], OMEGA, 4.0), ZMP)


def test_a_jump_of_the_zmp_counts_by_its_discount() -> None:
    target = ZMP + np.array([0.1, 0.0])
    dcm = planned_dcm(ZMP, [(None, 0.5), (target, 0.0)], OMEGA, 4.0)
    np.testing.assert_allclose(dcm, ZMP + math.exp(-OMEGA * 0.5) * np.array([0.1, 0.0]))


def test_the_planned_dcm_obeys_its_differential_equation() -> None:
    # ξ̇ = ω(ξ − p) along the plan: the DCM planned a little later is where the first one has gone.
    h = 1e-5
    slope = (PLAN[0][0] - ZMP) / PLAN[0][1]
    later_zmp = ZMP + h * slope
    now = planned_dcm(ZMP, PLAN, OMEGA, math.inf)
    later = planned_dcm(later_zmp, [(PLAN[0][0], PLAN[0][1] - h), *PLAN[1:]], OMEGA, math.inf)
    np.testing.assert_allclose((later - now) / h, OMEGA * (now - ZMP), atol=1e-4)


def test_a_four_second_horizon_is_far_enough() -> None:
    far = [*PLAN, (np.array([5.0, 5.0]), 1.0)]
    near = planned_dcm(ZMP, far, OMEGA, 3.6)
    np.testing.assert_allclose(
        near, planned_dcm(ZMP, far, OMEGA, math.inf), atol=5.0 * math.exp(-OMEGA * 3.6)
    )


def test_splitting_a_piece_in_two_changes_nothing() -> None:
    target, duration = PLAN[0]
    half = ZMP + 0.25 * (target - ZMP)
    split = [(half, 0.25 * duration), (target, 0.75 * duration), *PLAN[1:]]
    np.testing.assert_allclose(
        planned_dcm(ZMP, split, OMEGA, 9.0), planned_dcm(ZMP, PLAN, OMEGA, 9.0), atol=1e-14
    )


@pytest.mark.parametrize("pieces", [1, 2, 3, 5])
def test_com_after_agrees_with_numerical_integration_of_the_pendulum(pieces: int) -> None:
    com = np.array([0.04, -0.01])
    dcm = planned_dcm(ZMP, PLAN, OMEGA, math.inf)
    elapsed = sum(duration for _, duration in PLAN[:pieces])

    def pendulum(time: float, state: np.ndarray) -> np.ndarray:
        c, v = state[:2], state[2:]
        return np.concatenate((v, OMEGA**2 * (c - zmp_at(ZMP, PLAN, time))))

    start = np.concatenate((com, OMEGA * (dcm - com)))
    # The DCM is unstable forwards in time: over some seconds only a tight tolerance keeps it on its plan.
    run = solve_ivp(pendulum, (0.0, elapsed), start, rtol=1e-12, atol=1e-13, max_step=0.01)
    expected = run.y[:2, -1]
    found = com_after(ZMP, com, dcm, PLAN[:pieces], PLAN[pieces:], OMEGA, math.inf)
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_com_after_nothing_is_the_com_now() -> None:
    com = np.array([0.04, -0.01])
    dcm = planned_dcm(ZMP, PLAN, OMEGA, math.inf)
    np.testing.assert_allclose(com_after(ZMP, com, dcm, [], PLAN, OMEGA, math.inf), com, atol=1e-14)
