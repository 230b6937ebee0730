"""Changes of the walking parameters, taken over as fast as the walk can follow.

Walking parameters may change at any instant. What they ask for may be out of reach at that instant: a foot
about to land cannot go twice as far, and a DCM that leaves for a landing in 0.3 s cannot wait 2 s for it,
since it runs away as e^{ωt} and nothing but a few centimetres of ZMP holds it back. So a change is taken
over in parts, each tick the largest that is within reach:

* the planned DCM stays near the reference DCM: a gap g decays at the rate k with a ZMP shift of (1 + k/ω) g,
  which the feet on the ground must allow; with a foot in the air only (1 − e^{−ωt}) of it until touchdown;
* the swing foot need not accelerate harder to its landing than a leg can.

The rest waits for the next ticks, or the next double support, in which the ZMP has more room.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from follower_humanoid.balance.support_polygon import polygon_margin
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Gait
from follower_humanoid.gait.feet import wrap_angle
from follower_humanoid.gait.preview import planned_dcm
from follower_humanoid.gait.walker import Walker

PARTS = (1.0, 0.25, 1.0 / 16.0, 1.0 / 64.0)  # of a change, tried one after the other
SPARE = 0.015  # how far inside the support polygon the ZMP must stay [m]
FRESH = 0.2  # part of a double support in which walking may still become standing, and standing walking


@dataclass(frozen=True)
class ChangesConfig:
    """How changes of the walking parameters are taken over."""

    eased: bool = parameter(True, "take over no more of a change than is within reach; off: all at once")
    swing_acceleration: float = parameter(
        10.0, "a change may ask this much of the swing foot", "m/s²", 1, 100
    )
    swing_turn: float = parameter(20.0, "the same about the vertical", "rad/s²", 1, 200)


@dataclass(frozen=True, slots=True)
class ZmpRoom:
    """Where the ZMP may go to make the reference join a changed plan.

    Attributes:
        omega: Natural frequency of the pendulum [1/s].
        convergence: Decay rate of the gap between planned and reference DCM [1/s].
        single, double: Largest ZMP shift on one foot, on both [m].
    """

    omega: float
    convergence: float
    single: float
    double: float

    @property
    def gain(self) -> float:
        """ZMP shift per gap."""
        return 1.0 + self.convergence / self.omega

    def reach(self, until_lift_off: float, until_landing: float) -> float:
        """Largest ZMP shift that a change may cost now [m].

        Args:
            until_lift_off: Time on both feet to come, 0 on one foot [s].
            until_landing: Time to touchdown [s].
        """
        if until_lift_off > 0.0:
            # What is left of it at lift-off one foot must deal with.
            decay = math.exp(min(self.convergence * until_lift_off, 10.0))
            return min(self.double, self.single * decay)
        return self.single * (1.0 - math.exp(-self.omega * until_landing))


def between(old: Gait, new: Gait, part: float) -> Gait:
    """Walking parameters that have gone so far from old to new; angles the short way round."""
    if part == 1.0:
        return new
    return Gait(
        walk_speed=old.walk_speed + part * (new.walk_speed - old.walk_speed),
        walk_dir=old.walk_dir + part * wrap_angle(new.walk_dir - old.walk_dir),
        step_length=old.step_length + part * (new.step_length - old.step_length),
        step_height=old.step_height + part * (new.step_height - old.step_height),
        heading=old.heading + part * wrap_angle(new.heading - old.heading),
    )


class GaitChanges:
    """The walking parameters that the walk uses, on their way to those asked for.

    Attributes:
        used: Those that it uses.
    """

    def __init__(self, config: ChangesConfig, gait: Gait, preview: float) -> None:
        """`preview`: how far ahead the planned DCM looks [s]."""
        self._config = config
        self._preview = preview
        self.used = gait

    def step(self, wanted: Gait, walker: Walker, dcm: Array, room: ZmpRoom) -> Gait:
        """One tick.

        Args:
            wanted: Walking parameters asked for.
            walker: The walk, before its own tick.
            dcm: Of the reference, with what the angular momentum does taken off, in world, shape (2,) [m].
            room: What the ZMP can do.

        Returns:
            Walking parameters to be used now.
        """
        self.used = self._within_reach(wanted, walker, dcm, room)
        return self.used

    def _within_reach(self, wanted: Gait, walker: Walker, dcm: Array, room: ZmpRoom) -> Gait:
        used, half = self.used, walker.half_step
        switched = (wanted.walk_speed > 0.0) != (used.walk_speed > 0.0)
        if half is None or not self._config.eased or walker.gives_up(wanted):
            return wanted
        if switched and half.transfer_progress < FRESH:
            return wanted
        support = walker.support()
        # There is nothing between walking and standing.
        for part in PARTS[:1] if switched else PARTS:
            gait = between(used, wanted, part)
            strain = self._strain(gait, walker, support, dcm, room)
            if strain > 0.0 and strain > self._strain(used, walker, support, dcm, room):
                continue
            if self._foot_can(gait, walker):
                return gait
        return used

    def _foot_can(self, gait: Gait, walker: Walker) -> bool:
        """Whether the swing foot can get to its landing, or has no harder way there than now."""
        limits = (self._config.swing_acceleration, self._config.swing_turn)
        effort = walker.swing_effort(gait)
        if all(wanted <= limit for wanted, limit in zip(effort, limits, strict=True)):
            return True
        now = walker.swing_effort(self.used)
        return all(wanted <= max(limit, old) for wanted, limit, old in zip(effort, limits, now, strict=True))

    def _strain(self, gait: Gait, walker: Walker, support: Array, dcm: Array, room: ZmpRoom) -> float:
        """How far the ZMP that joins the plan is beyond what it may be; negative within [m]."""
        plan, half = walker.plan_with(gait), walker.half_step
        times = [duration for _, duration in plan.zmp]
        on_both = half is not None and not half.single_support
        reach = room.reach(sum(times[: plan.lift_off]) if on_both else 0.0, sum(times[: plan.landing]))
        shift = room.gain * (dcm - planned_dcm(walker.zmp.position, plan.zmp, room.omega, self._preview))
        inside = polygon_margin(support, walker.zmp.position + shift)
        return max(math.hypot(shift[0], shift[1]) - reach, SPARE - inside)
