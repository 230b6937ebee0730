"""The robot's body inside PyBullet: loading without PyBullet's traps, state in and out, forces in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import pybullet

from follower_humanoid.core.samples import Array
from follower_humanoid.plant.spatial import cross
from follower_humanoid.plant.world import World
from follower_humanoid.robot.model import BASE_DOF, Indices

# Pinocchio's joint 1 is the free-flyer; joint n > 1 is actuated joint n − 2.
FIRST_ACTUATED = 2


class BulletRobot:
    """A floating base with 45 torque-driven joints.

    Attributes:
        body: PyBullet's body id.
        link_names: Names of PyBullet's links; −1 is the base.
        q, v: Configuration (52,) and velocity (51,), as in `RobotModel`; renewed in place by `read`.
        rotation: Base to world, shape (3, 3).
        base_velocity: Of the base_link origin, in world axes, shape (3,) [m/s].
        base_spin: Of the base, in world axes, shape (3,) [rad/s].
        center_in_base: The base link's own centre of mass in base_link, shape (3,) [m].
    """

    def __init__(
        self, world: World, urdf: str, joint_names: tuple[str, ...], driven: Indices | None = None
    ) -> None:
        """Loads the URDF text.

        Args:
            world: Where to.
            urdf: The body as `bullet_body` makes it.
            joint_names: Order of the 45 joints.
            driven: The joints that move; then the base is fixed to the world. All, by default.
        """
        self._client = client = world.client
        self.body = world.load(urdf, fixed=driven is not None)
        count = pybullet.getNumJoints(self.body, physicsClientId=client)
        infos = [pybullet.getJointInfo(self.body, n, physicsClientId=client) for n in range(count)]
        names = [info[1].decode() for info in infos]
        self._joints = [names.index(name) for name in joint_names]
        self._driven = self._joints if driven is None else [self._joints[n] for n in driven]
        self._rows: slice | Indices = slice(None) if driven is None else driven
        self.link_names = {-1: "base_link"} | {n: info[12].decode() for n, info in enumerate(infos)}
        for link in range(-1, count):
            # Bullet's default damping of 0.04 is phantom drag. Friction is the product of both bodies'.
            pybullet.changeDynamics(
                self.body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0,
                maxJointVelocity=1e4, lateralFriction=world.ground.friction, restitution=0.0,
                physicsClientId=client,
            )  # fmt: skip
        # Bullet's default velocity motors would hold the joints.
        pybullet.setJointMotorControlArray(
            self.body, self._driven, pybullet.VELOCITY_CONTROL, forces=[0.0] * len(self._driven),
            physicsClientId=client,
        )  # fmt: skip
        info = pybullet.getDynamicsInfo(self.body, -1, physicsClientId=client)
        # Bullet's base pose is the frame of the base's centre of mass and principal axes.
        self.center_in_base = np.array(info[3])
        self._principal_axes = pin.Quaternion(np.array(info[4])).toRotationMatrix()
        self._aligned = bool(np.array_equal(self._principal_axes, np.eye(3)))
        self.q, self.v = np.zeros(7 + len(joint_names)), np.zeros(BASE_DOF + len(joint_names))
        self.rotation, self.base_velocity, self.base_spin = np.eye(3), np.zeros(3), np.zeros(3)
        self.read()

    def place(self, q: Array, v: Array) -> None:
        """Sets configuration and velocity, shapes (52,) and (51,)."""
        rotation = pin.Quaternion(q[3:7]).toRotationMatrix()
        spin = rotation @ v[3:6]
        center = rotation @ self.center_in_base
        quat = pin.Quaternion(rotation @ self._principal_axes).coeffs()
        pybullet.resetBasePositionAndOrientation(
            self.body, (q[:3] + center).tolist(), quat.tolist(), physicsClientId=self._client
        )
        linear = rotation @ v[:3] + cross(spin, center)
        pybullet.resetBaseVelocity(self.body, linear.tolist(), spin.tolist(), physicsClientId=self._client)
        self.q[7:] = q[7:]
        angles, rates = q[7:][self._rows], v[BASE_DOF:][self._rows]
        for joint, angle, rate in zip(self._driven, angles, rates, strict=True):
            pybullet.resetJointState(
                self.body, joint, float(angle), float(rate), physicsClientId=self._client
            )
        self.read()

    def read(self) -> None:
        """Renews q, v, rotation and base velocity from PyBullet."""
        # External forces are placed relative to link poses that Bullet leaves one step old; asking for
        # forward kinematics of any link renews them all. Else a swinging hand feels N·mm out of nothing.
        pybullet.getLinkState(
            self.body, 0, computeForwardKinematics=True, physicsClientId=self._client
        )
        position, quat = pybullet.getBasePositionAndOrientation(self.body, self._client)
        linear, spin = pybullet.getBaseVelocity(self.body, self._client)
        states = pybullet.getJointStates(self.body, self._driven, self._client)
        q, v = self.q, self.v
        q[7:][self._rows] = [state[0] for state in states]
        v[BASE_DOF:][self._rows] = [state[1] for state in states]
        q[3:7] = quat
        rotation: Array = pin.Quaternion(q[3:7]).toRotationMatrix()
        if not self._aligned:
            rotation = rotation @ self._principal_axes.T
            q[3:7] = pin.Quaternion(rotation).coeffs()
        self.rotation = rotation
        center = rotation @ self.center_in_base
        q[:3] = position
        q[:3] -= center
        self.base_spin = np.array(spin)
        self.base_velocity = np.array(linear) - cross(self.base_spin, center)
        v[:3] = self.base_velocity @ rotation
        v[3:6] = self.base_spin @ rotation

    def dof_order(self) -> Indices:
        """Where each of the 45 joints stands among PyBullet's own degrees of freedom."""
        return np.argsort(np.argsort(self._joints))

    def drive(self, torque: Array) -> None:
        """Joint torques of the next step, shape (45,) [N·m]."""
        pybullet.setJointMotorControlArray(
            self.body, self._driven, pybullet.TORQUE_CONTROL, forces=torque[self._rows].tolist(),
            physicsClientId=self._client,
        )  # fmt: skip

    def push(self, joint: int, force: Sequence[float], place: Sequence[float]) -> None:
        """A force [N] during the next step on the link behind Pinocchio's joint, at a place, in world."""
        pybullet.applyExternalForce(
            self.body, self._link(joint), force, place, pybullet.WORLD_FRAME, self._client
        )

    def twist(self, joint: int, torque: Sequence[float]) -> None:
        """A torque [N·m] during the next step on the link behind Pinocchio's joint, in world."""
        if any(torque):
            pybullet.applyExternalTorque(
                self.body, self._link(joint), torque, pybullet.WORLD_FRAME, self._client
            )

    def _link(self, joint: int) -> int:
        return -1 if joint < FIRST_ACTUATED else self._joints[joint - FIRST_ACTUATED]
