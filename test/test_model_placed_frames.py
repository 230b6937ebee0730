"""Wrenches at frames of the robot become the generalised forces that Pinocchio's Jacobians say."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from follower_humanoid.robot.model import RobotModel
from follower_humanoid.robot.placed_frames import PlacedFrames

NAMES = ("l_sole", "r_gripper", "gaze", "base_link")


@pytest.mark.parametrize("seed", range(3))
def test_wrenches_do_the_power_that_the_jacobians_say_in_either_axes(seed: int) -> None:
    robot, rng = RobotModel(), np.random.default_rng(seed)
    model, data = robot.pin_model, robot.pin_model.createData()
    frames = PlacedFrames(robot, data, NAMES)
    for _ in range(2):  # the views follow
        q = pin.integrate(model, pin.neutral(model), rng.normal(0, 0.6, model.nv))
        wrenches, before = rng.normal(size=(len(NAMES), 6)), rng.normal(size=model.nv)
        in_frame = rng.random(len(NAMES)) < 0.5
        pin.computeJointJacobians(model, data, q)
        forces = before.copy()
        frames.add_wrenches(wrenches, in_frame, forces)
        expected, fresh = before.copy(), model.createData()
        for name, wrench, local in zip(NAMES, wrenches, in_frame, strict=True):
            axes = pin.LOCAL if local else pin.LOCAL_WORLD_ALIGNED
            expected += pin.computeFrameJacobian(model, fresh, q, robot.frame_id(name), axes).T @ wrench
        np.testing.assert_allclose(forces, expected, atol=1e-12)


def test_only_base_and_joints_on_the_way_move_a_frame() -> None:
    robot = RobotModel()
    data = robot.pin_model.createData()
    frames = PlacedFrames(robot, data, ("r_toe",))
    expected = [*range(6), *(6 + robot.groups.right_leg)]
    np.testing.assert_array_equal(np.flatnonzero(frames.moved_by[0]), expected)


def test_crba_in_world_leaves_what_is_read() -> None:
    robot, rng = RobotModel(), np.random.default_rng(4)
    model = robot.pin_model
    q = pin.integrate(model, pin.neutral(model), rng.normal(0, 0.6, model.nv))
    found = []
    for algorithm in (
        lambda data: pin.computeJointJacobians(model, data, q),
        lambda data: pin.crba(model, data, q, pin.Convention.WORLD),
    ):
        data, forces = model.createData(), np.zeros(model.nv)
        frames = PlacedFrames(robot, data, NAMES)
        algorithm(data)
        frames.add_wrenches(np.ones((len(NAMES), 6)), np.array([True, False, True, False]), forces)
        found.append(forces)
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)
