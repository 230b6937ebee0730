"""Capture steps: the landing place and time that catch a push the ZMP alone cannot.

A DCM that is e off its plan is brought back by the ZMP as long as e is within what the sole offers, the
reserve. What goes beyond must be met by the next footprint: moving it (and all after it) by δ moves
the planned DCM by w δ, with w from the same preview as the plan, so δ = (e − reserve)/w (cf. Khadiv et al.:
step adaptation on the DCM offset). A slow swing is hurried: late steps catch nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.gait.feet import FootPose


@dataclass(frozen=True)
class CaptureConfig:
    """When steps are adapted, and how far."""

    enabled: bool = parameter(True, "adapt steps to pushes")
    reserve_along: float = parameter(
        0.05, "DCM error along the foot that is left to the ZMP", "m", 0.005, 0.2
    )
    reserve_across: float = parameter(0.022, "the same across the foot", "m", 0.005, 0.2)
    amplification: float = parameter(6.0, "largest shift of the landing per excess of the DCM", "", 1, 30)
    forward: float = parameter(0.30, "largest shift along the foot, either way", "m", 0, 0.5)
    outward: float = parameter(0.25, "largest shift away from the stance foot", "m", 0, 0.5)
    inward: float = parameter(0.09, "largest shift towards the stance foot", "m", 0, 0.1)
    lift_off: float = parameter(
        0.035, "a foot waits on the ground while the DCM error is larger", "m", 0.005, 1
    )
    hurry: float = parameter(0.55, "time of a whole swing that is hurried", "s", 0.2, 3)


def footprint_weight(until_landing: float, transfer: float, omega: float) -> float:
    """w: how far the planned DCM moves per shift of the next footprint and all after it.

    The ZMP goes over to the shifted footprint linearly during the transfer that follows the landing.

    Args:
        until_landing: Time to touchdown [s].
        transfer: Time of the double support after it [s].
        omega: Natural frequency [1/s].
    """
    if transfer * omega < 1e-6:
        return math.exp(-omega * until_landing)
    span = math.exp(-omega * until_landing) - math.exp(-omega * (until_landing + transfer))
    return span / (omega * transfer)


def landing_shift(error: Array, landing: FootPose, weight: float, config: CaptureConfig) -> Array:
    """δ of the landing place in axes of the landing foot.

    Args:
        error: Measured minus planned DCM (of the plan without a shift) in world, shape (2,) [m].
        landing: Where the foot would land otherwise.
        weight: See `footprint_weight`.
        config: Reserves and limits.

    Returns:
        (forward, outward), shape (2,) [m].
    """
    c, s = math.cos(landing.yaw), math.sin(landing.yaw)
    along = c * error[0] + s * error[1]
    outward = (-s * error[0] + c * error[1]) * landing.side.sign
    gain = min(1.0 / max(weight, 1e-9), config.amplification)
    forward_shift = gain * _excess(along, config.reserve_along)
    outward_shift = gain * _excess(outward, config.reserve_across)
    return np.array([
        min(max(forward_shift, -config.forward), config.forward),
        min(max(outward_shift, -config.inward), config.outward),
    ])  # fmt: skip


def shifted(landing: FootPose, shift: Array) -> FootPose:
    """The landing place moved by (forward, outward)."""
    x, y = landing.point(float(shift[0]), landing.side.sign * float(shift[1]))
    return FootPose(landing.side, float(x), float(y), landing.yaw, landing.z)


def _excess(value: float, reserve: float) -> float:
    """What goes beyond the reserve, with its sign."""
    return math.copysign(max(abs(value) - reserve, 0.0), value)
