"""The state of the body against finite differences: what moves how fast, and with which momentum."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from gait_bench import robot, standing_configuration

from follower_humanoid.robot.body_state import BodyState

DT = 1e-6


def test_velocities_and_momentum_belong_to_the_motion() -> None:
    rng = np.random.default_rng(1)
    model, q, v = robot().pin_model, standing_configuration(), rng.normal(0.0, 0.5, 51)
    now, later = BodyState(robot()), BodyState(robot())
    now.update(q, v)
    later.update(pin.integrate(model, q, DT * v), v)
    np.testing.assert_allclose((later.com - now.com) / DT, now.com_velocity, atol=1e-5)
    momentum = pin.computeCentroidalMomentum(model, model.createData(), q, v)
    np.testing.assert_allclose(now.angular_momentum, momentum.angular, atol=1e-12)
    np.testing.assert_allclose(robot().mass * now.com_velocity, momentum.linear, atol=1e-9)
    for name in ("l_sole", "r_gripper", "base_link"):
        frame = robot().frame_id(name)
        before, after = now.frames[frame], later.frames[frame]
        np.testing.assert_allclose((after[3] - before[3]) / DT, now.twist(frame)[:3], atol=1e-5)
        turn = pin.log3(after[:3].T @ before[:3])
        np.testing.assert_allclose(turn / DT, now.twist(frame)[3:], atol=1e-5)
    base = robot().frame_id("base_link")
    np.testing.assert_array_equal(now.base, now.frames[base])
    np.testing.assert_allclose(now.angular_velocity, now.twist(base)[3:], atol=1e-12)
