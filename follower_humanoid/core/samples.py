"""What flows between the nodes, free of ROS: one frozen sample type per kind of message.

Arrays are float64 and never written to after a sample is made. SI units. Frames and order of
entries are fixed per topic in `follower_humanoid.core.topics`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Joints:
    """Joint values in the order of the topic's joint list.

    Attributes:
        position: Shape (n,) [rad].
        velocity: Shape (n,) [rad/s].
        effort: Shape (n,) [N·m]; motor voltage [V] on command topics; zeros on references.
    """

    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class Odometry:
    """Pose of `base_link` in `world`, twist in `base_link` axes at the `base_link` origin.

    Attributes:
        position: Shape (3,), in world [m].
        quat_xyzw: Shape (4,), rotation from base_link to world.
        linear_velocity: Shape (3,), in base_link [m/s].
        angular_velocity: Shape (3,), in base_link [rad/s].
    """

    position: Array
    quat_xyzw: Array
    linear_velocity: Array
    angular_velocity: Array


@dataclass(frozen=True, slots=True)
class Inertial:
    """Pelvis IMU, at and in `base_link`.

    Attributes:
        quat_xyzw: Shape (4,), rotation from base_link to world.
        angular_velocity: Shape (3,) [rad/s].
        linear_acceleration: Shape (3,), specific force: at rest +g along world z [m/s²].
    """

    quat_xyzw: Array
    angular_velocity: Array
    linear_acceleration: Array


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force and moment; point of reference and axes are fixed per topic.

    Attributes:
        force: Shape (3,) [N].
        torque: Shape (3,) [N·m].
        frame: Axes named by the message where a topic leaves the choice to people
            (`leader/*`, `base/push`); empty: the topic's frame.
    """

    force: Array
    torque: Array
    frame: str = ""


@dataclass(frozen=True, slots=True)
class Point:
    """A point in `world`: shape (3,) [m]."""

    xyz: Array

    @classmethod
    def on_ground(cls, place: Array) -> Point:
        """What is over the ground, shape (≥ 2,) [m]."""
        xyz = np.zeros(3)
        xyz[:2] = place[:2]
        return cls(xyz)


@dataclass(frozen=True, slots=True)
class Polygon:
    """Vertices in `world`, counter-clockwise seen from above: shape (n, 3) [m]."""

    vertices: Array


@dataclass(frozen=True, slots=True)
class Gait:
    """The walking parameters (paper, section RAMP): factors of the nominal and angles.

    Attributes:
        walk_speed: Factor of the nominal speed; 0 = stand, feet together.
        walk_dir: Direction of travel in world [rad].
        step_length: Factor of the nominal half-step length.
        step_height: Factor of the nominal swing height.
        heading: Pelvis yaw in world [rad].
    """

    walk_speed: float
    walk_dir: float
    step_length: float
    step_height: float
    heading: float


class Side(Enum):
    """Which leg, arm, foot or hand."""

    LEFT = "left"
    RIGHT = "right"

    # A member is the only one of its kind: no need to hash its name at every look into a dictionary.
    __hash__ = object.__hash__

    @property
    def prefix(self) -> str:
        """Prefix of frame and joint names: `l` or `r`."""
        return self.value[0]

    @property
    def sign(self) -> float:
        """+1 for left, −1 for right: the side's direction along y."""
        return 1.0 if self is Side.LEFT else -1.0

    @property
    def other(self) -> Side:
        """The opposite side."""
        return Side.RIGHT if self is Side.LEFT else Side.LEFT


SIDES = (Side.LEFT, Side.RIGHT)


@dataclass(frozen=True, slots=True)
class Footstep:
    """A sole pose on the ground, planned or taken.

    Attributes:
        side: Which foot.
        position: Sole origin in world, shape (3,) [m].
        yaw: Heading of the foot in world [rad].
        taken: True once the foot stood there.
        counted: False for a step that only brings the feet together.
    """

    side: Side
    position: Array
    yaw: float
    taken: bool
    counted: bool = True


@dataclass(frozen=True, slots=True)
class Footsteps:
    """The latest taken and the planned steps, in the order of walking."""

    steps: tuple[Footstep, ...]


@dataclass(frozen=True, slots=True)
class PrimitiveStates:
    """Active motion primitives and how far each has come (0…1)."""

    names: tuple[str, ...]
    completion: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ContactPlan:
    """Which feet are meant to carry the robot.

    Attributes:
        left, right: Planned share of the weight, 0…1; 0 = the foot is meant to be in the air.
    """

    left: float
    right: float


Sample = (
    Joints | Odometry | Inertial | Wrench | Point | Polygon | Gait | Footsteps | PrimitiveStates | ContactPlan
)
