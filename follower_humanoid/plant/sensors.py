"""What the robot's sensors say: means over the control tick, in each sensor's frame, with errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Inertial, Joints, Odometry, Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant.pulls import Pull, add_in_joint
from follower_humanoid.plant.robot_plant import RobotPlant
from follower_humanoid.plant.sensor_sums import add_step, mean_wrenches
from follower_humanoid.robot.model import BASE_DOF

_ZERO = (0.0, 0.0, 0.0)


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
    left_wrist_bias: tuple[float, float, float] = parameter(
        _ZERO, "left wrist force bias", "N", -100.0, 100.0
    )
    right_wrist_bias: tuple[float, float, float] = parameter(
        _ZERO, "right wrist force bias", "N", -100.0, 100.0
    )
    gyro_noise: float = parameter(0.0, "gyroscope noise", "rad/s", 0.0, 10.0)
    gyro_bias: tuple[float, float, float] = parameter(_ZERO, "gyroscope bias", "rad/s", -1.0, 1.0)
    accelerometer_noise: float = parameter(0.0, "accelerometer noise", "m/s²", 0.0, 100.0)
    accelerometer_bias: tuple[float, float, float] = parameter(
        _ZERO, "accelerometer bias", "m/s²", -10.0, 10.0
    )
    odometry_position_noise: float = parameter(0.0, "base position noise", "m", 0.0, 1.0)
    odometry_velocity_noise: float = parameter(0.0, "base velocity noise", "m/s", 0.0, 1.0)


class Readings(NamedTuple):
    """All sensors at one tick."""

    joints: Joints
    odometry: Odometry
    imu: Inertial
    left_foot: Wrench
    right_foot: Wrench
    left_wrist: Wrench
    right_wrist: Wrench


class _Soles:
    """Where the soles' frames are fixed, left first.

    Attributes:
        joints: Pinocchio joints that carry them, (2,).
        axes, offsets: Rotations (2, 3, 3) and origins (2, 3) in their joints' frames.
    """

    def __init__(self, plant: RobotPlant) -> None:
        frames = [plant.model.frames[plant.robot.frame_id(f"{side.prefix}_sole")] for side in SIDES]
        self.joints = np.array([frame.parentJoint for frame in frames])
        self.axes = np.array([frame.placement.rotation for frame in frames])
        self.offsets = np.array([frame.placement.translation for frame in frames])


class _Wrists:
    """The joints that the wrists' sensors measure at, and the hands behind them, left first.

    Attributes:
        joints: Their Pinocchio ids, (2,).
        hand_of: Joint → which hand, 0 or 1.
        poses: Of the joints in world, views that follow the plant, (4, 3) each.
        columns: Columns of the Jacobian that move each, (2, n).
        masses, levers, inertias: Of the hands, in their joints' frames: m (2,), centre (2, 3), about the
            centre (2, 3, 3).
        left_at_rest, right_at_rest: Force through each joint at no acceleration, views that follow the
            plant, (6,) each.
        displaced: Place of each sensor's frame in the joint's, None if they are the same.
    """

    def __init__(self, plant: RobotPlant) -> None:
        model, ids = plant.model, [plant.robot.frame_id(f"{side.prefix}_wrist") for side in SIDES]
        points = [plant.held_point(frame) for frame in ids]
        for joint in (point.joint for point in points):
            if len(model.subtrees[joint]) > 1:
                name = model.names[joint]
                raise ConfigurationError(
                    f"URDF: another joint follows {name}, which must be the last of its arm"
                )
        self.joints = np.array([point.joint for point in points])
        self.hand_of = {point.joint: hand for hand, point in enumerate(points)}
        self.poses: list[Array] = [plant.joint_poses[point.joint] for point in points]
        self.columns = np.array([point.columns for point in points])
        hands = [model.inertias[point.joint] for point in points]
        self.masses = np.array([hand.mass for hand in hands])
        self.levers = np.array([hand.lever for hand in hands])
        self.inertias = np.array([hand.inertia for hand in hands])
        at_rest: list[Array] = [plant.data.f[point.joint].vector for point in points]
        self.left_at_rest, self.right_at_rest = at_rest
        places = [model.frames[frame].placement for frame in ids]
        self.displaced = [None if place.isIdentity() else place for place in places]


class Sensors:
    """Gathers every physics step, reads at the control tick."""

    def __init__(self, config: SensorConfig, plant: RobotPlant) -> None:
        """Sensors of one robot at rest."""
        self._config, self._plant = config, plant
        self._random = np.random.default_rng(config.seed)
        self._soles, self._wrists = _Soles(plant), _Wrists(plant)
        self._foot_sums, self._wrist_sums = np.zeros((2, 6)), np.zeros((2, 6))
        self._specific_force = np.zeros(3)
        self._count = 0
        self._v = plant.v.copy()
        self._rotation, self._base = plant.rotation, plant.bullet.base_twist
        self._acceleration = np.zeros_like(plant.v)
        self._biases = {
            name: np.array(getattr(config, name)) if any(getattr(config, name)) else None
            for name in ("left_wrist_bias", "right_wrist_bias", "gyro_bias", "accelerometer_bias")
        }

    def clear(self) -> None:
        """Starts a control tick."""
        self._foot_sums.fill(0.0)
        self._wrist_sums.fill(0.0)
        self._specific_force.fill(0.0)
        self._count = 0

    def before_step(self) -> None:
        """Remembers the state at which the forces of the coming physics step act."""
        self._v[:] = self._plant.v
        self._rotation, self._base = self._plant.rotation, self._plant.bullet.base_twist

    def after_step(self, pulls: tuple[Pull, ...] = ()) -> None:
        """Adds one physics step and what people did in it."""
        plant, wrists = self._plant, self._wrists
        if plant.soles.touching:
            plant.soles.add_wrenches_to(self._foot_sums)
        # Force through a wrist joint = inertia and weight of the hand less what acts on it.
        add_step(
            self._v, plant.v, self._base, plant.bullet.base_twist, self._rotation, plant.world.ground.gravity,
            plant.world.step_length, plant.joint_poses, plant.world_jacobian, wrists.joints, wrists.columns,
            wrists.left_at_rest, wrists.right_at_rest, wrists.masses, wrists.levers, wrists.inertias,
            self._acceleration, self._specific_force, self._wrist_sums,
        )  # fmt: skip
        for pull in pulls:
            point = plant.held_point(pull.frame)
            hand = wrists.hand_of.get(point.joint)
            if hand is not None:
                total = self._wrist_sums[hand]
                add_in_joint(wrists.poses[hand], point.offset, pull.force, pull.torque, total)
        self._count += 1

    def at_rest(self) -> None:
        """Gathers static equilibrium, for the readings before the first step."""
        self.clear()
        self.before_step()
        self.after_step()  # no step was made: no acceleration

    def read(self) -> Readings:
        """Every sensor at the current tick."""
        plant, config, biases = self._plant, self._config, self._biases
        # Copied in one piece; what is read are parts of the copies.
        q, v = plant.q.copy(), plant.v.copy()
        specific_force = self._specific_force / self._count
        means = self._mean_wrenches()
        left_foot, right_foot = self._read_foot(means[0]), self._read_foot(means[1])
        return Readings(
            joints=Joints(
                self._measured(q[7:], config.position_noise),
                self._measured(v[BASE_DOF:], config.velocity_noise),
                plant.effort,
            ),
            odometry=Odometry(
                self._measured(q[:3], config.odometry_position_noise),
                q[3:7],
                self._measured(v[:3], config.odometry_velocity_noise),
                v[3:6],
            ),
            imu=Inertial(
                q[3:7],
                self._measured(v[3:6], config.gyro_noise, biases["gyro_bias"]),
                self._measured(specific_force, config.accelerometer_noise, biases["accelerometer_bias"]),
            ),
            left_foot=left_foot,
            right_foot=right_foot,
            left_wrist=self._read_wrist(0, means[2], biases["left_wrist_bias"]),
            right_wrist=self._read_wrist(1, means[3], biases["right_wrist_bias"]),
        )

    def _mean_wrenches(self) -> Array:
        """Force and torque of left and right foot, left and right wrist, means of the tick, (4, 2, 3).

        Of the feet, in world, expressed at and in the sole frame of its end: so force and moment balance
        the change of momentum over the tick exactly.
        """
        plant, soles, means = self._plant, self._soles, np.empty((4, 2, 3))
        plant.renew_dynamics()  # the step to come needs it too
        mean_wrenches(
            plant.joint_poses, soles.joints, soles.axes, soles.offsets, self._foot_sums, self._wrist_sums,
            self._count, means,
        )  # fmt: skip
        return means

    def _read_foot(self, mean: Array) -> Wrench:
        config = self._config
        return Wrench(
            self._measured(mean[0], config.foot_force_noise),
            self._measured(mean[1], config.foot_torque_noise),
        )

    def _read_wrist(self, hand: int, mean: Array, bias: Array | None) -> Wrench:
        displaced, config = self._wrists.displaced[hand], self._config
        if displaced is not None:
            mean = displaced.actInv(pin.Force(mean.ravel())).vector.reshape(2, 3)
        return Wrench(
            self._measured(mean[0], config.wrist_force_noise, bias),
            self._measured(mean[1], config.wrist_torque_noise),
        )

    def _measured(self, value: Array, deviation: float, bias: Array | None = None) -> Array:
        if bias is not None:
            value = value + bias
        if deviation > 0.0:
            value = value + self._random.normal(0.0, deviation, value.shape)
        return value
