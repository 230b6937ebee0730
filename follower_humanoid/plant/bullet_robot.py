"""The robot's body inside PyBullet: loading without PyBullet's traps, state in and out, forces in."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter
from struct import Struct

import numpy as np
import pinocchio as pin
import pybullet

from follower_humanoid.core.kernel import kernel
from follower_humanoid.core.samples import Array
from follower_humanoid.plant.spatial import cross
from follower_humanoid.plant.world import World
from follower_humanoid.robot.model import BASE_DOF, Indices

# Pinocchio's joint 1 is the free-flyer; joint n > 1 is actuated joint n − 2.
FIRST_ACTUATED = 2
Triple = tuple[float, float, float]
# Bullet's names for kinds of bodies, in its collision filter.
_DYNAMIC, _STATIC = 1, 2
# Of what PyBullet says about a joint.
_ANGLE, _RATE = itemgetter(0), itemgetter(1)


@kernel(
    "boolean(UniTuple(float64, 3), UniTuple(float64, 4), UniTuple(float64, 3), UniTuple(float64, 3), "
    "float64[::1], float64[::1], float64[::1], float64[::1], float64[:,::1], float64[:,::1])"
)
def base_state(
    position: Triple, quat: tuple[float, ...], linear: Triple, spin: Triple, center: Array, turn: Array,
    q: Array, v: Array, rotation: Array, base: Array,
) -> bool:  # fmt: skip
    """State of base_link from that of its centre of mass and principal axes.

    Answers whether all of v is finite.

    R = R_axes R_turn;  x = x_c − R c;  ẋ = ẋ_c − ω × R c;  the twist in base axes is (Rᵀ ẋ, Rᵀ ω).

    Args:
        position, quat: Pose of centre and principal axes in world; (x, y, z, w).
        linear, spin: ẋ_c and ω, in world.
        center: c, in base_link, (3,).
        turn: Quaternion of R_turn, base_link to principal axes, (4,).
        q, v: Configuration and velocity, of which the base's rows are written.
        rotation, base: Written: R, and ẋ and ω in world, (2, 3).
    """
    x, y, z, w = quat
    i, j, k, r = turn
    q[3] = w * i + x * r + y * k - z * j
    q[4] = w * j + y * r + z * i - x * k
    q[5] = w * k + z * r + x * j - y * i
    q[6] = w * r - x * i - y * j - z * k
    x, y, z, w = q[3], q[4], q[5], q[6]
    rotation[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    rotation[0, 1] = 2.0 * (x * y - z * w)
    rotation[0, 2] = 2.0 * (x * z + y * w)
    rotation[1, 0] = 2.0 * (x * y + z * w)
    rotation[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    rotation[1, 2] = 2.0 * (y * z - x * w)
    rotation[2, 0] = 2.0 * (x * z - y * w)
    rotation[2, 1] = 2.0 * (y * z + x * w)
    rotation[2, 2] = 1.0 - 2.0 * (x * x + y * y)
    for axis in range(3):
        base[0, axis], base[1, axis], q[axis] = linear[axis], spin[axis], position[axis]
    for axis in range(3):
        # The centre's place relative to base_link, in world.
        arm = rotation[axis, 0] * center[0] + rotation[axis, 1] * center[1] + rotation[axis, 2] * center[2]
        q[axis] -= arm
        after, last = (axis + 1) % 3, (axis + 2) % 3
        # Its share of −ω × arm: along the two other axes.
        base[0, after] -= spin[last] * arm
        base[0, last] += spin[after] * arm
    for axis in range(3):
        v[axis] = v[3 + axis] = 0.0
        for row in range(3):
            v[axis] += rotation[row, axis] * base[0, row]
            v[3 + axis] += rotation[row, axis] * base[1, row]
    total = 0.0
    for rate in v:
        total += rate
    return math.isfinite(total)


class BulletRobot:
    """A floating base with 45 torque-driven joints.

    Attributes:
        body: PyBullet's body id.
        link_names: Names of PyBullet's links; −1 is the base.
        q, v: Configuration (52,) and velocity (51,), as in `RobotModel`; renewed in place by `read`.
        rotation: Base to world, shape (3, 3).
        base_twist: Velocity of the base_link origin [m/s] and angular velocity [rad/s], in world axes, shape
            (2, 3); a new array, like `rotation`, whenever the state is renewed.
        reads: How often the state was renewed.
        finite: False once a velocity is not finite.
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
        for link in range(count):
            # Links pass through each other, but Bullet would list every two that are near, and sort the list.
            pybullet.setCollisionFilterGroupMask(self.body, link, _DYNAMIC, _STATIC, physicsClientId=client)
        # Bullet's default velocity motors would hold the joints.
        pybullet.setJointMotorControlArray(
            self.body, self._driven, pybullet.VELOCITY_CONTROL, forces=[0.0] * len(self._driven),
            physicsClientId=client,
        )  # fmt: skip
        info = pybullet.getDynamicsInfo(self.body, -1, physicsClientId=client)
        # Bullet's base pose is the frame of the base's centre of mass and principal axes.
        self.center_in_base = np.array(info[3])
        self._principal_axes = pin.Quaternion(np.array(info[4]))
        self._to_base: Array = self._principal_axes.conjugate().coeffs().copy()
        self.q, self.v = np.zeros(7 + len(joint_names)), np.zeros(BASE_DOF + len(joint_names))
        # Where `read` puts angles and rates: where they belong, if all joints are driven.
        self._all_driven = driven is None
        self._angles, self._rates = self.q[7:], self.v[BASE_DOF:]
        if not self._all_driven:
            self._angles, self._rates = np.zeros((2, len(self._driven)))
        self._numbers = Struct(f"{len(self._driven)}d")
        self.rotation, self.base_twist = np.eye(3), np.zeros((2, 3))
        self.reads, self.finite = 0, True
        self.read()

    @property
    def base_velocity(self) -> Array:
        """Of the base_link origin, in world axes, shape (3,) [m/s]."""
        velocity: Array = self.base_twist[0]
        return velocity

    def place(self, q: Array, v: Array) -> None:
        """Sets configuration and velocity, shapes (52,) and (51,)."""
        rotation = pin.Quaternion(q[3:7]).toRotationMatrix()
        spin = rotation @ v[3:6]
        center = rotation @ self.center_in_base
        quat = pin.Quaternion(rotation @ self._principal_axes.toRotationMatrix()).coeffs()
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
        self._numbers.pack_into(self._angles.data, 0, *map(_ANGLE, states))
        self._numbers.pack_into(self._rates.data, 0, *map(_RATE, states))
        if not self._all_driven:
            self.q[7:][self._rows], self.v[BASE_DOF:][self._rows] = self._angles, self._rates
        self.rotation, self.base_twist = np.empty((3, 3)), np.empty((2, 3))
        self.reads += 1
        self.finite = base_state(
            position, quat, linear, spin, self.center_in_base, self._to_base,
            self.q, self.v, self.rotation, self.base_twist,
        )  # fmt: skip

    def dof_order(self) -> Indices:
        """Where each of the 45 joints stands among PyBullet's own degrees of freedom."""
        return np.argsort(np.argsort(self._joints))

    def drive(self, torque: Array) -> None:
        """Joint torques of the next step, shape (45,) [N·m]."""
        pybullet.setJointMotorControlArray(
            self.body, self._driven, pybullet.TORQUE_CONTROL, forces=torque[self._rows].tolist(),
            physicsClientId=self._client,
        )  # fmt: skip

    def push(self, link: int, force: Sequence[float], place: Sequence[float]) -> None:
        """A force [N] during the next step on one of PyBullet's links, at a place, in world."""
        pybullet.applyExternalForce(self.body, link, force, place, pybullet.WORLD_FRAME, self._client)

    def support(self, links: list[int], forces: list[list[float]], places: list[list[float]]) -> None:
        """What the ground does during the next step: upward forces [N] on links, at places, in world."""
        body, client, push, frame = self.body, self._client, pybullet.applyExternalForce, pybullet.WORLD_FRAME
        for link, force, place in zip(links, forces, places, strict=True):
            if force[2] > 0.0:
                push(body, link, force, place, frame, client)

    def twist(self, link: int, torque: Sequence[float]) -> None:
        """A torque [N·m] during the next step on one of PyBullet's links, in world."""
        if any(torque):
            pybullet.applyExternalTorque(self.body, link, torque, pybullet.WORLD_FRAME, self._client)

    def link(self, joint: int) -> int:
        """PyBullet's link behind a joint of Pinocchio."""
        return -1 if joint < FIRST_ACTUATED else self._joints[joint - FIRST_ACTUATED]
