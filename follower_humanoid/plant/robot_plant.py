"""One robot in the world: PyBullet's body, driven by the implicit step of motors, soles and stops.

Per physics step h, with M, n at the current state and A, D of the motors:

    (M + A + hD + Σ Jᵀ c J) q̈ = τ_u − n − D q̇ + τ_ext + Σ Jᵀ f

gives the accelerations that the contact forces and motor torques of this very step must fit.
PyBullet then gets the contact forces at their points and the torques τ_u − A q̈ − D (q̇ + h q̈).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pybullet

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.errors import PhysicsError
from follower_humanoid.plant.motors import MotorConfig, Motors
from follower_humanoid.plant.plant_urdf import BodyErrorConfig, bullet_body, plant_body
from follower_humanoid.plant.soles import Sole, SoleConfig
from follower_humanoid.plant.standing import Standing, StandingConfig, standing
from follower_humanoid.plant.stops import StopConfig, Stops
from follower_humanoid.plant.world import World
from follower_humanoid.robot.model import BASE_DOF, RobotModel

# Solving again when points change between sticking, slipping and lifting; then forces are clipped.
MAX_PASSES = 4


@dataclass(frozen=True)
class PushedFrame:
    """A place where people may pull: its Pinocchio frame and joint, and PyBullet's link."""

    frame: int
    joint: int
    link: int


