"""One PyBullet server in this process: what is asked of it while a world is made, and seldom afterwards.

What every physics step asks is in `bullet_kernels`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

from follower_humanoid.errors import ConfigurationError, PhysicsError
from follower_humanoid.plant.bullet_library import library

BASE = -1  # Bullet's index of a body's base among its links
_INERTIA_FROM_FILE = 2  # URDF_USE_INERTIA_FROM_FILE
_VELOCITY_CONTROL = 0
# struct b3JointInfo begins with two names of this length; type, place in q and place in v follow.
_NAME = 1024
_JOINT_INFO = 1 << 13  # bytes, more than it has


@dataclass(frozen=True)
class Joint:
    """A joint of a body, and the link behind it, which has the same index.

    Attributes:
        name, link: Their names.
        position, rate: Where it stands among Bullet's positions, of which the base has seven, and velocities,
            of which it has six; negative for a fixed joint.
    """

    name: str
    link: str
    position: int
    rate: int


class BulletClient:
    """A server and the connection to it.

    Attributes:
        handle: For kernels; 0 once it is closed.
    """

    def __init__(self) -> None:
        """Starts a server.

        Raises:
            ConfigurationError: That is not possible in this process.
        """
        self._bullet = library()
        self.handle: int = self._bullet.b3ConnectPhysicsDirect() or 0
        if not self.handle or not self._bullet.b3CanSubmitCommand(self.handle):
            self.close()
            raise ConfigurationError("no PyBullet server could be started in this process")

    def close(self) -> None:
        """Ends the server; closing twice is harmless."""
        if self.handle:
            self._bullet.b3DisconnectSharedMemory(self.handle)
            self.handle = 0

    def set_engine(self, step: float, gravity: Sequence[float]) -> None:
        """Physics step [s] and gravity [m/s²]; one step is one of the engine, all runs are the same."""
        bullet, command = self._bullet, self._bullet.b3InitPhysicsParamCommand(self._server)
        bullet.b3PhysicsParamSetTimeStep(command, step)
        bullet.b3PhysicsParamSetNumSolverIterations(command, 50)
        bullet.b3PhysicsParamSetNumSubSteps(command, 0)
        bullet.b3PhysicsParameterSetDeterministicOverlappingPairs(command, 1)
        bullet.b3PhysicsParamSetEnableFileCaching(command, 0)
        bullet.b3PhysicsParamSetGravity(command, *gravity)
        self._submit(command)

    def add_ground(self) -> int:
        """The plane z = 0; returns its body."""
        bullet = self._bullet
        command = bullet.b3CreateCollisionShapeCommandInit(self._server)
        bullet.b3CreateCollisionShapeAddPlane(command, _doubles(0.0, 0.0, 1.0), 0.0)
        shape = bullet.b3GetStatusCollisionShapeUniqueId(self._submit(command))
        command = bullet.b3CreateMultiBodyCommandInit(self._server)
        nowhere, unturned = _doubles(0.0, 0.0, 0.0), _doubles(0.0, 0.0, 0.0, 1.0)
        bullet.b3CreateMultiBodyBase(command, 0.0, shape, -1, nowhere, unturned, nowhere, unturned)
        body = int(bullet.b3GetStatusBodyIndex(self._submit(command)))
        if shape < 0 or body < 0:
            raise PhysicsError("PyBullet makes no ground")
        return body

    def load(self, path: str, fixed: bool) -> int:
        """Loads a URDF file; returns its body, negative where Bullet cannot read it."""
        bullet, command = self._bullet, self._bullet.b3LoadUrdfCommandInit(self._server, path.encode())
        bullet.b3LoadUrdfCommandSetFlags(command, _INERTIA_FROM_FILE)
        if fixed:
            bullet.b3LoadUrdfCommandSetUseFixedBase(command, 1)
        return int(bullet.b3GetStatusBodyIndex(self._submit(command)))

    def joints(self, body: int) -> list[Joint]:
        """All joints of a body, in Bullet's order."""
        found = []
        info = ctypes.create_string_buffer(_JOINT_INFO)
        for index in range(self._bullet.b3GetNumJoints(self._server, body)):
            self._bullet.b3GetJointInfo(self._server, body, index, info)
            link, name = (info.raw[at : at + _NAME].partition(b"\0")[0].decode() for at in (0, _NAME))
            _, position, rate = (ctypes.c_int * 3).from_buffer(info, 2 * _NAME)
            found.append(Joint(name, link, position, rate))
        return found

    def set_contact(self, body: int, link: int, friction: float) -> None:
        """Coulomb friction of a link, which does not bounce; that of a contact is both links' product.

        On its own: in one command with what `undamp` sets, Bullet 3.2.7 leaves a link's friction at 0.5.
        """
        bullet, command = self._bullet, self._bullet.b3InitChangeDynamicsInfo(self._server)
        bullet.b3ChangeDynamicsInfoSetLateralFriction(command, body, link, friction)
        bullet.b3ChangeDynamicsInfoSetRestitution(command, body, link, 0.0)
        self._submit(command)

    def undamp(self, body: int, link: int) -> None:
        """Takes away what Bullet brakes on its own account: its default damping of 0.04 is phantom drag."""
        bullet, command = self._bullet, self._bullet.b3InitChangeDynamicsInfo(self._server)
        bullet.b3ChangeDynamicsInfoSetLinearDamping(command, body, 0.0)
        bullet.b3ChangeDynamicsInfoSetAngularDamping(command, body, 0.0)
        bullet.b3ChangeDynamicsInfoSetJointDamping(command, body, link, 0.0)
        bullet.b3ChangeDynamicsInfoSetMaxJointVelocity(command, body, 1e4)
        self._submit(command)

    def set_filter(self, body: int, link: int, group: int, others: int) -> None:
        """Says to which groups of links one belongs, and which it can touch: a bit for each group."""
        command = self._bullet.b3CollisionFilterCommandInit(self._server)
        self._bullet.b3SetCollisionFilterGroupMask(command, body, link, group, others)
        self._submit(command)

    def release(self, body: int, rates: Sequence[int]) -> None:
        """Switches off the motors that Bullet gives joints. Args: whose; the joints' places in v."""
        bullet = self._bullet
        command = bullet.b3JointControlCommandInit2(self._server, body, _VELOCITY_CONTROL)
        for rate in rates:
            bullet.b3JointControlSetDesiredVelocity(command, rate, 0.0)
            bullet.b3JointControlSetMaximumForce(command, rate, 0.0)
        self._submit(command)

    def place_base(self, body: int, position: Sequence[float], quat: Sequence[float]) -> None:
        """Puts centre of mass [m] and principal axes (x, y, z, w) of the base, in world."""
        command = self._bullet.b3CreatePoseCommandInit(self._server, body)
        self._bullet.b3CreatePoseCommandSetBasePosition(command, *position)
        self._bullet.b3CreatePoseCommandSetBaseOrientation(command, *quat)
        self._submit(command)

    def move_base(self, body: int, linear: Sequence[float], spin: Sequence[float]) -> None:
        """Sets velocity [m/s] and angular velocity [rad/s] of the base's centre of mass, in world."""
        command = self._bullet.b3CreatePoseCommandInit(self._server, body)
        self._bullet.b3CreatePoseCommandSetBaseLinearVelocity(command, _doubles(*linear))
        self._bullet.b3CreatePoseCommandSetBaseAngularVelocity(command, _doubles(*spin))
        self._submit(command)

    def set_joint(self, body: int, joint: int, angle: float, rate: float) -> None:
        """Sets angle [rad] and velocity [rad/s] of the joint with that index."""
        command = self._bullet.b3CreatePoseCommandInit(self._server, body)
        self._bullet.b3CreatePoseCommandSetJointPosition(self._server, command, joint, angle)
        self._bullet.b3CreatePoseCommandSetJointVelocity(self._server, command, joint, rate)
        self._submit(command)

    def state_sizes(self, body: int) -> tuple[int, int, list[float]]:
        """How many positions and velocities, and the base's inertial frame in base_link.

        That is the centre of mass [m] and the principal axes' quaternion (x, y, z, w).
        """
        command = self._bullet.b3RequestActualStateCommandInit(self._server, body)
        status = self._submit(command)
        whose, positions, rates = (ctypes.c_int() for _ in range(3))
        frame, *others = (ctypes.POINTER(ctypes.c_double)() for _ in range(4))
        told = [ctypes.byref(value) for value in (whose, positions, rates, frame, *others)]
        if not self._bullet.b3GetStatusActualState(status, *told):
            raise PhysicsError(f"PyBullet has no body {body}")
        return positions.value, rates.value, frame[:7]

    def _submit(self, command: int) -> int:
        status = self._bullet.b3SubmitClientCommandAndWaitStatus(self._server, command)
        expect_taken(bool(status))
        return int(status)

    @property
    def _server(self) -> int:
        if not self.handle:
            raise PhysicsError("the PyBullet server does not answer: it is closed")
        return self.handle


def _doubles(*values: float) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * len(values))(*values)


def expect_taken(taken: bool, otherwise: str = "") -> None:
    """Raises `PhysicsError` where Bullet has not taken a command. Args: what else can be the reason."""
    if not taken:
        raise PhysicsError(f"the PyBullet server does not answer{otherwise}")
