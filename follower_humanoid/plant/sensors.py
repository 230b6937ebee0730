"""What the robot's sensors say: means over the control tick, in each sensor's frame, with errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Inertial, Joints, Odometry, Wrench
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant.pulls import Pull, add_in_joint
from follower_humanoid.plant.robot_plant import RobotPlant
from follower_humanoid.plant.sensor_sums import add_joint_force, mean_acceleration, seen_from
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


class _SoleFrame:
    """Where a sole's frame is fixed.

    Attributes:
        pose: Of the joint that carries it, a view that follows the plant, (4, 3).
        axes, offset: Rotation (3, 3) and origin (3,) in the joint's frame.
    """

    def __init__(self, plant: RobotPlant, name: str) -> None:
        frame = plant.model.frames[plant.robot.frame_id(name)]
        self.pose: Array = plant.joint_poses[frame.parentJoint]
        self.axes = np.ascontiguousarray(frame.placement.rotation)
        self.offset: Array = frame.placement.translation.copy()


class _WristJoint:
    """The joint that a wrist's sensor measures at, and the hand behind it.

    Attributes:
        joint: Its Pinocchio id.
        pose: Its pose in world, a view that follows the plant, (4, 3).
        columns: Columns of the Jacobian that move it.
        mass, lever, inertia: Of the hand, in the joint's frame: m, centre (3,), about the centre (3, 3).
        force_at_rest: Through the joint at no acceleration, a view that follows the plant, (6,).
        displaced: Place of the sensor's frame in the joint's, None if they are the same.
    """

    def __init__(self, plant: RobotPlant, name: str) -> None:
        frame = plant.model.frames[plant.robot.frame_id(name)]
        point = plant.held_point(plant.robot.frame_id(name))
        self.joint, self.columns = point.joint, point.columns
        self.pose: Array = plant.joint_poses[self.joint]
        if len(plant.model.subtrees[self.joint]) > 1:
            name = plant.model.names[self.joint]
            raise ConfigurationError(f"URDF: another joint follows {name}, which must be the last of its arm")
        hand = plant.model.inertias[self.joint]
        self.mass, self.lever = float(hand.mass), hand.lever.copy()
        self.inertia = np.ascontiguousarray(hand.inertia)
        self.force_at_rest: Array = plant.data.f[self.joint].vector
        self.displaced = None if frame.placement.isIdentity() else frame.placement


class Sensors:
    """Gathers every physics step, reads at the control tick."""

    def __init__(self, config: SensorConfig, plant: RobotPlant) -> None:
        """Sensors of one robot at rest."""
        self._config, self._plant = config, plant
        self._random = np.random.default_rng(config.seed)
        self._soles = [_SoleFrame(plant, f"{side.prefix}_sole") for side in SIDES]
        self._hands = [_WristJoint(plant, f"{side.prefix}_wrist") for side in SIDES]
        self._feet, self._wrists = np.zeros((2, 6)), np.zeros((2, 6))
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
        self._feet.fill(0.0)
        self._wrists.fill(0.0)
        self._specific_force.fill(0.0)
        self._count = 0

    def before_step(self) -> None:
        """Remembers the state at which the forces of the coming physics step act."""
        self._v[:] = self._plant.v
        self._rotation, self._base = self._plant.rotation, self._plant.bullet.base_twist

    def after_step(self, pulls: tuple[Pull, ...] = ()) -> None:
        """Adds one physics step and what people did in it."""
        plant = self._plant
        if plant.soles.touching:
            plant.soles.add_wrenches_to(self._feet)
        mean_acceleration(
            self._v, plant.v, self._base, plant.bullet.base_twist, self._rotation, plant.world.ground.gravity,
            plant.world.step_length, self._acceleration, self._specific_force,
        )  # fmt: skip
        for hand, row in zip(self._hands, self._wrists, strict=True):
            # Force through the wrist joint = inertia and weight of the hand less what acts on it.
            add_joint_force(
                hand.pose, plant.world_jacobian, hand.columns, self._acceleration,
                hand.force_at_rest, hand.mass, hand.lever, hand.inertia, row,
            )  # fmt: skip
            for pull in pulls:
                point = plant.held_point(pull.frame)
                if point.joint == hand.joint:
                    add_in_joint(hand.pose, point.offset, pull.force, pull.torque, row)
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
        left_foot, right_foot = self._read_feet()
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
            left_wrist=self._read_wrist(0, biases["left_wrist_bias"]),
            right_wrist=self._read_wrist(1, biases["right_wrist_bias"]),
        )

    def _read_feet(self) -> list[Wrench]:
        """Mean wrench of the tick in world, expressed at and in the sole frame of its end.

        So force and moment balance the change of momentum over the tick exactly.
        """
        self._plant.renew_dynamics()  # the step to come needs it too
        feet = []
        for sole, total in zip(self._soles, self._feet, strict=True):
            force, torque = np.empty(3), np.empty(3)
            seen_from(sole.pose, sole.axes, sole.offset, total, self._count, force, torque)
            feet.append(
                Wrench(
                    self._measured(force, self._config.foot_force_noise),
                    self._measured(torque, self._config.foot_torque_noise),
                )
            )
        return feet

    def _read_wrist(self, hand: int, bias: Array | None) -> Wrench:
        mean = self._wrists[hand] / self._count
        displaced = self._hands[hand].displaced
        if displaced is not None:
            mean = displaced.actInv(pin.Force(mean)).vector
        return Wrench(
            self._measured(mean[:3], self._config.wrist_force_noise, bias),
            self._measured(mean[3:], self._config.wrist_torque_noise),
        )

    def _measured(self, value: Array, deviation: float, bias: Array | None = None) -> Array:
        if bias is not None:
            value = value + bias
        if deviation > 0.0:
            value = value + self._random.normal(0.0, deviation, value.shape)
        return value
