"""Velocity-level inverse kinematics of feet, CoM and pelvis on the reference configuration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.gait.ik_kernels import solve_velocities, task_rates
from follower_humanoid.robot.model import BASE_DOF, Indices, RobotModel
from follower_humanoid.robot.pose_table import pose_table

LEG_IK_JOINTS = 6  # hip yaw to ankle roll; the toe is a channel of its own
BASE_JOINT = 1  # Pinocchio's joint 0 is the universe


@dataclass(frozen=True)
class IkConfig:
    """Gains of the differential IK."""

    foot_gain: float = parameter(10.0, "pose error feedback of the feet", "1/s", 0, 100)
    com_gain: float = parameter(10.0, "CoM error feedback", "1/s", 0, 100)
    pelvis_gain: float = parameter(10.0, "pelvis height and attitude error feedback", "1/s", 0, 100)
    damping: float = parameter(1e-4, "λ of the damped least squares", "", 1e-6, 1e-1)
    singular_damping: float = parameter(1e-2, "λ with a straight knee", "", 1e-6, 1e-1)
    singular_knee: float = parameter(0.15, "knee angle below which λ grows", "rad", 0, 1)
    foot_speed: float = parameter(0.3, "largest correction speed of a foot", "m/s", 0.01, 2.0)


class FootTask(NamedTuple):
    """Desired sole motion in world.

    Attributes:
        position: Sole origin, shape (3,) [m].
        rotation: Sole to world, shape (3, 3).
        linear_velocity: Shape (3,) [m/s].
        angular_velocity: Shape (3,) [rad/s].
    """

    position: Array
    rotation: Array
    linear_velocity: Array
    angular_velocity: Array


class BodyTask(NamedTuple):
    """Desired CoM and pelvis motion in world.

    Attributes:
        com: Over the ground, shape (2,) [m].
        com_velocity: Shape (2,) [m/s].
        pelvis_height: Of `base_link` [m].
        pelvis_height_velocity: [m/s].
        pelvis_rotation: base_link to world, shape (3, 3).
        pelvis_angular_velocity: Shape (3,) [rad/s].
    """

    com: Array
    com_velocity: Array
    pelvis_height: float
    pelvis_height_velocity: float
    pelvis_rotation: Array
    pelvis_angular_velocity: Array


class DifferentialIk:
    """Finds base and leg velocities that realise feet, CoM and pelvis at once.

    18 equations (feet 2 × 6, CoM x and y, pelvis height, pelvis attitude) for 18 unknowns (base 6,
    legs 2 × 6), damped least squares q̇ = Jᵀ(JJᵀ + λ²I)⁻¹ v; the upper body's motion is given.

    Attributes:
        q: Reference configuration, shape (52,).
        v: Reference velocity, shape (51,).
        soles: Axes and origin of either sole of the reference in world, shape (4, 3), as in `pose_table`.
        base: The same of `base_link`.
    """

    def __init__(self, robot: RobotModel, config: IkConfig, q: Array) -> None:
        self._model = robot.pin_model
        self._data = data = self._model.createData()
        self._config = config
        self._mass = robot.mass
        self._sole_frames = [robot.frame_id(f"{side.prefix}_sole") for side in SIDES]
        self._left_joints, self._right_joints = (self._moving(frame) for frame in self._sole_frames)
        legs = [robot.groups.leg(side)[:LEG_IK_JOINTS] for side in SIDES]
        self._unknowns = np.concatenate((np.arange(BASE_DOF), *(BASE_DOF + leg for leg in legs)))
        self._knees = [BASE_DOF + 1 + robot.joint_index(f"{side.prefix}_knee") for side in SIDES]
        self.q: Array = np.array(q)
        self.v: Array = np.zeros(self._model.nv)
        self._rates = np.zeros(len(self._unknowns))
        # Views of Pinocchio's memory: they follow every update.
        frames = pose_table(data.oMf)
        self.soles = {side: frames[frame] for side, frame in zip(SIDES, self._sole_frames, strict=True)}
        self.base = pose_table(data.oMi)[BASE_JOINT]
        self._com, self._momentum = data.com[0], data.hg.angular
        self._jacobian, self._momentum_matrix = data.J, data.Ag
        self.update()

    def _moving(self, frame: int) -> Indices:
        """Indices into v of all that moves a frame."""
        supports = self._model.supports[self._model.frames[frame].parentJoint]
        spans = ((self._model.idx_vs[joint], self._model.nvs[joint]) for joint in supports if joint > 0)
        return np.concatenate([np.arange(first, first + size) for first, size in spans])

    def update(self) -> None:
        """Kinematics of the present reference configuration, all in one pass."""
        pin.ccrba(self._model, self._data, self.q, self.v)
        for frame in self._sole_frames:
            pin.updateFramePlacement(self._model, self._data, frame)

    @property
    def com(self) -> Array:
        """CoM of the reference in world, shape (3,) [m]."""
        return np.array(self._com)

    @property
    def com_height(self) -> float:
        """Height of that CoM [m]."""
        return float(self._com[2])

    @property
    def angular_momentum(self) -> Array:
        """Angular momentum of the reference motion about its CoM in world, shape (3,) [kg·m²/s]."""
        return np.array(self._momentum)

    def _damping(self) -> float:
        """λ: small, and growing as a knee comes near its straight, singular posture."""
        config = self._config
        left, right = self._knees
        straightest = min(abs(self.q.item(left)), abs(self.q.item(right)))
        near = max(0.0, 1.0 - straightest / max(config.singular_knee, 1e-9))
        return config.damping + near**2 * (config.singular_damping - config.damping)

    def advance(self, feet: dict[Side, FootTask], body: BodyTask, given: Array, dt: float) -> None:
        """One tick: solves for the velocities and integrates the configuration.

        Args:
            feet: Task of either foot.
            body: CoM and pelvis task.
            given: Velocities of all joints, shape (45,) [rad/s]; those of the IK's leg joints are ignored.
            dt: Tick [s].
        """
        config, rates = self._config, self._rates
        left, right = self.soles[Side.LEFT], self.soles[Side.RIGHT]
        task_rates(
            *feet[Side.LEFT], *feet[Side.RIGHT],
            body.com, body.com_velocity, body.pelvis_height, body.pelvis_height_velocity,
            body.pelvis_rotation, body.pelvis_angular_velocity, left, right, self._com, self.base,
            config.foot_gain, config.foot_speed, config.com_gain, config.pelvis_gain, rates,
        )  # fmt: skip
        self.v = np.empty(self._model.nv)
        solve_velocities(
            self._jacobian, self._momentum_matrix, self._mass, left, right, self.base,
            self._left_joints, self._right_joints, self._unknowns, given, rates, self._damping(),
            self.v,
        )  # fmt: skip
        self.q = pin.integrate(self._model, self.q, self.v * dt)
        self.update()