class RobotPlant:
    """State and forces of one robot.

    Attributes:
        model: Pinocchio model of the plant's own body (its masses, not the controllers').
        q, v: Configuration (52,) and velocity (51,), as in `RobotModel`.
        rotation: Base to world, shape (3, 3).
        base_velocity: Of the base_link origin, in world axes, shape (3,) [m/s].
        base_acceleration: Mean over the last step, of the base_link origin, in world, (3,) [m/s²].
        acceleration: Solution of the last step, shape (51,).
        effort: Eq. (13)'s torque of the last step, shape (45,) [N·m].
        time: Simulated time [s].
    """

    def __init__(
        self, world: World, robot: RobotModel, motors: MotorConfig, soles: SoleConfig, stops: StopConfig,
        posture: StandingConfig, errors: BodyErrorConfig,
    ) -> None:  # fmt: skip
        """Puts the robot into the world, standing."""
        self.world, self.robot = world, robot
        self._step = world.step_length
        urdf = plant_body(robot.urdf, errors)
        self.model: pin.Model = pin.buildModelFromXML(urdf, pin.JointModelFreeFlyer())
        self.motors = Motors(motors, robot, self._step)
        self.model.armature = np.concatenate(
            (np.zeros(BASE_DOF), self.motors.inertia + self._step * self.motors.damping)
        )
        self.data = self.model.createData()
        self._posture, self._stiffness = posture, soles.stiffness
        self.soles = [Sole(soles, robot, side, world.ground, self._step) for side in SIDES]
        self.stops = Stops(stops, robot.lower, robot.upper, self._step)
        self.body = world.load(bullet_body(urdf))
        self._prepare_bullet()
        self._mass_matrix: Array = self.data.M
        self._world_jacobian: Array = self.data.J
        self._support = {frame: self._support_of(frame) for frame in ("base_link", "l_gripper", "r_gripper")}
        self.q, self.v = np.zeros(7 + len(robot.joint_names)), np.zeros(BASE_DOF + len(robot.joint_names))
        self.rotation = np.eye(3)
        self.acceleration = np.zeros_like(self.v)
        self.base_velocity, self.base_acceleration = np.zeros(3), np.zeros(3)
        self.effort = np.zeros(len(robot.joint_names))
        self.time = 0.0
        self._pulls: list[tuple[PushedFrame, Array, Array, Array]] = []
        self.stand()

    def _prepare_bullet(self) -> None:
        client = self.world.client
        count = pybullet.getNumJoints(self.body, physicsClientId=client)
        infos = [pybullet.getJointInfo(self.body, n, physicsClientId=client) for n in range(count)]
        names = [info[1].decode() for info in infos]
        self.bullet_joints = [names.index(name) for name in self.robot.joint_names]
        self.link_names = {-1: "base_link"} | {n: info[12].decode() for n, info in enumerate(infos)}
        for link in range(-1, count):
            # Bullet's default damping of 0.04 is phantom drag; friction is the ground's times 1.
            pybullet.changeDynamics(
                self.body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0,
                maxJointVelocity=1e4, lateralFriction=self.world.ground.friction, restitution=0.0,
                physicsClientId=client,
            )  # fmt: skip
        pybullet.setJointMotorControlArray(
            self.body, self.bullet_joints, pybullet.VELOCITY_CONTROL, forces=[0.0] * count,
            physicsClientId=client,
        )  # fmt: skip
        info = pybullet.getDynamicsInfo(self.body, -1, physicsClientId=client)
        # Bullet's base pose is the frame of the base's centre of mass and principal axes.
        self._center_in_base = np.array(info[3])
        self._principal_axes = pin.Quaternion(np.array(info[4])).toRotationMatrix()
        self._aligned = bool(np.array_equal(self._principal_axes, np.eye(3)))

    def _support_of(self, frame: str) -> tuple[PushedFrame, Array]:
        index = self.robot.frame_id(frame)
        joint = int(self.model.frames[index].parentJoint)
        # Joint 1 is the free-flyer; joint n > 1 is actuated joint n − 2.
        link = -1 if joint == 1 else self.bullet_joints[joint - 2]
        mask = np.zeros(self.model.nv)
        mask[:BASE_DOF] = 1.0
        for support in self.model.supports[joint]:
            if support > 1:
                mask[BASE_DOF + support - 2] = 1.0
        return PushedFrame(index, joint, link), mask

    def stand(self) -> Standing:
        """Puts the robot into static equilibrium at the world's origin."""
        state = standing(self.robot, self.model, self._posture, self._stiffness)
        self.place(state.configuration, np.zeros(self.model.nv))
        pin.computeJointJacobians(self.model, self.data, self.q)
        self.motors.hold(state.torque)
        self.effort = state.torque.copy()
        self.acceleration = np.zeros_like(self.v)
        self.base_acceleration = np.zeros(3)
        forces = state.point_forces.reshape(2, -1)
        for sole, normal in zip(self.soles, forces, strict=True):
            sole.settle(self.data, normal)
        return state

    def place(self, q: Array, v: Array) -> None:
        """Sets configuration and velocity, shapes (52,) and (51,); motors and soles are left alone."""
        client = self.world.client
        rotation = pin.Quaternion(q[3:7]).toRotationMatrix()
        spin = rotation @ v[3:6]
        center = rotation @ self._center_in_base
        quat = pin.Quaternion(rotation @ self._principal_axes).coeffs()
        pybullet.resetBasePositionAndOrientation(
            self.body, (q[:3] + center).tolist(), quat.tolist(), physicsClientId=client
        )
        linear = rotation @ v[:3] + np.cross(spin, center)
        pybullet.resetBaseVelocity(self.body, linear.tolist(), spin.tolist(), physicsClientId=client)
        for joint, angle, rate in zip(self.bullet_joints, q[7:], v[6:], strict=True):
            pybullet.resetJointState(self.body, joint, float(angle), float(rate), physicsClientId=client)
        self._read_state()

    def _read_state(self) -> None:
        client = self.world.client
        position, quat = pybullet.getBasePositionAndOrientation(self.body, client)
        linear, spin = pybullet.getBaseVelocity(self.body, client)
        states = pybullet.getJointStates(self.body, self.bullet_joints, client)
        q, v = self.q, self.v
        q[7:] = [state[0] for state in states]
        v[6:] = [state[1] for state in states]
        q[3:7] = quat
        rotation = pin.Quaternion(q[3:7]).toRotationMatrix()
        if not self._aligned:
            rotation = rotation @ self._principal_axes.T
            q[3:7] = pin.Quaternion(rotation).coeffs()
        self.rotation = rotation
        back = -(rotation @ self._center_in_base)
        q[:3] = position
        q[:3] += back
        self.base_velocity = np.array(
            (
                linear[0] + spin[1] * back[2] - spin[2] * back[1],
                linear[1] + spin[2] * back[0] - spin[0] * back[2],
                linear[2] + spin[0] * back[1] - spin[1] * back[0],
            )
        )
        v[:3] = self.base_velocity @ rotation
        v[3:6] = np.array(spin) @ rotation

    def frame_rotation(self, frame: int) -> Array:
        """Rotation from a Pinocchio frame to world at the current state, shape (3, 3)."""
        pin.forwardKinematics(self.model, self.data, self.q)
        info = self.model.frames[frame]
        rotation: Array = self.data.oMi[info.parentJoint].rotation @ info.placement.rotation
        return rotation

    def gripper_arm(self, frame: str) -> Array:
        """Origin of a pulled frame in the axes of its joint, shape (3,) [m]."""
        arm: Array = self.model.frames[self._support[frame][0].frame].placement.translation
        return arm

    def pull(self, frame: str, force: Array, torque: Array) -> None:
        """Applies a wrench during the next physics step, at the origin of a frame, in world axes.

        Args:
            frame: `base_link`, `l_gripper` or `r_gripper`.
            force: Shape (3,) [N].
            torque: Shape (3,) about the frame's origin [N·m].
        """
        pushed, mask = self._support[frame]
        self._pulls.append((pushed, mask, force, torque))

    def step(self, voltage: Array) -> None:
        """One physics step under the motor voltages, shape (45,) [V].

        Raises:
            PhysicsError: The state left the finite numbers.
        """
        h, model, data, q, v = self._step, self.model, self.data, self.q, self.v
        rate = v[BASE_DOF:]
        pin.computeJointJacobians(model, data, q)
        self.motors.begin(voltage)
        free = -pin.nonLinearEffects(model, data, q, v)
        free[BASE_DOF:] += self.motors.drive
        free[BASE_DOF:] -= self.motors.damping * rate
        places = self._add_pulls(free)
        on_stop = self.stops.begin(q[7:], rate)
        standing_on = [sole for sole in self.soles if sole.begin(data, self._world_jacobian, v)]
        for _ in range(MAX_PASSES):
            # Includes rotor inertia and implicit damping as the model's armature.
            pin.crba(model, data, q)
            right_side = free.copy()
            for sole in standing_on:
                sole.add_to(self._mass_matrix, right_side)
            if on_stop:
                self.stops.add_to(self._mass_matrix, right_side)
            # Contact adds only entries between a link and its ancestors: the tree's sparsity stays.
            pin.cholesky.decompose(model, data)
            qdd: Array = pin.cholesky.solve(model, data, right_side)
            settled = [sole.finish(qdd) for sole in standing_on]
            if on_stop:
                settled.append(self.stops.finish(qdd[BASE_DOF:]))
            if all(settled):
                break
        end_rate = rate + h * qdd[BASE_DOF:]
        self.effort = self.motors.finish(qdd[BASE_DOF:], end_rate)
        self.acceleration = qdd
        self._apply(standing_on, places)
        old_velocity = self.base_velocity
        self.world.step()
        self.time += h
        self._read_state()
        self.base_acceleration = (self.base_velocity - old_velocity) / h
        self._check_finite()

    def _add_pulls(self, forces: Array) -> list[tuple[int, Array, Array, Array]]:
        """Adds the people's wrenches to the generalised forces; returns link, place, force, torque."""
        places = []
        for pushed, mask, force, torque in self._pulls:
            pose = self.data.oMi[pushed.joint] * self.model.frames[pushed.frame].placement
            place = np.array(pose.translation)
            twist_dual = np.concatenate((force, np.cross(place, force) + torque))
            forces += mask * (twist_dual @ self._world_jacobian)
            places.append((pushed.link, place, force, torque))
        self._pulls.clear()
        return places

    def _apply(self, soles: Sequence[Sole], places: list[tuple[int, Array, Array, Array]]) -> None:
        client, body = self.world.client, self.body
        torque = self.effort + self.stops.torque if self.stops.active else self.effort
        pybullet.setJointMotorControlArray(
            body, self.bullet_joints, pybullet.TORQUE_CONTROL, forces=torque.tolist(), physicsClientId=client
        )
        for sole in soles:
            sole.commit()
            forces, points = sole.force.tolist(), sole.points.tolist()
            for joint, force, point in zip(sole.joints, forces, points, strict=True):
                if force[2] > 0.0:
                    link = self.bullet_joints[joint - 2]
                    pybullet.applyExternalForce(body, link, force, point, pybullet.WORLD_FRAME, client)
        for link, place, force, torque in places:
            pybullet.applyExternalForce(
                body, link, force.tolist(), place.tolist(), pybullet.WORLD_FRAME, client
            )
            if torque.any():
                pybullet.applyExternalTorque(body, link, torque.tolist(), pybullet.WORLD_FRAME, client)

    def _check_finite(self) -> None:
        if np.isfinite(self.v @ self.v):
            return
        names = [f"base_link {axis}" for axis in ("x", "y", "z", "roll", "pitch", "yaw")]
        names += self.robot.joint_names
        bad = [name for name, rate in zip(names, self.v, strict=True) if not np.isfinite(rate)]
        raise PhysicsError(f"physics left the finite numbers at {self.time:.3f} s, first in: {', '.join(bad[:5])}")
