"""The follower's body as one table: segments, joints, ranges, frames.

A 73 kg, 1.75 m adult. Segment masses follow de Leva (1996); 6 + 45 degrees of freedom. Left and
right are written once and mirrored. Axes: x forward, y left, z up, all frames parallel in the zero
posture (standing straight, arms hanging). Lengths [m], masses [kg], angles [rad].
"""

from __future__ import annotations

from dataclasses import dataclass, replace

Vector = tuple[float, float, float]

HIP_HALF_WIDTH = 0.09
THIGH = 0.42
SHANK = 0.41
ANKLE_HEIGHT = 0.08
HEEL, BALL, TOE_TIP = -0.07, 0.12, 0.19
SOLE_HALF_WIDTH = 0.05
UPPER_ARM = 0.30
FOREARM = 0.26
WRIST_TO_GRIPPER = 0.09

# Links between the axes of a multi-axis joint: small, yet heavy enough for the integrator.
CARRIER_MASS = 0.1
CARRIER_INERTIA = 2.0e-4

SKIN, CLOTH, DARK, LIGHT = "skin", "cloth", "dark", "light"


@dataclass(frozen=True)
class Shape:
    """A visual shape in the link frame; lengths [m].

    Attributes:
        kind: `box` (size = edges), `cylinder` (size = radius, length, 0; along z) or
            `sphere` (size = radius, 0, 0).
        solid: True where the shape can touch the ground.
    """

    kind: str
    size: Vector
    center: Vector
    color: str = CLOTH
    solid: bool = False


@dataclass(frozen=True)
class Link:
    """A rigid body with diagonal inertia.

    Attributes:
        mass: [kg].
        center: Centre of mass in the link frame [m].
        inertia: Principal moments about the centre of mass [kg·m²].
    """

    name: str
    mass: float
    center: Vector
    inertia: Vector
    shapes: tuple[Shape, ...] = ()


@dataclass(frozen=True)
class Joint:
    """A revolute joint: child frame placed at `origin` in the parent, turning about `axis`."""

    name: str
    parent: str
    child: str
    origin: Vector
    axis: Vector
    lower: float
    upper: float


@dataclass(frozen=True)
class Frame:
    """A named frame fixed to a link."""

    name: str
    parent: str
    origin: Vector


def box_inertia(mass: float, size: Vector) -> Vector:
    """Principal moments of a solid box with the given edges."""
    x, y, z = (s * s for s in size)
    return (mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12)


def cylinder_inertia(mass: float, radius: float, length: float) -> Vector:
    """Principal moments of a solid cylinder along z."""
    across = mass * (3 * radius**2 + length**2) / 12
    return (across, across, mass * radius**2 / 2)


X: Vector = (1, 0, 0)
Y: Vector = (0, 1, 0)
Z: Vector = (0, 0, 1)


def _carrier(name: str) -> Link:
    return Link(name, CARRIER_MASS, (0, 0, 0), (CARRIER_INERTIA,) * 3)


def _limb(name: str, mass: float, radius: float, length: float, com: float, color: str) -> Link:
    """A limb hanging from its joint along −z."""
    shapes = (
        Shape("cylinder", (radius, length, 0), (0, 0, -length / 2), color, solid=True),
        Shape("sphere", (radius * 1.08, 0, 0), (0, 0, 0), color),
    )
    return Link(name, mass, (0, 0, -com * length), cylinder_inertia(mass, radius, length), shapes)


