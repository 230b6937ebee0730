"""External wrench on the hands: weight and inertia taken out, nothing else."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from arms_bench import TICK, Bench, bending, nobody, on_left, run_arms, swaying

from follower_humanoid.core.samples import SIDES, Joints, Odometry, Side, Wrench
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.sensing.hand_wrench import HandWrenchConfig, HandWrenchSensing
from follower_humanoid.sensing.low_pass import LowPass


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def sensing(robot: RobotModel, filter_time: float = 0.0) -> HandWrenchSensing:
    return HandWrenchSensing(HandWrenchConfig(filter_time=filter_time), robot, TICK)


def sensed_at_rest(robot: RobotModel, left: np.ndarray) -> tuple[Wrench, Wrench]:
    """What is sensed when the left sensor reads the hand's weight plus `left` (6), in l_wrist axes."""
    bench = Bench(robot)
    joints, odometry, _ = bench.state()
    reading = bench.readings[Side.LEFT] + left
    outputs = sensing(robot).step(
        HandWrenchSensing.Inputs(
            joints, odometry, Wrench(reading[:3], reading[3:]), bench.wrist(Side.RIGHT)
        ),
        0.0,
    )
    return outputs.left_hand, outputs.right_hand


def rotation_of_left_wrist(robot: RobotModel) -> np.ndarray:
    bench = Bench(robot)
    bench.hand_place(Side.LEFT)
    rotation: np.ndarray = bench.data.oMf[robot.frame_id("l_wrist")].rotation.copy()
    return rotation


def test_at_rest_the_reading_points_down_and_nothing_is_sensed(robot: RobotModel) -> None:
    bench = Bench(robot)
    weight = rotation_of_left_wrist(robot) @ bench.readings[Side.LEFT][:3]
    np.testing.assert_allclose(weight, [0, 0, -0.345 * 9.81], atol=1e-9)
    for wrench in sensed_at_rest(robot, np.zeros(6)):
        np.testing.assert_allclose(wrench.force, 0, atol=1e-9)
        np.testing.assert_allclose(wrench.torque, 0, atol=1e-9)


def test_force_keeps_its_sign_and_turns_to_world_axes(robot: RobotModel) -> None:
    force_in_world = np.array([5.0, 2.0, -10.0])
    rotation = rotation_of_left_wrist(robot)
    in_wrist = rotation.T @ force_in_world
    moment = np.cross([0, 0, -0.09], in_wrist)  # a force at the gripper, seen at the wrist
    left, right = sensed_at_rest(robot, np.concatenate((in_wrist, moment)))
    np.testing.assert_allclose(left.force, force_in_world, atol=1e-9)
    np.testing.assert_allclose(left.torque, 0, atol=1e-9)
    np.testing.assert_allclose(right.force, 0, atol=1e-9)


def test_moment_is_about_the_gripper(robot: RobotModel) -> None:
    rotation = rotation_of_left_wrist(robot)
    left, _ = sensed_at_rest(robot, np.concatenate((np.zeros(3), [0.1, 0.2, 0.3])))
    np.testing.assert_allclose(left.torque, rotation @ [0.1, 0.2, 0.3], atol=1e-9)
    left, _ = sensed_at_rest(robot, np.concatenate(([1.0, 0, 0], np.zeros(3))))  # a force at the wrist
    np.testing.assert_allclose(left.torque, rotation @ np.cross([0, 0, 0.09], [1.0, 0, 0]), atol=1e-9)


def test_wild_motion_is_taken_out(robot: RobotModel) -> None:
    """Seeded random joint and base motion: the sensed wrench stays near zero, the raw one does not."""
    rng = np.random.default_rng(4)
    amplitude, rate, phase = rng.uniform(0.1, 0.3, 51), rng.uniform(3, 8, 51), rng.uniform(0, 6, 51)
    model, data = robot.pin_model, robot.pin_model.createData()
    component, h = sensing(robot), 1e-3
    raw, sensed = [], []
    v = amplitude * rate * np.cos(phase)
    q = pin.integrate(model, pin.neutral(model), amplitude * np.sin(phase))
    total = {side: np.zeros(6) for side in SIDES}
    for step in range(1, 601):
        acceleration = -amplitude * rate**2 * np.sin(rate * step * h + phase)
        pin.rnea(model, data, q, v, acceleration)
        for side in SIDES:
            total[side] -= data.f[model.getJointId(f"{side.prefix}_wrist_roll")].vector / 2
        v = v + h * acceleration
        q = pin.integrate(model, q, h * v)
        if step % 2 == 0:
            inputs = inputs_of(robot, q, v, total)
            outputs = component.step(inputs, step * h)
            raw.append(np.linalg.norm(inputs.left_wrist.force))
            sensed.append(np.concatenate((outputs.left_hand.force, outputs.left_hand.torque * 10)))
            total = {side: np.zeros(6) for side in SIDES}
    assert np.ptp(raw) > 2.0
    assert np.sqrt(np.mean(np.square(sensed[1:]), axis=0)).max() < 0.05


def inputs_of(robot: RobotModel, q: np.ndarray, v: np.ndarray, wrists: dict) -> HandWrenchSensing.Inputs:
    return HandWrenchSensing.Inputs(
        Joints(q[7:], v[6:], np.zeros(45)),
        Odometry(q[:3], q[3:7], v[:3], v[3:6]),
        *(Wrench(wrists[side][:3].copy(), wrists[side][3:].copy()) for side in SIDES),
    )


def test_a_swaying_body_is_not_felt(robot: RobotModel) -> None:
    trace = run_arms(Bench(robot, swaying, bending), 4.0, nobody)
    rms = np.sqrt((trace.sensed[:, :, :3] ** 2).mean(axis=0))
    assert rms.max() < 0.05, "issue: 0.2 N rms per axis"


def test_a_constant_pull_is_never_tared_away(robot: RobotModel) -> None:
    trace = run_arms(Bench(robot), 8.0, on_left(3.0, 0.0, -10.0))
    np.testing.assert_allclose(trace.sensed[-1, 0, :3], [3.0, 0.0, -10.0], atol=0.005)


def test_filter_answers_a_step_as_a_first_order_lag() -> None:
    low_pass = LowPass(0.1, 0.01)
    assert low_pass.step(np.array([2.0])) == 2.0, "the first sample passes unchanged"
    values = [float(low_pass.step(np.array([3.0]))[0]) for _ in range(30)]
    expected = 3.0 - np.exp(-0.01 * np.arange(1, 31) / 0.1)
    np.testing.assert_allclose(values, expected, atol=1e-12)


def test_filter_of_time_zero_is_none() -> None:
    low_pass = LowPass(0.0, 0.01)
    low_pass.step(np.array([1.0]))
    assert low_pass.step(np.array([5.0])) == 5.0
