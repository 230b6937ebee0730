"""Places of the hands relative to the pelvis, equation (18) corrected, and Jacobians."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from follower_humanoid.control.hand_task import HandKinematics, forces_in_task_axes, unwritten_motion
from follower_humanoid.robot.model import RobotModel


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel()


def random_state(robot: RobotModel, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    tangent = rng.uniform(-0.5, 0.5, 51)
    tangent[5] = rng.uniform(-3, 3)
    return pin.integrate(robot.pin_model, pin.neutral(robot.pin_model), tangent), rng.normal(size=51)


@pytest.mark.parametrize("seed", range(5))
def test_place_rate_is_the_derivative_of_the_place(robot: RobotModel, seed: int) -> None:
    q, v = random_state(robot, seed)
    kinematics, h = HandKinematics(robot), 1e-6
    after = kinematics.motion(pin.integrate(robot.pin_model, q, h * v), v).place
    before = kinematics.motion(pin.integrate(robot.pin_model, q, -h * v), v).place
    np.testing.assert_allclose(kinematics.motion(q, v).place_rate, (after - before) / (2 * h), atol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_jacobian_against_finite_differences(robot: RobotModel, seed: int) -> None:
    q, v = random_state(robot, 10 + seed)
    kinematics, h = HandKinematics(robot), 1e-6
    motion = kinematics.motion(q, v)
    for hand, arm in enumerate((robot.groups.left_arm, robot.groups.right_arm)):
        for column, joint in enumerate(arm):
            step = np.zeros(51)
            step[6 + joint] = h
            after = kinematics.motion(pin.integrate(robot.pin_model, q, step), v).place[hand]
            before = kinematics.motion(pin.integrate(robot.pin_model, q, -step), v).place[hand]
            np.testing.assert_allclose(
                motion.jacobian[hand, :, column], (after - before) / (2 * h), atol=1e-7
            )


def test_carried_is_what_remains_with_the_arms_frozen(robot: RobotModel) -> None:
    q, v = random_state(robot, 20)
    frozen = v.copy()
    frozen[6 + robot.groups.arms] = 0.0
    kinematics = HandKinematics(robot)
    np.testing.assert_allclose(
        kinematics.motion(q, v).carried, kinematics.motion(q, frozen).place_rate, atol=1e-12
    )


def test_translation_and_turning_of_the_body_move_no_place(robot: RobotModel) -> None:
    """Equation (18) with the offset turned by the base yaw: x_d = R_yaw x_dist + r_base."""
    kinematics, rng = HandKinematics(robot), np.random.default_rng(21)
    position = rng.uniform(-0.3, 0.3, 45)
    motions = []
    for yaw, base in ((0.0, [0, 0, 0.9]), (np.radians(36.87), [2.0, -1.0, 0.8])):
        q = np.concatenate((base, [0, 0, np.sin(yaw / 2), np.cos(yaw / 2)], position))
        v = np.concatenate(([0.3, 0.1, 0.05, 0, 0, 0.7], np.zeros(45)))
        motions.append((q, kinematics.motion(q, v)))
    (_, first), (base_turned, turned) = motions
    np.testing.assert_allclose(turned.place, first.place, atol=1e-12)
    np.testing.assert_allclose(turned.place_rate, 0, atol=1e-12)
    offset = first.yaw_to_world @ first.place[0]
    with_turned_offset = turned.yaw_to_world @ first.place[0] + base_turned[:3]
    with_fixed_offset = offset + base_turned[:3]
    missed = np.linalg.norm(with_turned_offset[:2] - with_fixed_offset[:2])
    radius = np.linalg.norm(first.place[0, :2])
    assert missed == pytest.approx(2 * radius * np.sin(np.radians(36.87) / 2)), "what (18) in print misses"


def test_forces_are_turned_into_the_axes_of_the_task(robot: RobotModel) -> None:
    q, v = random_state(robot, 22)
    axes = HandKinematics(robot).motion(q, v).yaw_to_world
    left, right = np.random.default_rng(22).normal(size=(2, 3))
    np.testing.assert_allclose(forces_in_task_axes(axes, left, right), [axes.T @ left, axes.T @ right])


def test_wrench_jacobian_gives_the_power_of_a_wrench_on_the_hand(robot: RobotModel) -> None:
    q, v = random_state(robot, 23)
    found = HandKinematics(robot).motion(q, v).wrench_jacobian
    data = robot.pin_model.createData()
    for hand, side in enumerate("lr"):
        frame = robot.frame_id(f"{side}_gripper")
        full = pin.computeFrameJacobian(robot.pin_model, data, q, frame, pin.LOCAL_WORLD_ALIGNED)
        arm = (robot.groups.left_arm, robot.groups.right_arm)[hand]
        np.testing.assert_allclose(found[hand], full[:, 6 + arm], atol=1e-12)


def test_a_motion_that_is_kept_is_written_over(robot: RobotModel) -> None:
    kinematics, kept = HandKinematics(robot), unwritten_motion()
    for seed in (24, 25):
        q, v = random_state(robot, seed)
        assert kinematics.motion(q, v, kept) is kept
        for found, expected in zip(kept, kinematics.motion(q, v), strict=True):
            np.testing.assert_array_equal(found, expected)