def _left_leg() -> tuple[list[Link], list[Joint], list[Frame]]:
    foot_length = BALL - HEEL
    foot_box = (foot_length, 2 * SOLE_HALF_WIDTH, 0.05)
    toe_box = (TOE_TIP - BALL, 2 * SOLE_HALF_WIDTH, 0.02)
    links = [
        _carrier("l_hip_yaw_link"),
        _carrier("l_hip_roll_link"),
        _limb("l_thigh", 10.14, 0.065, THIGH, 0.42, DARK),
        _limb("l_shank", 3.06, 0.048, SHANK, 0.44, DARK),
        _carrier("l_ankle_pitch_link"),
        Link(
            "l_ankle", 0.80, (0.03, 0, -0.05), box_inertia(0.80, (foot_length, 0.09, 0.06)),
            (
                Shape("box", foot_box, ((HEEL + BALL) / 2, 0, -ANKLE_HEIGHT + 0.025), LIGHT),
                Shape("sphere", (0.045, 0, 0), (0, 0, -0.01), LIGHT),
            ),
        ),
        Link(
            "l_toe", 0.20, (0.03, 0, 0.005), box_inertia(0.20, (0.07, 0.09, 0.03)),
            (Shape("box", toe_box, ((TOE_TIP - BALL) / 2, 0, 0.005), LIGHT),),
        ),
    ]  # fmt: skip
    toe_height = 0.005
    joints = [
        Joint("l_hip_yaw", "base_link", "l_hip_yaw_link", (0, HIP_HALF_WIDTH, 0), Z, -0.8, 0.8),
        Joint("l_hip_roll", "l_hip_yaw_link", "l_hip_roll_link", (0, 0, 0), X, -0.5, 0.9),
        Joint("l_hip_pitch", "l_hip_roll_link", "l_thigh", (0, 0, 0), Y, -2.1, 0.8),
        Joint("l_knee", "l_thigh", "l_shank", (0, 0, -THIGH), Y, 0.0, 2.5),
        Joint("l_ankle_pitch", "l_shank", "l_ankle_pitch_link", (0, 0, -SHANK), Y, -1.1, 0.9),
        Joint("l_ankle_roll", "l_ankle_pitch_link", "l_ankle", (0, 0, 0), X, -0.6, 0.6),
        Joint("l_toe_pitch", "l_ankle", "l_toe", (BALL, 0, -ANKLE_HEIGHT + toe_height), Y, -1.0, 0.5),
    ]
    frames = [
        Frame("l_sole", "l_ankle", (0, 0, -ANKLE_HEIGHT)),
        Frame("l_contact_1", "l_ankle", (HEEL, SOLE_HALF_WIDTH, -ANKLE_HEIGHT)),
        Frame("l_contact_2", "l_ankle", (HEEL, -SOLE_HALF_WIDTH, -ANKLE_HEIGHT)),
        Frame("l_contact_3", "l_ankle", (BALL, SOLE_HALF_WIDTH, -ANKLE_HEIGHT)),
        Frame("l_contact_4", "l_ankle", (BALL, -SOLE_HALF_WIDTH, -ANKLE_HEIGHT)),
        Frame("l_contact_5", "l_toe", (TOE_TIP - BALL, SOLE_HALF_WIDTH, -toe_height)),
        Frame("l_contact_6", "l_toe", (TOE_TIP - BALL, -SOLE_HALF_WIDTH, -toe_height)),
    ]
    return links, joints, frames


def _left_arm() -> tuple[list[Link], list[Joint], list[Frame]]:
    links = [
        _carrier("l_shoulder_pitch_link"),
        _carrier("l_shoulder_roll_link"),
        _limb("l_upper_arm", 1.78, 0.042, UPPER_ARM, 0.50, CLOTH),
        _limb("l_forearm", 1.08, 0.034, FOREARM, 0.45, SKIN),
        _carrier("l_wrist_yaw_link"),
        _carrier("l_wrist_pitch_link"),
        Link(
            "l_wrist", 0.345, (0, 0, -0.06), box_inertia(0.345, (0.03, 0.08, 0.15)),
            (Shape("box", (0.03, 0.07, 0.14), (0, 0, -0.07), SKIN, solid=True),),
        ),
    ]  # fmt: skip
    joints = [
        Joint("l_shoulder_pitch", "torso", "l_shoulder_pitch_link", (0, 0.19, 0.12), Y, -3.0, 1.0),
        Joint("l_shoulder_roll", "l_shoulder_pitch_link", "l_shoulder_roll_link", (0, 0, 0), X, -0.3, 2.6),
        Joint("l_shoulder_yaw", "l_shoulder_roll_link", "l_upper_arm", (0, 0, 0), Z, -1.5, 1.5),
        Joint("l_elbow", "l_upper_arm", "l_forearm", (0, 0, -UPPER_ARM), Y, -2.5, 0.0),
        Joint("l_wrist_yaw", "l_forearm", "l_wrist_yaw_link", (0, 0, -FOREARM), Z, -1.5, 1.5),
        Joint("l_wrist_pitch", "l_wrist_yaw_link", "l_wrist_pitch_link", (0, 0, 0), Y, -1.2, 1.2),
        Joint("l_wrist_roll", "l_wrist_pitch_link", "l_wrist", (0, 0, 0), X, -0.8, 0.8),
    ]
    frames = [Frame("l_gripper", "l_wrist", (0, 0, -WRIST_TO_GRIPPER))]
    return links, joints, frames


