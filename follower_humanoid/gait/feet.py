"""Where feet stand and where the next one goes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Gait, Side

HEEL_TOE, EDGES = (-0.06, 0.14), (-0.045, 0.045)  # what a sole can use, from its origin [m]


@dataclass(frozen=True, slots=True)
class FootPose:
    """A sole flat on the ground.

    Attributes:
        side: Which foot.
        x, y, z: Sole origin in world [m].
        yaw: Heading of the foot in world [rad].
    """

    side: Side
    x: float
    y: float
    yaw: float
    z: float = 0.0

    def point(self, forward: float, left: float = 0.0) -> Array:
        """A point of the sole in world, shape (2,) [m]: `forward` and `left` of the sole origin."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return np.array([self.x + c * forward - s * left, self.y + s * forward + c * left])

    @property
    def xy(self) -> Array:
        """Sole origin in world, shape (2,) [m]."""
        return np.array([self.x, self.y])


@dataclass(frozen=True)
class FootstepConfig:
    """Nominal step and its limits."""

    half_step_length: float = parameter(0.40, "nominal half-step length (step_length = 1)", "m", 0.05, 0.8)
    stance_width: float = parameter(0.18, "distance between the sole centre lines", "m", 0.14, 0.4)
    turn_per_step: float = parameter(
        0.40, "largest yaw of a landing foot against the stance foot", "rad", 0, 0.8
    )
    turn_inward: float = parameter(
        0.25, "largest toe-in of a landing foot against the stance foot", "rad", 0, 0.6
    )
    turn_spread: float = parameter(
        0.20, "extra width per yaw between the feet, room for the swing foot", "m/rad", 0, 1
    )


def wrap_angle(angle: float) -> float:
    """The angle in [−π, π]."""
    return math.remainder(angle, 2.0 * math.pi)


def landing_pose(stance: FootPose, gait: Gait, config: FootstepConfig) -> FootPose:
    """Where the swing foot lands so that the half-step has the commanded length and direction.

    In axes of the landing heading the swing foot goes the half-step length along the direction of
    travel and keeps the stance width to its own side; the sideways part of the travel is taken by
    the foot on that side, the other one closes up.

    Args:
        stance: The foot that carries.
        gait: Walking parameters; walk_speed 0 brings the feet together.
        config: Nominal step.
    """
    side = stance.side.other
    turn = wrap_angle(gait.heading - stance.yaw)
    # Toe-in: the landing foot turns towards the stance foot, their toes come close.
    inward = config.turn_inward
    left_most = config.turn_per_step if side is Side.LEFT else inward
    right_most = inward if side is Side.LEFT else config.turn_per_step
    yaw = stance.yaw + min(max(turn, -right_most), left_most)
    length = config.half_step_length * gait.step_length if gait.walk_speed > 0.0 else 0.0
    # A turn may need several steps. One that only follows its own heading goes where its foot points;
    # otherwise the direction of travel is kept in world.
    travel = wrap_angle(gait.walk_dir - gait.heading)
    if abs(travel) > 1e-9:
        travel = gait.walk_dir - yaw
    forward, sideways = length * math.cos(travel), length * math.sin(travel)
    width = config.stance_width + config.turn_spread * abs(wrap_angle(yaw - stance.yaw))
    lateral = side.sign * width + (sideways if sideways * side.sign > 0.0 else 0.0)
    c, s = math.cos(yaw), math.sin(yaw)
    x, y = stance.x + c * forward - s * lateral, stance.y + s * forward + c * lateral
    return FootPose(side, x, y, yaw, stance.z)


def half_step_length(landed: FootPose, stance: FootPose) -> float:
    """Distance of the two sole origins along the heading of the foot that landed [m]."""
    return (landed.x - stance.x) * math.cos(landed.yaw) + (landed.y - stance.y) * math.sin(landed.yaw)


def sole_corners(foot: FootPose) -> list[Array]:
    """Corners of what a sole can use, in world, shape (2,) each [m]."""
    return [foot.point(x, y) for x in HEEL_TOE for y in EDGES]


def midpoint(left: FootPose, right: FootPose, forward: float) -> Array:
    """The point between the feet, `forward` of the sole origins, shape (2,) [m]."""
    return 0.5 * (left.point(forward) + right.point(forward))


def mean_yaw(left: float, right: float) -> float:
    """Heading between those of the two feet [rad]."""
    return left + 0.5 * wrap_angle(right - left)


def beside(stance: FootPose, config: FootstepConfig) -> FootPose:
    """The landing pose of a closing step: next to the stance foot."""
    stand = Gait(walk_speed=0.0, walk_dir=0.0, step_length=1.0, step_height=1.0, heading=stance.yaw)
    return landing_pose(stance, stand, config)
