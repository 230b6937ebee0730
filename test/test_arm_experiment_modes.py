"""Switching modes on a moving, loaded arm; passivity; singularities and joint limits; the walker's arms."""

from __future__ import annotations

import numpy as np
import pytest
from arm_experiment_bench import COMPENSATION, IMPEDANCE, drive, free_arm, nobody, random_pushes

from follower_humanoid.arm_experiment.measures import arm_trace, energy_given_back, torque_step
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.robot.model import RobotModel

BACK_AND_FORTH = {0.6: COMPENSATION, 1.1: IMPEDANCE, 1.3: COMPENSATION, 1.36: IMPEDANCE}


def switches(trace):
    return np.flatnonzero(np.diff(trace.led.astype(int))) + 1


@pytest.mark.parametrize("tick", [0.002, 0.004, 0.001])
def test_no_bump_while_somebody_pulls(tick):
    held = np.array([8.0, -6.0, 10.0])
    _, trace = free_arm(2.0, lambda now: held if now > 0.3 else None, modes=BACK_AND_FORTH, tick=tick)
    assert len(switches(trace)) == 4
    assert max(torque_step(trace.torque, n) for n in switches(trace)) < 2.0


def test_no_bump_in_the_middle_of_a_fast_line():
    _, trace = free_arm(2.0, nobody, modes=BACK_AND_FORTH, task=True)
    assert trace.speed[switches(trace)[0]] > 0.05
    assert max(torque_step(trace.torque, n) for n in switches(trace)) < 2.0


@pytest.mark.parametrize("mode", [COMPENSATION, IMPEDANCE])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_arm_gives_back_no_more_than_it_received(mode, seed):
    _, trace = free_arm(2.5, random_pushes(seed, 15.0, 2.0), mode)
    between = 0.5 * (trace.rate[1:] + trace.rate[:-1])
    assert np.abs(trace.applied).max() > 2.0
    assert energy_given_back(trace.applied[1:], between, 0.002) <= 1e-4


@pytest.mark.parametrize(
    "direction", [(25, 0, 0), (20, 20, 20), (0, 25, 0), (-25, 0, 0), (0, 0, -25)], ids=str
)
def test_bounded_where_the_arm_straightens_and_at_joint_stops(direction):
    robot, force = RobotModel(), np.array(direction, dtype=float)
    arm = robot.groups.left_arm
    run, trace = free_arm(2.2, lambda now: force if 0.1 < now < 1.7 else None, COMPENSATION)
    assert np.abs(trace.velocity).max() < 8.0
    assert np.abs(run["arms/command"].effort).max() < 40.0
    assert (trace.position > robot.lower[arm] - 0.01).all()
    assert (trace.position < robot.upper[arm] + 0.01).all()
    assert trace.speed[-1] < 1e-3, "it comes to rest"


def test_a_payload_hangs_still():
    weight = np.array([0.0, 0.0, -10.0])
    _, trace = free_arm(1.5, lambda now: weight, COMPENSATION, payload=10.0)
    assert np.abs(trace.place[-1] - trace.place[0]).max() < 5e-3
    assert trace.speed[-1] < 1e-3


def test_a_person_leads_an_arm_of_the_standing_follower():
    chain = Chain({}, without=("leader", "gait_mapping"))
    lead = np.array([6.0, 3.0, -8.0])
    modes = {0.2: COMPENSATION, 2.0: IMPEDANCE}
    run = drive(chain, 2.4, lambda now: lead if 0.3 < now < 1.3 else None, modes)
    trace = arm_trace(run)
    assert chain.simulator.fall is None
    led = trace.place[np.searchsorted(trace.time, 1.3)] - trace.place[0]
    assert led @ lead / np.linalg.norm(lead) > 0.08
    resting = (trace.time > 1.8) & (trace.time < 2.0)
    assert trace.speed[resting].max() < 5e-3, "it stays where it was led to, but for the body's sway"
    assert max(torque_step(trace.torque, n) for n in switches(trace)) < 2.0
