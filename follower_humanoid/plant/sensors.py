"""What the robot's sensors say: means over the control tick, in each sensor's frame, with errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Inertial, Joints, Odometry, Wrench
from follower_humanoid.plant.robot_plant import RobotPlant
from follower_humanoid.robot.model import BASE_DOF, GRAVITY

_VECTOR = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SensorConfig:
    """Sensor errors: noise is the standard deviation per sample, white, seeded."""

    seed: int = parameter(0, "seed of all sensor noise", "", 0, 2**31 - 1)
    position_noise: float = parameter(0.0, "joint position noise", "rad", 0.0, 1.0)
    velocity_noise: float = parameter(0.0, "joint velocity noise", "rad/s", 0.0, 10.0)
    foot_force_noise: float = parameter(0.0, "foot force noise", "N", 0.0, 1e3)
    foot_torque_noise: float = parameter(0.0, "foot moment noise", "N·m", 0.0, 1e3)
    wrist_force_noise: float = parameter(0.0, "wrist force noise", "N", 0.0, 1e3)
    wrist_torque_noise: float = parameter(0.0, "wrist moment noise", "N·m", 0.0, 1e3)
    left_wrist_bias: tuple[float, float, float] = parameter(_VECTOR, "left wrist force bias", "N", -100.0, 100.0)
    right_wrist_bias: tuple[float, float, float] = parameter(_VECTOR, "right wrist force bias", "N", -100.0, 100.0)
    gyro_noise: float = parameter(0.0, "gyroscope noise", "rad/s", 0.0, 10.0)
    gyro_bias: tuple[float, float, float] = parameter(_VECTOR, "gyroscope bias", "rad/s", -1.0, 1.0)
    accelerometer_noise: float = parameter(0.0, "accelerometer noise", "m/s²", 0.0, 100.0)
    accelerometer_bias: tuple[float, float, float] = parameter(_VECTOR, "accelerometer bias", "m/s²", -10.0, 10.0)
    odometry_position_noise: float = parameter(0.0, "base position noise", "m", 0.0, 1.0)
    odometry_velocity_noise: float = parameter(0.0, "base velocity noise", "m/s", 0.0, 1.0)


@dataclass(frozen=True)
class Readings:
    """All sensors at one tick."""

    joints: Joints
    odometry: Odometry
    imu: Inertial
    left_foot: Wrench
    right_foot: Wrench
    left_wrist: Wrench
    right_wrist: Wrench


class Sensors:
    """Gathers every physics step, reads at the control tick."""

    def __init__(self, config: SensorConfig, plant: RobotPlant) -> None:
        """Sensors of one robot at rest."""
        self._config, self._plant = config, plant
        self._random = np.random.default_rng(config.seed)
        self._data = plant.model.createData()
        self._soles = [plant.robot.frame_id(f"{side.prefix}_sole") for side in SIDES]
        wrists = [plant.robot.frame_id(f"{side.prefix}_wrist") for side in SIDES]
        self._wrist_joints = [int(plant.model.frames[frame].parentJoint) for frame in wrists]
        # Sensor axes in the frame of the last wrist joint: the same, unless a URDF says otherwise.
        self._wrist_places = [plant.model.frames[frame].placement for frame in wrists]
        self._feet = np.zeros((2, 6))
        self._wrists = np.zeros((2, 6))
        self._specific_force = np.zeros(3)
        self._count = 0
        self._acceleration = np.zeros(plant.model.nv)
        self._q, self._v = plant.q.copy(), plant.v.copy()

    def clear(self) -> None:
        """Starts a control tick."""
        self._feet.fill(0.0)
        self._wrists.fill(0.0)
        self._specific_force.fill(0.0)
        self._count = 0

    def before_step(self) -> None:
        """Remembers the state at which the forces of the coming physics step act."""
        self._q[:] = self._plant.q
        self._v[:] = self._plant.v

    def after_step(self, hands: tuple[tuple[Array, Array], tuple[Array, Array]], rotation: Array) -> None:
        """Adds one physics step.

        Args:
            hands: Force [N] and moment about the gripper [N·m] that acted, in world, left and right.
            rotation: Base to world at the step's start.
        """
        plant = self._plant
        for row, sole in zip(self._feet, plant.soles, strict=True):
            if sole.touching:
                row += sole.wrench_about_origin()
        lifted = plant.base_acceleration.copy()
        lifted[2] += GRAVITY
        self._specific_force += lifted @ rotation
        pin.rnea(plant.model, self._data, self._q, self._v, plant.acceleration)
        for row, joint, (force, torque), frame in zip(
            self._wrists, self._wrist_joints, hands, ("l_gripper", "r_gripper"), strict=True
        ):
            row -= self._data.f[joint].vector
            if force.any() or torque.any():
                turn = self._data.oMi[joint].rotation
                arm = plant.gripper_arm(frame)
                local = force @ turn
                row[:3] += local
                row[3:] += torque @ turn + np.cross(arm, local)
        self._count += 1

    def at_rest(self) -> None:
        """Readings of static equilibrium, before the first step."""
        self.clear()
        self.before_step()
        zero = (np.zeros(3), np.zeros(3))
        self.after_step((zero, zero), self._plant.rotation)

    def read(self) -> Readings:
        """Every sensor at the current tick."""
        plant, config = self._plant, self._config
        pin.framesForwardKinematics(plant.model, self._data, plant.q)
        share = 1.0 / self._count
        feet = []
        for sole, total in zip(self._soles, self._feet, strict=True):
            pose = self._data.oMf[sole]
            force, moment = total[:3] * share, total[3:] * share
            moment = moment - np.cross(pose.translation, force)
            feet.append(
                Wrench(
                    self._noisy(force @ pose.rotation, config.foot_force_noise),
                    self._noisy(moment @ pose.rotation, config.foot_torque_noise),
                )
            )
        wrists = []
        for total, place, bias in zip(
            self._wrists, self._wrist_places, (config.left_wrist_bias, config.right_wrist_bias), strict=True
        ):
            wrench = place.actInv(pin.Force(total * share))
            wrists.append(
                Wrench(
                    self._noisy(wrench.linear + np.array(bias), config.wrist_force_noise),
                    self._noisy(wrench.angular, config.wrist_torque_noise),
                )
            )
        quat, spin = plant.q[3:7].copy(), plant.v[3:6]
        return Readings(
            joints=Joints(
                self._noisy(plant.q[7:], config.position_noise),
                self._noisy(plant.v[BASE_DOF:], config.velocity_noise),
                plant.effort.copy(),
            ),
            odometry=Odometry(
                self._noisy(plant.q[:3], config.odometry_position_noise),
                quat,
                self._noisy(plant.v[:3], config.odometry_velocity_noise),
                spin.copy(),
            ),
            imu=Inertial(
                quat,
                self._noisy(spin + np.array(config.gyro_bias), config.gyro_noise),
                self._noisy(
                    self._specific_force * share + np.array(config.accelerometer_bias), config.accelerometer_noise
                ),
            ),
            left_foot=feet[0], right_foot=feet[1], left_wrist=wrists[0], right_wrist=wrists[1],
        )  # fmt: skip

    def _noisy(self, value: Array, deviation: float) -> Array:
        if deviation == 0.0:
            return value.copy()
        noisy: Array = value + self._random.normal(0.0, deviation, value.shape)
        return noisy
