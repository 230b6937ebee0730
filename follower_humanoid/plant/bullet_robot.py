"""The robot's body inside PyBullet: loading without PyBullet's traps, state in and out, forces in."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import Array
from follower_humanoid.plant import bullet_kernels
from follower_humanoid.plant.bullet_client import BASE, expect_taken
from follower_humanoid.plant.spatial import cross
from follower_humanoid.plant.world import World
from follower_humanoid.robot.model import BASE_DOF, Indices

# Pinocchio's joint 1 is the free-flyer; joint n > 1 is actuated joint n − 2.
FIRST_ACTUATED = 2
# Bullet's names for kinds of bodies, in its collision filter.
_DYNAMIC, _STATIC = 1, 2


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
        joints = client.joints(self.body)
        names = [joint.name for joint in joints]
        self._joints = [names.index(name) for name in joint_names]
        self._all_driven = driven is None
        self._rows: Indices = np.arange(len(joint_names)) if driven is None else driven
        self.link_names = {BASE: "base_link"} | {n: joint.link for n, joint in enumerate(joints)}
        for link in self.link_names:
            client.undamp(self.body, link)
            client.set_contact(self.body, link, world.ground.friction)
            if link != BASE:
                # Links pass through each other, but Bullet would list and sort all that are near each other.
                client.set_filter(self.body, link, _DYNAMIC, _STATIC)
        moving = [joints[self._joints[row]] for row in self._rows]
        places = [(joint.position, joint.rate, row) for joint, row in zip(moving, self._rows, strict=True)]
        self._places = np.array(places, dtype=np.int32)
        self._driven = np.array([joint.rate for joint in moving], dtype=np.int32)
        client.release(self.body, self._driven.tolist())
        positions, rates, frame = client.state_sizes(self.body)
        self._positions, self._rates = np.zeros(positions), np.zeros(rates)
        self._answer = np.zeros(7, dtype=np.int64)
        # Bullet's base pose is the frame of the base's centre of mass and principal axes.
        self.center_in_base = np.array(frame[:3])
        self._principal_axes = pin.Quaternion(np.array(frame[3:]))
        self._to_base: Array = self._principal_axes.conjugate().coeffs().copy()
        self.q, self.v = np.zeros(7 + len(joint_names)), np.zeros(BASE_DOF + len(joint_names))
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
        client, body = self._client, self.body
        client.place_base(body, q[:3] + center, quat)
        client.move_base(body, rotation @ v[:3] + cross(spin, center), spin)
        self.q[7:] = q[7:]
        for row in self._rows:
            client.set_joint(body, self._joints[row], q[7 + row], v[BASE_DOF + row])
        self.read()

    def read(self) -> None:
        """Renews q, v, rotation and base velocity from PyBullet.

        Raises:
            PhysicsError: There is no server any more, or no such body.
        """
        self.rotation, self.base_twist = np.empty((3, 3)), np.empty((2, 3))
        found = bullet_kernels.renew(
            self._client.handle, self.body, self._places, self._answer, self._positions, self._rates,
            self.center_in_base, self._to_base, self.q, self.v, self.rotation, self.base_twist,
        )  # fmt: skip
        expect_taken(found != bullet_kernels.SILENT)
        self.reads += 1
        self.finite = found == bullet_kernels.FINITE

    def drive(self, torque: Array) -> None:
        """Joint torques of the next step, shape (45,) [N·m]."""
        moving = torque if self._all_driven else torque[self._rows]
        self._expect(bullet_kernels.drive(self._client.handle, self.body, self._driven, moving))

    def pull(self, link: int, force: Array, torque: Array, place: Array) -> None:
        """A wrench [N, N·m] during the next step on one of PyBullet's links, at a place [m], in world."""
        self._expect(bullet_kernels.pull(self._client.handle, self.body, link, force, torque, place))

    def support(self, links: bullet_kernels.Ints, forces: Array, places: Array) -> None:
        """What the ground does during the next step: upward forces [N] on links, at places [m], in world.

        Args:
            links: PyBullet's, shape (n,), int32.
            forces, places: Shape (n, 3); forces that point down are none.
        """
        self._expect(bullet_kernels.support(self._client.handle, self.body, links, forces, places))

    @staticmethod
    def _expect(taken: bool) -> None:
        expect_taken(taken, ", or an array has a wrong size")

    def link(self, joint: int) -> int:
        """PyBullet's link behind a joint of Pinocchio."""
        return -1 if joint < FIRST_ACTUATED else self._joints[joint - FIRST_ACTUATED]
