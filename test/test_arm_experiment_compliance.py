"""Figure 3: pushed on its way to a target, the hand follows, comes to rest, and goes on."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.arm_experiment.measures import arm_trace, pushes
from follower_humanoid.arm_experiment.simulate import simulate_arm

TARGET = np.array((0.45, 0.25, 0.40))


@pytest.fixture(scope="module", params=[0.002, 0.004, 0.001], ids=["500 Hz", "250 Hz", "1000 Hz"])
def trace(request):
    return arm_trace(simulate_arm("compliance", 9.6, tick=request.param))


@pytest.fixture(scope="module")
def found(trace):
    return pushes(trace)


def test_it_is_pushed_twice_when_the_paper_says(found):
    times = [(push.begin, push.end) for push in found]
    np.testing.assert_allclose(times, [(1.0, 2.0), (4.0, 5.0)], atol=0.03)


def test_the_hand_follows_the_force(trace, found):
    for push in found:
        assert 0.05 < push.yielded < 0.2
    during = (trace.time > 1.3) & (trace.time < 1.9)
    np.testing.assert_allclose(trace.rate[during, 2], -8.0 / 60.0, rtol=0.05)


def test_the_elbow_comes_to_rest_and_nothing_drifts(found):
    for push in found:
        assert push.elbow_peak > 0.1
        assert push.elbow_left < 0.01
        assert push.drift < 1e-3


def test_modes_switch_without_a_bump(trace, found):
    assert np.count_nonzero(np.diff(trace.led.astype(int))) == 4
    for push in found:
        assert push.torque_step < 2.0


@pytest.mark.parametrize("again", [False, True], ids=["silent", "the same again and again"])
def test_where_the_target_stops_in_the_middle_of_its_way_the_hand_stops(again):
    last = []

    def until_half_a_second(topic, tick, sample):
        if topic != "left_hand/target":
            return sample
        last.extend([sample] if tick == 250 else [])
        return sample if tick <= 250 else last[0] if again else None

    run = simulate_arm("compliance", 2.0, interference=until_half_a_second, without=("leader",))
    assert np.linalg.norm(last[0].linear_velocity) > 0.05
    trace = arm_trace(run)
    np.testing.assert_allclose(trace.place[-1], last[0].position, atol=1e-4)
    way = last[0].linear_velocity / np.linalg.norm(last[0].linear_velocity)
    assert (trace.place - last[0].position).dot(way).max() < 10e-3
    stopping = (trace.time > 0.5) & (trace.time < 0.8)
    assert np.abs(np.diff(trace.torque[stopping], axis=0)).max() < 2.0


def test_a_hand_that_an_obstacle_stops_is_not_sent_back():
    straight_on = {"speed": 0.02, "compliance.target": [0.45, 0.19, 0.18]}
    obstacle = {"board.stiffness": 2e4, "board.distance": 0.4}
    parameters = {"arm_task": straight_on, "simulator": obstacle, "arm_controller": {"mode": "impedance"}}
    trace = arm_trace(simulate_arm("compliance", 6.5, parameters, without=("leader",)))
    assert trace.touching[-1]
    apart = np.linalg.norm(trace.target - trace.place, axis=1)
    assert apart.max() > 0.0199, "the target went on until the hand counted as led"
    assert apart.max() < 0.021
    assert np.linalg.norm(np.diff(trace.target, axis=0), axis=1).max() < 0.021


def test_then_it_goes_to_the_target_in_a_straight_line(trace):
    assert np.linalg.norm(trace.place[-1] - TARGET) < 2e-3
    last = trace.place[trace.time > 6.2]
    way = (TARGET - last[0]) / np.linalg.norm(TARGET - last[0])
    aside = (last - last[0]) - np.outer((last - last[0]) @ way, way)
    assert np.abs(aside).max() < 1e-3
    assert (last - TARGET).dot(way).max() < 1e-3, "no overshoot"
