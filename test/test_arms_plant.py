"""Arms and wrench sensing on the real plant, inside the whole chain."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.control.hand_task import HandKinematics
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.sensing.low_pass import LowPass

MILLIMETRE = 1e-3
# Deaf to the pull: the robot stands while its hands are tested.
STANDING = {"gait_mapping": {"start_force": 50.0}}


def shifts(run: Run) -> np.ndarray:
    """Hands relative to their first places, pelvis-yaw axes, shape (T, 2, 3)."""
    robot = RobotModel()
    kinematics = HandKinematics(robot)
    joints, odometry = run["joint_states"], run["odom"]
    places = [
        kinematics.motion(np.concatenate(row), np.zeros(51)).place
        for row in zip(odometry.position, odometry.quat_xyzw, joints.position, strict=True)
    ]
    return np.array(places) - places[0]


@pytest.fixture(scope="module")
def pulled(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Standing: 5 N forward on the left hand, 10 N down on the right."""
    path = tmp_path_factory.mktemp("programme") / "pull.yaml"
    path.write_text("- {until: 60, left: [5, 0, 0], right: [0, 0, -10]}\n")
    return simulate(str(path), 5.2, STANDING)


def test_hand_gives_way_to_5_newton_and_returns_while_the_force_stays(pulled: Run) -> None:
    shift, time = shifts(pulled), pulled["joint_states"].times
    left = np.linalg.norm(shift[:, 0], axis=1)
    assert left[time <= 1.0].max() >= 20 * MILLIMETRE
    assert left[time >= 5.0].max() <= 5 * MILLIMETRE
    assert pulled["left_hand/applied"].force[-1] == pytest.approx([5, 0, 0])


def test_hand_is_stiff_under_10_newton_down(pulled: Run) -> None:
    assert np.linalg.norm(shifts(pulled)[:, 1], axis=1).max() <= 5 * MILLIMETRE


def test_no_arm_motor_saturates(pulled: Run) -> None:
    assert np.abs(pulled["arms/command"].effort).max() < 10.0


def test_sensing_is_right_while_walking() -> None:
    """Issue limits: 0.2 N rms per axis, 0.05 N after the mapping's own filter."""
    run = simulate("fig4", 6.0)
    assert np.linalg.norm(run["odom"].position[-1, :2]) > 0.3, "it walks"
    low_pass = LowPass(0.1, 0.01)
    settled = run["odom"].times > 0.5
    total = np.zeros((len(settled), 3))
    for side in ("left", "right"):
        error = run[f"{side}_hand/wrench"].force - run[f"{side}_hand/applied"].force
        assert np.sqrt((error[settled] ** 2).mean(axis=0)).max() < 0.2
        total += error
    filtered = np.array([low_pass.step(row) for row in total[settled][::5]])
    assert np.sqrt((filtered[:, :2] ** 2).mean(axis=0)).max() < 0.05
