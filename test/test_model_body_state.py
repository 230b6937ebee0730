"""The state of the body against finite differences: what moves how fast, and with which momentum."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from gait_bench import robot, standing_configuration

from follower_humanoid.robot.body_state import BodyState

DT = 1e-6
MOVING = ("l_sole", "r_gripper", "base_link")


def test_velocities_and_momentum_belong_to_the_motion() -> None:
    rng = np.random.default_rng(1)
    model, q, v = robot().pin_model, standing_configuration(), rng.normal(0.0, 0.5, 51)
    now, later = BodyState(robot(), MOVING), BodyState(robot(), MOVING)
    now.update(q, v)
    later.update(pin.integrate(model, q, DT * v), v)
    np.testing.assert_allclose((later.com - now.com) / DT, now.com_velocity, atol=1e-5)
    momentum = pin.computeCentroidalMomentum(model, model.createData(), q, v)
    np.testing.assert_allclose(now.angular_momentum, momentum.angular, atol=1e-12)
    np.testing.assert_allclose(robot().mass * now.com_velocity, momentum.linear, atol=1e-9)
    for name, twist in zip(MOVING, now.twists, strict=True):
        frame = robot().frame_id(name)
        before, after = now.frames[frame], later.frames[frame]
        np.testing.assert_allclose((after[3] - before[3]) / DT, twist[0], atol=1e-5)
        turn = pin.log3(after[:3].T @ before[:3])
        np.testing.assert_allclose(turn / DT, twist[1], atol=1e-5)
    base = robot().frame_id("base_link")
    np.testing.assert_array_equal(now.base, now.frames[base])
    np.testing.assert_allclose(now.base_twist, now.twists[-1], atol=1e-12)


def test_twists_are_those_of_pinocchio() -> None:
    rng = np.random.default_rng(2)
    model, state, axes = robot().pin_model, BodyState(robot(), MOVING), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    data = model.createData()
    for _ in range(50):
        v = rng.normal(0.0, 1.0, 51)
        q = pin.integrate(model, standing_configuration(), rng.normal(0.0, 0.5, 51))
        state.update(q, v)
        pin.forwardKinematics(model, data, q, v)
        for name, twist in zip(MOVING, state.twists, strict=True):
            expected = pin.getFrameVelocity(model, data, robot().frame_id(name), axes)
            np.testing.assert_allclose(twist, np.reshape(expected.vector, (2, 3)), atol=1e-13)
