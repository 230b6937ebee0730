"""Figures 1 and 2: a square written on an elastic board, at three control rates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from follower_humanoid.arm_experiment.measures import arm_trace, board_numbers
from follower_humanoid.arm_experiment.simulate import simulate_arm
from follower_humanoid.errors import FollowerError

# The same task as by default, written faster.
FASTER = {"speed": 0.3, "board.write_speed": 0.25, "board.rest": 0.4}
STIFFNESS, BOARD, PENETRATION = 1000.0, 2.0e4, 0.005


@pytest.fixture(scope="module", params=[0.002, 0.004, 0.001], ids=["500 Hz", "250 Hz", "1000 Hz"])
def trace(request):
    return arm_trace(simulate_arm("board", 10.0, {"arm_task": FASTER}, tick=request.param))


@pytest.fixture(scope="module")
def numbers(trace):
    return board_numbers(trace, STIFFNESS, BOARD, PENETRATION)


def test_the_square_is_kept_to_while_in_contact(trace, numbers):
    assert (numbers.tracking_error < 0.5e-3).all()
    assert numbers.overshoot < 1e-3
    written = trace.place[trace.touching, 1:]
    np.testing.assert_allclose(np.ptp(written, axis=0), 0.12, atol=1e-3)


def test_static_contact_force_is_that_of_two_springs_in_series(numbers):
    assert numbers.expected_force == pytest.approx(4.762, abs=1e-3)
    assert numbers.static_force == pytest.approx(numbers.expected_force, rel=0.05)


def test_touch_down_is_bounded_and_does_not_bounce(numbers):
    assert numbers.peak_force < 2.5 * numbers.expected_force
    assert numbers.touchdowns == 1


def test_no_force_off_contact_and_none_along_the_board(trace, numbers):
    assert numbers.free_force[0] == 0.0
    assert numbers.free_force[1] < 0.1
    assert (numbers.tangential_force < 0.1).all()
    assert not trace.touching[0]
    assert not trace.touching[-1], "it detaches"


def test_a_force_in_front_of_the_board_would_be_measured(trace):
    contact, sensed = trace.contact.copy(), trace.sensed.copy()
    contact[3, 0], sensed[-1] = -0.3, (0.0, 0.0, 0.7)
    forged = board_numbers(replace(trace, contact=contact, sensed=sensed), STIFFNESS, BOARD, PENETRATION)
    np.testing.assert_array_equal(forged.free_force, (0.3, 0.7))


def test_a_run_without_contact_has_no_numbers():
    trace = arm_trace(simulate_arm("board", 0.1))
    with pytest.raises(FollowerError, match="the hand never touched the board"):
        board_numbers(trace, STIFFNESS, BOARD, PENETRATION)
