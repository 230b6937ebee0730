"""Faults tried without a running graph: each line of the table must hold."""

from __future__ import annotations

import math

import numpy as np
import pytest

from follower_humanoid.core.samples import Joints, Wrench
from follower_humanoid.faults import soak
from follower_humanoid.faults.case import Effort
from follower_humanoid.faults.falling import falling
from follower_humanoid.faults.limits import beyond_limits, chain_with
from follower_humanoid.faults.messages import hostile_messages
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.plant.drives import Drives, HoldConfig
from follower_humanoid.plant.motors import MotorConfig
from follower_humanoid.plant.pull_limits import PullLimiter, PullLimits
from follower_humanoid.robot.model import RobotModel


@pytest.mark.parametrize("tried", [hostile_messages, beyond_limits, falling])
@pytest.mark.filterwarnings("ignore:.*encountered in dot")
def test_every_line_holds(tried):
    lines = list(tried(Effort(brief=True)))
    assert lines
    assert [f"{line.what}: {line.measured}" for line in lines if not line.passed] == []


def test_a_soak_says_how_it_goes_and_holds(tmp_path, monkeypatch):
    monkeypatch.setattr("follower_humanoid.faults.soak._MINUTE", 500)
    monkeypatch.setattr("follower_humanoid.faults.soak._BAG", 2)
    said = []
    lines = list(soak.walk(0.05, 1, tmp_path, said.append))
    assert [f"{line.what}: {line.measured}" for line in lines if not line.passed] == []
    assert [text.partition(",")[0] for text in said] == ["1 min", "2 min", "3 min"]
    assert "1500 states of 1500 ticks" in lines[-1].measured


def test_a_random_leader_is_the_same_again_and_another_with_another_seed():
    def course(seed):
        leader = soak.RandomLeader(seed)
        pulls = [leader("leader/right_hand/wrench", tick, None).force for tick in range(0, 60_000, 250)]
        return np.array(pulls)

    np.testing.assert_array_equal(course(1), course(1))
    assert not np.array_equal(course(1), course(2))
    strength = np.linalg.norm(course(1), axis=1)
    assert strength.min() == 0.0
    assert 3.0 < strength.max() <= 6.0


@pytest.mark.parametrize("node", [name for name in NODES if name not in ("simulator", "leader")])
def test_standing_it_stays_up_while_a_controller_says_nothing(node):
    silent = set(NODES[node].outputs.values())

    def said(topic, tick, sample):
        return None if topic in silent and 25 <= tick < 150 else sample

    chain, fault = chain_with(said, 0.5)
    assert fault == ""
    assert chain.simulator.plant.q[2] > 0.8


def test_without_faults_nothing_is_held_or_limited():
    chain, fault = chain_with(lambda topic, tick, sample: sample, 0.5, leader=True)
    assert fault == ""
    told = chain.simulator.diagnostics()
    assert set(told.values()) == {0}


@pytest.mark.parametrize(
    "force", [[300.0, 0.0, 0.0], [1e300, -1e300, 1e300], [120.0, 160.0, 0.1], [1e-300] * 3]
)
def test_a_pull_is_cut_to_the_limit_in_its_own_direction_once(force):
    limiter = PullLimiter(PullLimits())
    pull = Wrench(np.array(force), np.zeros(3))
    cut = limiter.limited("left_hand", pull)
    assert np.linalg.norm(cut.force) <= 200.0 * (1 + 1e-9)
    if max(map(abs, force)) > 100.0:
        direction = np.array(force) / max(map(abs, force))
        np.testing.assert_allclose(cut.force / max(abs(cut.force)), direction, rtol=1e-12)
        assert limiter.cut["left_hand"] == 1
    else:
        assert cut is pull
    again = PullLimiter(PullLimits())
    assert again.limited("left_hand", cut) is cut
    assert again.cut["left_hand"] == 0


def test_a_drive_holds_within_the_range_of_its_joints():
    robot = RobotModel()
    joints = robot.groups.arms
    drives = Drives(HoldConfig(), MotorConfig(), robot, joints)
    position, voltage = np.zeros(45), np.zeros(45)
    drives.start(position, voltage)
    drives.receive(Joints(np.full(14, 1e300), np.full(14, -1e300), np.zeros(14)))
    drives.receive(None)
    position[joints] = robot.upper[joints]
    drives.write(position, np.zeros(45), voltage)
    assert drives.limited == 1
    back_emf = MotorConfig().gear * MotorConfig().back_emf_constant
    np.testing.assert_allclose(voltage[joints], back_emf * HoldConfig().velocity_limit)


@pytest.mark.parametrize("margin", [0.0, 0.25, 0.5])
def test_a_margin_never_takes_a_held_position_out_of_a_short_range(margin):
    robot = RobotModel()
    joints = robot.groups.legs
    drives = Drives(HoldConfig(stop_margin=margin), MotorConfig(), robot, joints)
    lower, upper = robot.lower[joints], robot.upper[joints]
    middle = 0.5 * (lower + upper)
    for beyond, near in ((-10.0, lower), (10.0, upper)):
        drives.receive(Joints(np.full(len(joints), beyond), np.zeros(len(joints)), np.zeros(len(joints))))
        drives.receive(None)
        # Where it is held no voltage is spent.
        position, voltage = np.zeros(45), np.zeros(45)
        held = np.where(np.abs(upper - lower) < 2.0 * margin, middle, near + np.sign(middle - near) * margin)
        position[joints] = held
        drives.write(position, np.zeros(45), voltage)
        np.testing.assert_allclose(voltage[joints], 0.0, atol=1e-9)


def test_a_slack_drive_gives_no_voltage_until_it_starts_anew():
    robot = RobotModel()
    drives = Drives(HoldConfig(), MotorConfig(), robot, robot.groups.arms)
    position, voltage = np.zeros(45), np.full(45, math.pi)
    drives.start(position, voltage)
    drives.slacken()
    drives.receive(Joints(*(np.ones(14) for _ in range(3))))
    drives.write(position, position, voltage)
    assert (voltage[robot.groups.arms] == 0.0).all()
    drives.start(position, np.ones(45))
    drives.write(position, position, voltage)
    assert (voltage[robot.groups.arms] == 1.0).all()
