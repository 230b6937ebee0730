"""The state at time 0: static equilibrium in a standing, object-carrying posture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.robot.model import BASE_DOF, GRAVITY, RobotModel

# What may be left of force and moment at time 0, as a share of the weight (· 1 m).
BALANCED = 1e-10


@dataclass(frozen=True)
class StandingConfig:
    """Posture at time 0: feet parallel below the hips, trunk upright, forearms forward."""

    hip_height: float = parameter(0.84, "height of the hips above ground", "m", 0.5, 1.0)
    com_ahead: float = parameter(0.03, "centre of mass ahead of the ankles", "m", -0.04, 0.09)
    shoulder_pitch: float = parameter(0.0, "shoulder pitch, 0 = upper arm hangs", "rad", -1.5, 1.0)
    elbow: float = parameter(-1.5, "elbow angle, 0 = straight", "rad", -2.4, 0.0)


@dataclass(frozen=True)
class Standing:
    """Static equilibrium.

    Attributes:
        configuration: q, shape (52,).
        torque: Joint torques that hold it, shape (45,) [N·m].
        point_forces: Vertical contact forces left then right, shape (12,) [N].
    """

    configuration: Array
    torque: Array
    point_forces: Array


class _Stance:
    """Newton's method for the posture, given where the soles are."""

    def __init__(self, robot: RobotModel, model: pin.Model, config: StandingConfig) -> None:
        self.robot, self.model, self.config = robot, model, config
        self.data = model.createData()
        self.soles = [robot.frame_id(f"{side.prefix}_sole") for side in SIDES]
        self.hips = [int(robot.groups.leg(side)[0]) for side in SIDES]
        self.points = [robot.frame_id(f"{side.prefix}_contact_{n}") for side in SIDES for n in range(1, 7)]
        # The toe keeps its zero; hip yaw to ankle roll place the foot.
        legs = np.concatenate([robot.groups.leg(side)[:6] for side in SIDES]) + BASE_DOF
        self.columns = np.concatenate((np.arange(3), legs))

    def first_guess(self) -> Array:
        q: Array = pin.neutral(self.model)
        joints = q[7:]
        names = self.robot.joint_names
        for prefix in "lr":
            for name, value in (("hip_pitch", -0.4), ("knee", 0.8), ("ankle_pitch", -0.4)):
                joints[names.index(f"{prefix}_{name}")] = value
            joints[names.index(f"{prefix}_shoulder_pitch")] = self.config.shoulder_pitch
            joints[names.index(f"{prefix}_elbow")] = self.config.elbow
        q[2] = self.config.hip_height
        return q

    def residual(self, q: Array, sink: float, pitch: float) -> Array:
        """Soles (position, orientation) × 2, CoM x and y, hip height: shape (15,)."""
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        center = pin.centerOfMass(self.model, self.data, q)
        wanted = pin.utils.rotate("y", pitch)
        rows = []
        for sole, hip in zip(self.soles, self.hips, strict=True):
            pose = self.data.oMf[sole]
            side_y = self.model.jointPlacements[hip + 2].translation[1]
            rows += [np.array([0.0, side_y, -sink]) - pose.translation, pin.log3(wanted @ pose.rotation.T)]
        hip_height = float(np.mean([self.data.oMi[hip + 2].translation[2] for hip in self.hips]))
        lower = self.config.hip_height - hip_height
        rows.append(np.array([self.config.com_ahead - center[0], -center[1], lower]))
        return np.concatenate(rows)

    def jacobian(self, q: Array) -> Array:
        com = pin.jacobianCenterOfMass(self.model, self.data, q)
        rows = [
            pin.getFrameJacobian(self.model, self.data, sole, pin.LOCAL_WORLD_ALIGNED) for sole in self.soles
        ]
        height = np.zeros((1, self.model.nv))
        height[0, 2] = 1.0
        full: Array = np.vstack((*rows, com[:2], height))
        return full[:, self.columns]

    def solve(self, q: Array, sink: float, pitch: float) -> Array:
        for _ in range(30):
            error = self.residual(q, sink, pitch)
            if np.abs(error).max() < 1e-13:
                break
            step = np.zeros(self.model.nv)
            if not np.isfinite(error).all():  # no solver can help it, and some of them raise
                break
            step[self.columns] = np.linalg.lstsq(self.jacobian(q), error, rcond=None)[0]
            q = pin.integrate(self.model, q, step)
        if not np.abs(self.residual(q, sink, pitch)).max() < 1e-9:
            raise ConfigurationError(
                f"standing.hip_height = {self.config.hip_height} with standing.com_ahead = "
                f"{self.config.com_ahead}: the legs cannot reach the ground so"
            )
        return q


def standing(robot: RobotModel, model: pin.Model, config: StandingConfig, stiffness: float) -> Standing:
    """Posture in which sunken soles carry the weight and motors hold the rest.

    The soles lie flat up to the tilt that their springs need: with all points below ground, depth
    and tilt follow from vertical force and moment about the CoM (Newton's method, two unknowns).

    Args:
        robot: Names and groups.
        model: Pinocchio model of the plant's own body.
        config: Wanted posture.
        stiffness: Of one contact point [N/m].

    Raises:
        ConfigurationError: No such posture, or not inside the joint ranges.
    """
    stance = _Stance(robot, model, config)
    mass = sum(inertia.mass for inertia in model.inertias)
    q = stance.first_guess()
    sink, pitch = mass * GRAVITY / (len(stance.points) * stiffness), 0.0
    forces = np.zeros(len(stance.points))
    for _ in range(50):
        q = stance.solve(q, sink, pitch)
        points = np.array([stance.data.oMf[frame].translation for frame in stance.points])
        center = stance.data.com[0]
        forces = stiffness * np.maximum(0.0, -points[:, 2])
        arm = points[:, 0] - center[0]
        missing = np.array([mass * GRAVITY - forces.sum(), forces @ arm])
        if np.abs(missing).max() < BALANCED * mass * GRAVITY:
            break
        # d(depth) = d(sink) + x d(pitch), x about the sole origin, which is about the ankle.
        weight, x = stiffness * (forces > 0.0), points[:, 0]
        slope = np.array([[weight.sum(), weight @ x], [-weight @ arm, -weight @ (arm * x)]])
        if not abs(np.linalg.det(slope)) > 0.0:  # no point carries, or all of them in one line
            raise ConfigurationError(f"standing.com_ahead = {config.com_ahead}: the soles cannot carry it so")
        change = np.linalg.solve(slope, missing)
        sink, pitch = sink + change[0], pitch + change[1]
    else:
        raise ConfigurationError(f"standing.com_ahead = {config.com_ahead}: no equilibrium on the soles")
    _check_ranges(robot, q[7:])
    torque = pin.rnea(model, stance.data, q, np.zeros(model.nv), np.zeros(model.nv))
    pin.computeJointJacobians(model, stance.data, q)
    for frame, force in zip(stance.points, forces, strict=True):
        jacobian = pin.getFrameJacobian(model, stance.data, frame, pin.LOCAL_WORLD_ALIGNED)
        torque = torque - jacobian[2] * force
    return Standing(configuration=q, torque=torque[BASE_DOF:].copy(), point_forces=forces)


def _check_ranges(robot: RobotModel, position: Array) -> None:
    outside = (position < robot.lower) | (position > robot.upper)
    if outside.any():
        joint = int(np.flatnonzero(outside)[0])
        raise ConfigurationError(
            f"standing posture puts {robot.joint_names[joint]} at {position[joint]:.3f} rad; "
            f"valid: {robot.lower[joint]:.3f} to {robot.upper[joint]:.3f}"
        )
