"""Says where the left hand shall go, tick by tick."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from follower_humanoid.arm_experiment.target_points import Leading, TargetPlanner
from follower_humanoid.arm_experiment.tasks import ArmTaskConfig
from follower_humanoid.control.hand_task import HandKinematics
from follower_humanoid.core.samples import Inertial, Joints, Odometry
from follower_humanoid.robot.model import RobotModel

_LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


class ArmTaskInputs(NamedTuple):
    """State of this tick; where the base is does not matter to a hand's place on it."""

    joints: Joints
    imu: Inertial


class ArmTaskOutputs(NamedTuple):
    """Where the gripper shall be when this is used, relative to base_link in pelvis-yaw axes."""

    left_target: Odometry


class ArmTask:
    """Component: measured state in, target of the left hand out."""

    Config = ArmTaskConfig
    Inputs = ArmTaskInputs
    Outputs = ArmTaskOutputs

    def __init__(self, config: ArmTaskConfig, robot: RobotModel, period: float) -> None:
        self._config, self._robot, self._period = config, robot, period
        self._kinematics = HandKinematics(robot)
        self._planner: TargetPlanner | None = None

    def step(self, inputs: ArmTaskInputs, time: float) -> ArmTaskOutputs:
        """The target of the next tick, which is when the arm controller reads it."""
        body = Odometry(np.zeros(3), inputs.imu.quat_xyzw, np.zeros(3), inputs.imu.angular_velocity)
        hands = self._kinematics.motion(*self._robot.state(body, inputs.joints))
        place, rate = hands.place[0].copy(), hands.place_rate[0]
        if self._planner is None:
            config = self._config
            leading = Leading(config.leash, config.rest_speed, config.rest_time)
            self._planner = TargetPlanner(place, config.points(place), leading, self._period)
        planned, velocity = self._planner.step(place, math.sqrt(rate @ rate))
        return ArmTaskOutputs(Odometry(planned, _LEVEL, velocity, np.zeros(3)))

    def diagnostics(self) -> dict[str, bool]:
        """What the node reports."""
        planner = self._planner
        return {"led": planner is not None and planner.led, "done": planner is not None and planner.done}
