"""The fixed trunk and the board against closed forms and an independent model."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arm_experiment_bench import IMPEDANCE, free_arm

from follower_humanoid.core.config import build
from follower_humanoid.core.samples import Wrench
from follower_humanoid.plant.board import Board, BoardConfig
from follower_humanoid.plant.simulator import Simulator, SimulatorConfig
from follower_humanoid.robot.model import BASE_DOF, RobotModel

TICK = 0.002


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


@pytest.fixture
def simulator(robot):
    made = Simulator(build(SimulatorConfig, {"fixed_trunk": True}), robot, TICK)
    yield made
    made.close()


def push(simulator, newton, ticks):
    force = Wrench(np.asarray(newton, dtype=float), np.zeros(3))
    for _ in range(ticks):
        simulator.advance(Simulator.Inputs(leader_left=force))


def test_nothing_but_the_arms_moves_however_hard_it_is_pulled(robot, simulator):
    before = simulator.observe()
    push(simulator, (40.0, 30.0, -60.0), 200)
    after = simulator.observe()
    held = np.setdiff1d(np.arange(45), robot.groups.arms)
    np.testing.assert_array_equal(after.joints.position[held], before.joints.position[held])
    np.testing.assert_array_equal(after.odometry.position, before.odometry.position)
    np.testing.assert_array_equal(after.joints.velocity[held], 0.0)
    assert np.abs(after.joints.position - before.joints.position)[robot.groups.left_arm].max() > 0.005
    assert not after.left_foot.force.any()
    assert simulator.fall is None


def test_at_rest_it_hangs_still(robot, simulator):
    before = simulator.observe().joints.position
    push(simulator, (0.0, 0.0, 0.0), 250)
    np.testing.assert_allclose(simulator.observe().joints.position, before, atol=1e-6)


def test_arms_move_as_an_independent_model_of_arms_on_a_fixed_base_does(robot, simulator):
    plant = simulator.plant
    names = list(robot.pin_model.names)
    locked = [n for n in range(1, len(names)) if n - 2 not in robot.groups.arms]
    arms = pin.buildReducedModel(robot.pin_model, locked, plant.q.copy())
    motors = plant.motors
    push(simulator, (5.0, 8.0, 3.0), 40)
    q, v = plant.q[7 + robot.groups.arms].copy(), plant.v[BASE_DOF + robot.groups.arms].copy()
    voltage = np.zeros(45)
    plant.step(voltage)
    arms.armature = motors.inertia[robot.groups.arms]
    data = arms.createData()
    implicit = np.diag(motors.inertia[robot.groups.arms] + 0.001 * motors.damping[robot.groups.arms])
    mass = pin.crba(arms, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T - np.diag(motors.inertia[robot.groups.arms]) + implicit
    drive = (motors.drive - motors.damping * np.r_[np.zeros(45)])[robot.groups.arms]
    drive -= motors.damping[robot.groups.arms] * v
    expected = np.linalg.solve(mass, drive - pin.nonLinearEffects(arms, data, q, v))
    found = (plant.v[BASE_DOF + robot.groups.arms] - v) / 0.001
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4)


def test_the_board_is_a_spring_without_friction(robot, simulator):
    plant = simulator.plant
    data = robot.pin_model.createData()
    pin.framesForwardKinematics(robot.pin_model, data, plant.q)
    hand = data.oMf[robot.frame_id("l_gripper")].translation[0]
    board = Board(BoardConfig(stiffness=2.0e4, distance=float(hand - plant.q[0]) - 0.003), plant)
    left, right = board.pulls()
    np.testing.assert_allclose(left.force, (-60.0, 0.0, 0.0), rtol=1e-6)
    np.testing.assert_allclose(right.force, left.force, rtol=1e-6)
    np.testing.assert_allclose(board.mean_force()[0], left.force)
    away = Board(BoardConfig(stiffness=2.0e4, distance=float(hand - plant.q[0]) + 0.001), plant)
    assert away.pulls() == ()


def test_without_a_board_nothing_is_said_of_contact(simulator):
    assert simulator.observe().left_contact is None


def test_the_wrist_feels_the_board_and_nothing_else_tells_the_controller():
    from follower_humanoid.graph.wiring import ARM_TASK, nodes_with

    table = nodes_with((ARM_TASK.name,))
    readers = [name for name, node in table.items() if "left_hand/contact" in node.inputs.values()]
    assert readers == []


def test_the_fixed_trunk_is_repeatable_bit_for_bit():
    force = np.array([3.0, -2.0, 5.0])
    first, second = (free_arm(0.3, lambda now: force, IMPEDANCE)[0] for _ in range(2))
    assert first.joint_hash() == second.joint_hash()


def test_after_a_reset_nobody_touches_the_board(robot):
    board = {"board.stiffness": 1000.0, "board.distance": 0.2}
    simulator = Simulator(build(SimulatorConfig, {"fixed_trunk": True, **board}), robot, TICK)
    try:
        push(simulator, (5.0, 0.0, 0.0), 5)
        assert simulator.observe().left_contact.force[0] < 0.0
        simulator.reset()
        assert not simulator.observe().left_contact.force.any()
    finally:
        simulator.close()
