"""The arm controller on a bench of its own: compliance, return, places, robustness."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from arms_bench import (
    SIDES,
    TICK,
    Bench,
    Trace,
    bending,
    carrying,
    nobody,
    on_left,
    run_arms,
    swaying,
    turning,
)

from follower_humanoid.control.arms import ArmController, ArmControllerConfig
from follower_humanoid.control.motor_inverse import MotorModel
from follower_humanoid.core.config import parameters_of
from follower_humanoid.core.samples import Side
from follower_humanoid.robot.model import RobotModel

MILLIMETRE = 1e-3


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def theory(time: np.ndarray, force: float, stiffness: float, config: ArmControllerConfig) -> np.ndarray:
    """Displacement under a step force: eq. (3) with eqs. (17), (18), integrated finely."""
    mass, h = config.inertia[0], 1e-4
    damping = 2 * np.sqrt(mass * stiffness)
    k_p, k_d = config.return_proportional, config.return_differential
    x, v, spring, out = 0.0, 0.0, 0.0, []
    for _ in range(round(time[-1] / h) + 1):
        out.append(x)
        back = -k_p * x - k_d * v
        # H (ẍ − v̇_ref) = F − D (ẋ − v_ref) − K (x − ∫v_ref),  v̇_ref = −K_P ẋ − K_D ẍ
        a = (force - damping * (v - back) - stiffness * (x - spring) - mass * k_p * v) / (mass * (1 + k_d))
        v += h * a
        x += h * v
        spring += h * back
    return np.interp(time, h * np.arange(len(out)), out)


@pytest.mark.parametrize("axis", [0, 1])
def test_gives_way_horizontally_and_returns_while_the_force_stays(robot: RobotModel, axis: int) -> None:
    force = np.zeros(3)
    force[axis] = 5.0
    trace = run_arms(Bench(robot), 5.0, on_left(*force))
    along = trace.left[:, axis]
    peak = along[trace.time <= 1.0].max()
    assert 20 * MILLIMETRE <= peak <= 45 * MILLIMETRE
    assert np.abs(trace.left[-1]).max() <= 5 * MILLIMETRE
    expected = theory(trace.time, 5.0, 100.0, ArmControllerConfig())
    assert np.abs(along - expected).max() < 2 * MILLIMETRE
    others = np.delete(trace.left, axis, axis=1)
    assert np.abs(others).max() < 1 * MILLIMETRE
    assert np.abs(trace.right).max() < 0.1 * MILLIMETRE


@pytest.mark.parametrize("newton", [-10.0, 10.0])
def test_stiff_vertically(robot: RobotModel, newton: float) -> None:
    trace = run_arms(Bench(robot), 2.0, on_left(0.0, 0.0, newton))
    assert np.abs(trace.left).max() <= 5 * MILLIMETRE
    assert np.sign(trace.left[250, 2]) == np.sign(newton), "it gives way along the force"


def test_return_time_constant_is_one_plus_differential_over_proportional(robot: RobotModel) -> None:
    trace = run_arms(Bench(robot), 4.0, on_left(5.0, 0.0, 0.0))
    late = (trace.time > 2.0) & (trace.time < 4.0)
    decay = np.polyfit(trace.time[late], np.log(trace.left[late, 0]), 1)[0]
    assert -1 / decay == pytest.approx((1 + 0.1) / 0.8, rel=0.1)


def test_an_object_held_from_the_start_does_not_sag(robot: RobotModel) -> None:
    weight = {Side.LEFT: np.array([0.0, 0.0, -50.0])}
    trace = run_arms(Bench(robot, held=weight), 1.5, lambda time: weight)
    assert np.abs(trace.left[:, 2]).max() < 2 * MILLIMETRE, "50 N at 3000 N/m would be 17 mm"
    assert np.abs(trace.left).max() < 2 * MILLIMETRE, "the first tick knows of no force yet"


def test_without_force_the_hands_stay(robot: RobotModel) -> None:
    trace = run_arms(Bench(robot), 1.0, nobody)
    assert np.abs(trace.shift).max() < 1e-6
    assert np.abs(trace.arm_velocity).max() < 1e-5


def test_a_moving_body_does_not_shake_the_hands(robot: RobotModel) -> None:
    trace = run_arms(Bench(robot, swaying, bending), 4.0, nobody)
    assert np.abs(trace.shift).max() < 4 * MILLIMETRE


def test_places_are_kept_through_a_turn(robot: RobotModel) -> None:
    trace = run_arms(Bench(robot, turning), 7.0, nobody)
    assert np.abs(trace.shift).max() < 1 * MILLIMETRE


def test_self_motion_dies_after_a_push(robot: RobotModel) -> None:
    trace = run_arms(
        Bench(robot), 2.5, lambda time: {Side.LEFT: np.array([0.0, 15.0, 0.0]) if time < 0.5 else np.zeros(3)}
    )
    assert np.abs(trace.arm_velocity[trace.time < 0.6]).max() > 0.1
    assert np.abs(trace.arm_velocity[-1]).max() < 0.06


def test_left_and_right_mirror_each_other(robot: RobotModel) -> None:
    left = run_arms(Bench(robot), 1.0, lambda time: {Side.LEFT: np.array([4.0, 3.0, -10.0])})
    right = run_arms(Bench(robot), 1.0, lambda time: {Side.RIGHT: np.array([4.0, -3.0, -10.0])})
    np.testing.assert_allclose(left.left, right.right * [1, -1, 1], atol=1e-9)


def bounded(trace: Trace) -> None:
    assert np.all(np.isfinite(trace.voltage))
    assert np.linalg.norm(trace.left, axis=1).max() < 0.2
    assert np.abs(trace.arm_velocity).max() < 12.0


@pytest.mark.parametrize(
    "force", [(80.0, -40.0, 60.0), (-80.0, -40.0, -60.0), (30.0, 0.0, -100.0), (0.0, 60.0, 0.0)]
)
def test_strong_pulls_stay_within_reach_and_come_back(
    robot: RobotModel, force: tuple[float, float, float]
) -> None:
    trace = run_arms(Bench(robot), 3.0, lambda t: {Side.LEFT: np.array(force) if t < 1.0 else np.zeros(3)})
    bounded(trace)
    assert np.linalg.norm(trace.left[-1]) < 40 * MILLIMETRE
    assert np.abs(trace.arm_velocity[-1]).max() < 0.2


@pytest.mark.parametrize("elbow", [-0.02, -0.3, -2.45])
def test_bounded_with_straight_or_folded_arms(robot: RobotModel, elbow: float) -> None:
    position = carrying(robot)
    for prefix in "lr":
        position[robot.joint_index(f"{prefix}_shoulder_roll")] = 0.0
        position[robot.joint_index(f"{prefix}_elbow")] = elbow
    trace = run_arms(Bench(robot, position=position), 2.0, on_left(10.0, 5.0, -10.0))
    bounded(trace)
    assert np.abs(trace.arm_velocity[-1]).max() < 1.0


@pytest.mark.parametrize("period", [0.001, 0.002, 0.004])
def test_the_same_at_other_control_rates(robot: RobotModel, period: float) -> None:
    trace = run_arms(Bench(robot, tick_length=period), 2.0, on_left(5.0, 0.0, -10.0))
    expected = theory(trace.time, 5.0, 100.0, ArmControllerConfig())
    assert np.abs(trace.left[:, 0] - expected).max() < 2 * MILLIMETRE
    assert np.abs(trace.left[:, 2]).max() < 5 * MILLIMETRE


def test_tolerates_wrong_motor_data(robot: RobotModel) -> None:
    motor = MotorModel(resistance=0.7, torque_constant=0.088, rotor_inertia=4.5e-5)
    trace = run_arms(Bench(robot, motor=motor), 4.0, on_left(5.0, 0.0, -10.0))
    assert np.abs(trace.left).max() < 60 * MILLIMETRE
    assert np.abs(trace.left[-1]).max() < 15 * MILLIMETRE


def test_before_the_first_wrench_it_holds_the_places(robot: RobotModel) -> None:
    bench = Bench(robot)
    controller = ArmController(ArmControllerConfig(), robot, TICK)
    for _ in range(50):
        joints, odometry, imu = bench.state()
        command = controller.step(
            ArmController.Inputs(joints, odometry, imu, None, None), bench.time
        ).command
        bench.tick(command.effort, {})
    assert np.abs(bench.arm_velocity).max() < 1e-6


def test_command_lists_both_arms_within_joint_and_voltage_limits(robot: RobotModel) -> None:
    bench = Bench(robot)
    config = ArmControllerConfig(motor=MotorModel(voltage_limit=0.1))
    controller = ArmController(config, robot, TICK)
    joints, odometry, imu = bench.state()
    command = controller.step(ArmController.Inputs(joints, odometry, imu, None, None), 0.0).command
    arms = robot.groups.arms
    assert command.effort.shape == command.position.shape == command.velocity.shape == (14,)
    assert np.abs(command.effort).max() <= 0.1
    np.testing.assert_allclose(command.position[3], joints.position[arms[3]])
    assert np.all(command.position >= robot.lower[arms])
    assert np.all(command.position <= robot.upper[arms])


def test_hands_are_first_seen_where_they_are(robot: RobotModel) -> None:
    bench = Bench(robot)
    places = np.array([bench.hand_place(side) for side in SIDES])
    assert np.all(places[:, 0] > 0.2), "the carrying posture holds the hands ahead of the pelvis"
    np.testing.assert_allclose(places[0] * [1, -1, 1], places[1], atol=1e-12)


def test_every_parameter_says_what_it_is() -> None:
    for info in parameters_of(ArmControllerConfig):
        assert info.meaning
        assert info.choices or (info.low is not None and info.high is not None)
    assert dataclasses.is_dataclass(ArmControllerConfig)
