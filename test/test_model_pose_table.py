"""The tables of poses and velocities are Pinocchio's own memory, read as one array."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from gait_bench import robot

from follower_humanoid.robot.pose_table import pose_table, velocity_table


def test_the_table_follows_frames_and_joints_through_every_update() -> None:
    model = robot().pin_model
    data = model.createData()
    frames, joints = pose_table(data.oMf), pose_table(data.oMi)
    rng = np.random.default_rng(1)
    for _ in range(3):
        q = pin.integrate(model, pin.neutral(model), rng.normal(0.0, 0.5, model.nv))
        pin.framesForwardKinematics(model, data, q)
        for table, poses in ((frames, data.oMf), (joints, data.oMi)):
            assert table.flags.c_contiguous
            assert len(table) == len(poses)
            for row, pose in zip(table, poses, strict=True):
                np.testing.assert_array_equal(row[:3].T, pose.rotation)
                np.testing.assert_array_equal(row[3], pose.translation)


def test_the_table_of_velocities_follows_every_joint() -> None:
    model = robot().pin_model
    data = model.createData()
    table, rng = velocity_table(data.v), np.random.default_rng(2)
    for _ in range(3):
        pin.forwardKinematics(model, data, pin.neutral(model), rng.normal(0.0, 0.5, model.nv))
        assert table.flags.c_contiguous
        assert len(table) == len(data.v)
        for row, velocity in zip(table, data.v, strict=True):
            np.testing.assert_array_equal(row, [velocity.linear, velocity.angular])
