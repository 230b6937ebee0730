"""When a run is over: at its end, when the robot stands, or a second after a fall."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.graph.graph_config import RunConfig
from follower_humanoid.graph.run_end import RunEnd
from follower_humanoid.robot.model import RobotModel

ROBOT = RobotModel()
BOTH = (np.array([0.0, 0.0, 300.0]), np.array([0.0, 0.0, 320.0]))
ONE = (np.array([0.0, 0.0, 620.0]), np.zeros(3))
TICKS = np.arange(0, 40_000) * 0.002


def ends_at(config, speed=lambda t: 0.0, feet=lambda t: BOTH, fallen=None):
    """First tick at which the run is over, None if it never is."""
    end = RunEnd(config, ROBOT)
    for time in TICKS:
        fell = fallen if fallen is not None and time >= fallen else None
        if end.over(float(time), np.array([speed(time), 0.0, 0.0]), feet(time), fell):
            return round(float(time), 6)
    return None


def test_a_run_without_end_has_none():
    assert ends_at(RunConfig()) is None


def test_a_given_duration_cuts_in_the_middle_of_a_step():
    assert ends_at(RunConfig(duration=3.0), speed=lambda t: 0.3, feet=lambda t: ONE) == 3.0


def test_it_waits_until_the_robot_has_stood_for_a_second():
    config = RunConfig(duration=20.0, settle=10.0)
    assert ends_at(config, speed=lambda t: 0.3 if t < 24.0 else 0.0) == pytest.approx(25.0, abs=0.003)
    assert ends_at(config) == 20.0


def test_a_robot_on_one_foot_does_not_stand():
    config = RunConfig(duration=20.0, settle=10.0)
    assert ends_at(config, feet=lambda t: ONE if t < 23.0 else BOTH) == pytest.approx(24.0, abs=0.003)


def test_it_does_not_wait_for_ever():
    assert ends_at(RunConfig(duration=20.0, settle=10.0), speed=lambda t: 0.3) == 30.0


def test_a_fall_ends_it_a_second_later_even_without_duration():
    assert ends_at(RunConfig(), fallen=2.0) == 3.0
