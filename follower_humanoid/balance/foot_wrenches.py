"""Shares a desired ground force between the feet, each within what its sole can do."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.balance.zmp import SolePlace
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, ContactPlan, Side, Wrench


@dataclass(frozen=True)
class SoleConfig:
    """The part of a sole in which its own ZMP is kept, and friction."""

    back: float = parameter(-0.060, "rear edge of the usable sole", "m", -0.2, 0)
    front: float = parameter(0.140, "front edge of the usable sole", "m", 0, 0.3)
    side: float = parameter(0.040, "half width of the usable sole", "m", 0.005, 0.1)
    center: float = parameter(0.030, "middle of the sole ahead of the ankle", "m", -0.1, 0.15)
    friction: float = parameter(0.6, "largest tangential force as part of the normal force", "", 0.05, 2)


@dataclass(frozen=True, slots=True)
class FootShares:
    """Feet's parts of a total force and where each acts.

    Attributes:
        share: Part of the force, adding up to 1.
        point: ZMP of each foot in world, shape (2,) [m]; within the usable sole.
        zmp: What both make together, shape (2,) [m].
    """

    share: dict[Side, float]
    point: dict[Side, Array]
    zmp: Array


def share_feet(zmp: Array, soles: dict[Side, SolePlace], plan: ContactPlan, config: SoleConfig) -> FootShares:
    """Feet's shares that make a ZMP: first by where it lies between the feet, the rest inside the soles.

    Args:
        zmp: Desired ZMP in world, shape (2,) [m].
        soles: Soles in world.
        plan: Most that either foot may carry by plan.
        config: Usable sole.
    """
    allowed = {Side.LEFT: plan.left, Side.RIGHT: plan.right}
    middle = {side: _on_ground(soles[side], config.center, 0.0) for side in SIDES}
    line = middle[Side.LEFT] - middle[Side.RIGHT]
    length2 = float(line @ line)
    left = float((zmp - middle[Side.RIGHT]) @ line) / length2 if length2 > 1e-6 else 0.5
    # Loads change hands only as fast as the plan lets them.
    low, high = 1.0 - allowed[Side.RIGHT], allowed[Side.LEFT]
    left = min(max(left, min(low, high)), max(low, high))
    share = {Side.LEFT: left, Side.RIGHT: 1.0 - left}
    rest = zmp - (left * middle[Side.LEFT] + (1.0 - left) * middle[Side.RIGHT])
    point = {side: _clamp_to_sole(middle[side] + rest, soles[side], config) for side in SIDES}
    reached = share[Side.LEFT] * point[Side.LEFT] + share[Side.RIGHT] * point[Side.RIGHT]
    return FootShares(share, point, reached)


def foot_wrench(
    share: float, point: Array, force: Array, yaw_moment: float, place: SolePlace, friction: float
) -> Wrench:
    """A foot's part of the total force, at and in its sole frame.

    Args:
        share: Part of the force.
        point: Where it acts on the ground in world, shape (2,) [m].
        force: Total force in world, shape (3,) [N].
        yaw_moment: Total moment about the vertical through the foot's point [N·m].
        place: The sole.
        friction: Limit of tangential over normal force.
    """
    own = share * force
    tangential, limit = math.hypot(own[0], own[1]), friction * max(own[2], 0.0)
    if tangential > limit:
        own = own * np.array([limit / tangential, limit / tangential, 1.0])
    x, y = point - place.position[:2]
    z = -place.position[2]
    moment = np.array(
        [y * own[2] - z * own[1], z * own[0] - x * own[2], x * own[1] - y * own[0] + share * yaw_moment]
    )
    to_sole = place.rotation.T
    return Wrench(to_sole @ own, to_sole @ moment)


def _on_ground(place: SolePlace, forward: float, left: float) -> Array:
    """A point of the sole, in world over the ground, shape (2,) [m]."""
    ahead = place.rotation[:2, 0]
    ahead = ahead / max(math.hypot(ahead[0], ahead[1]), 1e-9)
    across = np.array([-ahead[1], ahead[0]])
    return np.array(place.position[:2] + forward * ahead + left * across)


def _clamp_to_sole(point: Array, place: SolePlace, config: SoleConfig) -> Array:
    """The nearest point of the usable sole."""
    ahead = place.rotation[:2, 0]
    ahead = ahead / max(math.hypot(ahead[0], ahead[1]), 1e-9)
    across = np.array([-ahead[1], ahead[0]])
    away = point - place.position[:2]
    forward = min(max(float(away @ ahead), config.back), config.front)
    left = min(max(float(away @ across), -config.side), config.side)
    return np.array(place.position[:2] + forward * ahead + left * across)