def _trunk() -> tuple[list[Link], list[Joint], list[Frame]]:
    """Pelvis, five vertebral levels of three axes each, neck and head."""
    links = [
        Link(
            "base_link", 7.75, (-0.005, 0, 0.04), box_inertia(7.75, (0.18, 0.30, 0.18)),
            (
                Shape("box", (0.17, 0.27, 0.13), (-0.005, 0, 0.045), DARK, solid=True),
                Shape("sphere", (0.085, 0, 0), (0, 0.075, 0.0), DARK),
                Shape("sphere", (0.085, 0, 0), (0, -0.075, 0.0), DARK),
            ),
        ),
    ]  # fmt: skip
    joints: list[Joint] = []
    # level: link, height above the level below, mass, width, height of its block
    levels = (
        ("spine_1", 0.10, 3.70, 0.26, 0.07),
        ("spine_2", 0.07, 3.75, 0.26, 0.07),
        ("spine_3", 0.07, 3.75, 0.28, 0.07),
        ("spine_4", 0.07, 4.60, 0.30, 0.07),
        ("torso", 0.07, 7.17, 0.33, 0.17),
    )
    below = "base_link"
    for number, (name, rise, mass, width, height) in enumerate(levels, start=1):
        roll, pitch = f"{name}_roll_link", f"{name}_pitch_link"
        block = Shape("box", (0.19, width, height), (0, 0, height / 2), CLOTH, solid=name == "torso")
        links += [
            _carrier(roll),
            _carrier(pitch),
            Link(
                name, mass, (0, 0, height / 2), box_inertia(mass, (0.19, width, max(height, 0.10))), (block,)
            ),
        ]
        joints += [
            Joint(f"spine_{number}_roll", below, roll, (0, 0, rise), X, -0.2, 0.2),
            Joint(f"spine_{number}_pitch", roll, pitch, (0, 0, 0), Y, -0.15, 0.3),
            Joint(f"spine_{number}_yaw", pitch, name, (0, 0, 0), Z, -0.2, 0.2),
        ]
        below = name
    links += [
        _carrier("neck"),
        Link(
            "head", 4.97, (0.01, 0, 0.13), box_inertia(4.97, (0.18, 0.15, 0.23)),
            (
                Shape("cylinder", (0.05, 0.10, 0), (0, 0, 0.03), SKIN),
                Shape("sphere", (0.105, 0, 0), (0.01, 0, 0.155), SKIN, solid=True),
                Shape("box", (0.06, 0.15, 0.04), (0.09, 0, 0.17), DARK),  # where it looks
            ),
        ),
    ]  # fmt: skip
    joints += [
        Joint("neck_yaw", "torso", "neck", (0, 0, 0.19), Z, -1.2, 1.2),
        Joint("neck_pitch", "neck", "head", (0, 0, 0), Y, -0.7, 0.9),
    ]
    return links, joints, [Frame("gaze", "head", (0.10, 0, 0.15))]


def _mirrored_name(name: str) -> str:
    return "r_" + name[2:] if name.startswith("l_") else name


def _flip(vector: Vector) -> Vector:
    return (vector[0], -vector[1] + 0.0, vector[2])


def _mirrored(
    links: list[Link], joints: list[Joint], frames: list[Frame]
) -> tuple[list[Link], list[Joint], list[Frame]]:
    """The right limb: y of every place changes sign; roll and yaw turn the other way.

    The axes stay as they are, so roll and yaw ranges swap their ends.
    """

    def flipped_range(joint: Joint) -> tuple[float, float]:
        return (joint.lower, joint.upper) if joint.axis == Y else (-joint.upper, -joint.lower)

    right_links = [
        replace(
            link, name=_mirrored_name(link.name), center=_flip(link.center),
            shapes=tuple(replace(s, center=_flip(s.center)) for s in link.shapes),
        )
        for link in links
    ]  # fmt: skip
    right_joints = [
        replace(
            joint, name=_mirrored_name(joint.name), parent=_mirrored_name(joint.parent),
            child=_mirrored_name(joint.child), origin=_flip(joint.origin),
            lower=flipped_range(joint)[0], upper=flipped_range(joint)[1],
        )
        for joint in joints
    ]  # fmt: skip
    right_frames = [Frame(_mirrored_name(f.name), _mirrored_name(f.parent), _flip(f.origin)) for f in frames]
    return right_links, right_joints, right_frames


@dataclass(frozen=True)
class Body:
    """The whole table."""

    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    frames: tuple[Frame, ...]


def follower_body() -> Body:
    """The follower: 45 actuated joints on a floating base."""
    leg, arm = _left_leg(), _left_arm()
    parts = (_trunk(), leg, _mirrored(*leg), arm, _mirrored(*arm))
    return Body(
        links=tuple(link for part in parts for link in part[0]),
        joints=tuple(joint for part in parts for joint in part[1]),
        frames=tuple(frame for part in parts for frame in part[2]),
    )
