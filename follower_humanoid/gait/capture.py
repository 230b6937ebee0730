"""Capture steps: the landing place and time that catch a push the ZMP alone cannot.

A DCM that is e off its plan comes back through three means, each with its reach. Shifting the ZMP by Δp until
touchdown moves the planned DCM by (1 − e^{−ωt}) Δp; shifting the next footprint, and all after it, by δ moves
it by w δ; and another time T of the swing is another plan with another e(T). What none of them meets
is a deviation r of the DCM, b = r e^{ωt} once the foot has landed. As in Khadiv et al. (step adaptation of
place and time on the DCM offset) T, δ and b are weighed against each other by squares; here the ZMP, which
costs nothing, comes first, so that small errors leave the walk untouched. For a given T the best Δp and
δ follow axis by axis in closed form; T is searched.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.preview import ZmpLeg, planned_dcm


@dataclass(frozen=True)
class CaptureConfig:
    """When steps are adapted, and how far."""

    enabled: bool = parameter(True, "adapt steps to pushes")
    timing: bool = parameter(True, "adapt their time too, not only their place")
    tolerance: float = parameter(0.01, "DCM error that is nobody's business", "m", 0, 0.1)
    zmp_along: float = parameter(0.04, "ZMP shift along the foot that is counted on", "m", 0, 0.1)
    zmp_across: float = parameter(0.045, "the same across the foot", "m", 0, 0.05)
    forward: float = parameter(0.50, "largest shift of the landing along the foot, either way", "m", 0, 0.5)
    outward: float = parameter(0.25, "largest shift away from the stance foot", "m", 0, 0.5)
    inward: float = parameter(0.06, "largest shift towards the stance foot", "m", 0, 0.1)
    swing_speed: float = parameter(2.2, "largest mean speed of the swing foot to its landing", "m/s", 0.5, 5)
    quickest: float = parameter(0.30, "shortest time of a whole swing", "s", 0.1, 3)
    slowest: float = parameter(1.3, "longest time of a swing, as part of the planned", "", 1, 3)
    cost_time: float = parameter(0.2, "change of the swing's time that weighs 1", "s", 0.01, 10)
    cost_place: float = parameter(0.1, "shift of the landing that weighs 1", "m", 0.01, 1)
    cost_offset: float = parameter(0.02, "DCM deviation at touchdown that weighs 1", "m", 0.001, 1)
    lift_off: float = parameter(
        0.05, "a foot waits on the ground while its step could only end further off than this", "m", 0.005, 1
    )
    take_over: float = parameter(
        0.03, "the reference starts again from the measured DCM when it is further off", "m", 0.005, 1
    )


CANDIDATES = 14  # times that are tried


@dataclass(frozen=True, slots=True)
class SwingOutlook:
    """A swing that runs, or the next one.

    Attributes:
        zmp: Planned ZMP now in world, shape (2,) [m].
        lead: ZMP plan until lift-off.
        swing: ZMP plan of the swing, or what is left of it, as fast as walking asks for.
        rest: ZMP plan after the touchdown.
        moved: How far the landing in that plan is moved already, in world, shape (2,) [m].
        transfer: Time of the double support after the touchdown [s].
        landing: Where the foot lands without a shift.
        foot: Where it is now in world, shape (2,) [m].
        left: Part of the swing that is left, 0…1.
    """

    zmp: Array
    lead: list[ZmpLeg]
    swing: list[ZmpLeg]
    rest: list[ZmpLeg]
    moved: Array
    transfer: float
    landing: FootPose
    foot: Array
    left: float

    @property
    def time(self) -> float:
        """Time of what is left of the swing [s]."""
        return sum(duration for _, duration in self.swing)

    @property
    def until_lift_off(self) -> float:
        """Time until the foot leaves the ground, 0 once it has [s]."""
        return sum(duration for _, duration in self.lead)


@dataclass(frozen=True, slots=True)
class Capture:
    """What a swing does about a DCM error.

    Attributes:
        time: Time of what is left of the swing [s].
        shift: Of the landing place in axes of the landing foot: (forward, outward), shape (2,) [m].
        offset: How far off the DCM will be at touchdown nevertheless [m].
        cost: Sum of the squares; 0 = the walk goes on as planned.
    """

    time: float
    shift: Array
    offset: float
    cost: float


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


def capture(dcm: Array, outlook: SwingOutlook, omega: float, config: CaptureConfig) -> Capture:
    """The place and time of landing that bring a DCM back best.

    Args:
        dcm: Measured DCM, with what the angular momentum does taken off, in world, shape (2,) [m].
        outlook: The swing.
        omega: Natural frequency [1/s].
        config: Limits and weights.
    """
    best: Capture | None = None
    for time, planned in _plans(outlook, omega, config):
        option = _option(dcm - planned, time, outlook, omega, config)
        if best is None or option.cost < best.cost:
            best = option
        if best.cost == 0.0:
            break
    if best is None:
        raise RuntimeError("the planned time is always tried")
    return best


def _plans(outlook: SwingOutlook, omega: float, config: CaptureConfig) -> Iterator[tuple[float, Array]]:
    """Times of the swing, the planned one first, and the DCM that each would need now."""
    end = outlook.zmp
    for target, _ in (*outlook.lead, *outlook.swing):
        end = end if target is None else target
    after = planned_dcm(end, outlook.rest, omega, math.inf) - end
    usual = max(outlook.time, 1e-3)
    quick = min(max(config.quickest * outlook.left, 0.02), usual)
    times = [usual]
    if config.timing:
        span = config.slowest * usual / quick
        times += [quick * span ** (i / (CANDIDATES - 1)) for i in range(CANDIDATES)]
    for time in times:
        pieces = [(target, duration * time / usual) for target, duration in outlook.swing]
        dcm = planned_dcm(outlook.zmp, [*outlook.lead, *pieces], omega, math.inf)
        until = outlook.until_lift_off + time
        moved = footprint_weight(until, outlook.transfer, omega) * outlook.moved
        yield time, dcm + math.exp(-omega * until) * after - moved


def _option(error: Array, time: float, outlook: SwingOutlook, omega: float, config: CaptureConfig) -> Capture:
    """The best Δp and δ for a time of the swing, and what they leave."""
    landing, until = outlook.landing, outlook.until_lift_off + time
    c, s = math.cos(landing.yaw), math.sin(landing.yaw)
    side, (x, y) = landing.side.sign, error.tolist()
    along, outward = c * x + s * y, side * (-s * x + c * y)
    held = 1.0 - math.exp(-omega * until)
    weight = footprint_weight(until, outlook.transfer, omega)
    reserve_along = config.tolerance + held * config.zmp_along
    reserve_across = config.tolerance + held * config.zmp_across
    missing = np.array([_excess(along, reserve_along), _excess(outward, reserve_across)])
    time_cost = ((time - outlook.time) / config.cost_time) ** 2
    if not missing.any() and time >= outlook.time:
        return Capture(time, missing, 0.0, time_cost)
    shift = np.array([
        min(max(missing[0] / weight, -config.forward), config.forward),
        min(max(missing[1] / weight, -config.inward), config.outward),
    ])  # fmt: skip
    shift = _reachable(shift, time, outlook, config)
    left = missing - weight * shift
    offset = math.hypot(left[0], left[1]) * math.exp(omega * until)
    place_cost, offset_cost = float(shift @ shift) / config.cost_place**2, (offset / config.cost_offset) ** 2
    return Capture(time, shift, offset, time_cost + place_cost + offset_cost)


def _reachable(shift: Array, time: float, outlook: SwingOutlook, config: CaptureConfig) -> Array:
    """The shift, cut back where the foot cannot get so far in time."""
    landing = outlook.landing
    away = shifted(landing, shift).xy - outlook.foot
    distance = math.hypot(away[0], away[1])
    # A walk that asks for more may have it.
    speed = max(config.swing_speed, math.dist(landing.xy, outlook.foot) / max(outlook.time, 1e-3))
    if distance <= speed * time:
        return shift
    c, s = math.cos(landing.yaw), math.sin(landing.yaw)
    too_far = away * (1.0 - speed * time / distance)
    back = np.array([
        c * too_far[0] + s * too_far[1],
        landing.side.sign * (-s * too_far[0] + c * too_far[1]),
    ])  # fmt: skip
    return np.asarray(shift - back)


def shifted(landing: FootPose, shift: Array) -> FootPose:
    """The landing place moved by (forward, outward)."""
    forward, outward = shift.tolist()
    if forward == outward == 0.0:
        return landing
    x, y = landing.point(forward, landing.side.sign * outward).tolist()
    return FootPose(landing.side, x, y, landing.yaw, landing.z)


def _excess(value: float, reserve: float) -> float:
    """What goes beyond the reserve, with its sign."""
    return math.copysign(max(abs(value) - reserve, 0.0), value)
