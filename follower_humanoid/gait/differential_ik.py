"""Velocity-level inverse kinematics of feet, CoM and pelvis on the reference configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.robot.linear import solve_positive
from follower_humanoid.robot.model import BASE_DOF, RobotModel

LEG_IK_JOINTS = 6  # hip yaw to ankle roll; the toe is a channel of its own


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


@dataclass(frozen=True, slots=True)
class FootTask:
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


@dataclass(frozen=True, slots=True)
class BodyTask:
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
    """

    def __init__(self, robot: RobotModel, config: IkConfig, q: Array) -> None:
        self._model = robot.pin_model
        self._data = self._model.createData()
        self._config = config
        self._soles = {side: robot.frame_id(f"{side.prefix}_sole") for side in SIDES}
        legs = [robot.groups.leg(side)[:LEG_IK_JOINTS] for side in SIDES]
        self._unknowns = np.concatenate((np.arange(BASE_DOF), *(BASE_DOF + leg for leg in legs)))
        self._knees = [BASE_DOF + 1 + robot.joint_index(f"{side.prefix}_knee") for side in SIDES]
        self.q: Array = np.array(q)
        self.v: Array = np.zeros(self._model.nv)
        self._jacobian = np.zeros((18, 18))
        self._rates = np.zeros(18)
        self.update()

    def update(self) -> None:
        """Kinematics of the present reference configuration."""
        pin.computeJointJacobians(self._model, self._data, self.q)
        for frame in self._soles.values():
            pin.updateFramePlacement(self._model, self._data, frame)
        self._com_jacobian = pin.jacobianCenterOfMass(self._model, self._data, False)

    @property
    def com(self) -> Array:
        """CoM of the reference in world, shape (3,) [m]."""
        return np.array(self._data.com[0])

    @property
    def angular_momentum(self) -> Array:
        """Angular momentum of the reference motion about its CoM in world, shape (3,) [kg·m²/s]."""
        return np.array(pin.computeCentroidalMomentum(self._model, self._data, self.q, self.v).angular)

    def sole(self, side: Side) -> pin.SE3:
        """Pose of a sole of the reference in world."""
        return self._data.oMf[self._soles[side]]

    def _damping(self) -> float:
        """λ: small, and growing as a knee comes near its straight, singular posture."""
        config = self._config
        straightest = float(np.min(np.abs(self.q[self._knees])))
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
        config, rates, jacobian = self._config, self._rates, self._jacobian
        v = np.zeros(self._model.nv)
        v[BASE_DOF:] = given
        v[self._unknowns] = 0.0
        for row, side in zip((0, 6), SIDES, strict=True):
            task, now = feet[side], self._data.oMf[self._soles[side]]
            full = pin.getFrameJacobian(
                self._model, self._data, self._soles[side], pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            jacobian[row : row + 6] = full[:, self._unknowns]
            pull = config.foot_gain * (task.position - now.translation)
            rates[row : row + 3] = task.linear_velocity + np.clip(pull, -config.foot_speed, config.foot_speed)
            turn = pin.log3(task.rotation @ now.rotation.T)
            rates[row + 3 : row + 6] = task.angular_velocity + config.foot_gain * turn
            rates[row : row + 6] -= full @ v
        jacobian[12:14] = self._com_jacobian[:2, self._unknowns]
        rates[12:14] = body.com_velocity + config.com_gain * (body.com - self._data.com[0][:2])
        rates[12:14] -= self._com_jacobian[:2] @ v
        # The twist of the base is in base_link axes; rows of the rotation take it to world.
        rotation = self._data.oMi[1].rotation
        jacobian[14:18] = 0.0
        jacobian[14, :3] = rotation[2]
        rates[14] = body.pelvis_height_velocity + config.pelvis_gain * (body.pelvis_height - self.q[2])
        jacobian[15:18, 3:6] = rotation
        turn = pin.log3(body.pelvis_rotation @ rotation.T)
        rates[15:18] = body.pelvis_angular_velocity + config.pelvis_gain * turn
        normal = jacobian @ jacobian.T
        normal[np.diag_indices(18)] += self._damping() ** 2
        v[self._unknowns] = jacobian.T @ solve_positive(normal, rates)
        self.v = v
        self.q = pin.integrate(self._model, self.q, v * dt)
        self.update()
