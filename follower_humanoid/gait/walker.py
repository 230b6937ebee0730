"""The walk as a whole: standing, half-step after half-step, closing step; and the plan ahead."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from follower_humanoid.balance.support_polygon import convex_hull
from follower_humanoid.core.samples import Array, ContactPlan, Gait, Side
from follower_humanoid.gait.capture import Capture, SwingOutlook, shifted
from follower_humanoid.gait.channel import ConstantSpeedChannel
from follower_humanoid.gait.feet import (
    FootPose,
    FootstepConfig,
    beside,
    mean_yaw,
    sole_corners,
    wrap_angle,
)
from follower_humanoid.gait.half_step import HalfStep, SwingFoot
from follower_humanoid.gait.load_shares import LoadShares
from follower_humanoid.gait.sequence import Sequence
from follower_humanoid.gait.step_planner import StepPlanner
from follower_humanoid.gait.walk_plan import Plan, WalkerConfig

TOGETHER = 0.03  # feet closer than this to their places side by side stand together [m], [rad/3]
COMMITTED = 0.75  # part of the first double support after which the body goes on to its stance foot


@lru_cache(maxsize=4)
def _support(*feet: FootPose) -> Array:
    """Convex hull of the soles, counter-clockwise, shape (n, 2) [m]."""
    return convex_hull(np.array([corner for foot in feet for corner in sole_corners(foot)]))


class Walker:
    """Decides what runs: nothing (standing), a half-step, or a closing step.

    Attributes:
        feet: Where the soles stand, or stood before the swing.
        half_step: The one in the making, or None while standing.
        landing: Landing pose of the half-step in the making.
        zmp: Channel of the planned ZMP.
        shares: Share of the weight either foot may take by plan, 0…1.
        shift: Capture shift of the landing, (forward, outward) in axes of the landing foot [m].
        recovering: Whether a push is being answered: loads change hands faster.
        taken: Footprints in order, each with True if it counts as a half-step.
    """

    def __init__(
        self, config: WalkerConfig, footsteps: FootstepConfig, sequence: Sequence,
        feet: dict[Side, FootPose], zmp: Array,
    ) -> None:  # fmt: skip
        self._config = config
        self._footsteps = footsteps
        self.shift: Array = np.zeros(2)
        self._sequence = sequence
        left, right = feet[Side.LEFT], feet[Side.RIGHT]
        # Both yaws on one branch: a swing foot that starts at −π must not turn all round to reach +π.
        right = replace(right, yaw=left.yaw + wrap_angle(right.yaw - left.yaw))
        self.feet = {Side.LEFT: left, Side.RIGHT: right}
        self.recovering = False
        self.half_step: HalfStep | None = None
        self.landing: FootPose | None = None
        self.zmp = ConstantSpeedChannel(zmp)
        self._loads = LoadShares()
        self.shares = self._loads.of
        self.taken: list[tuple[FootPose, bool]] = []
        self._stand_remaining = config.stand_time
        self._planner = StepPlanner(config, footsteps, sequence)
        self._go_at(Gait(1.0, 0.0, 1.0, 1.0, 0.0))

    @property
    def swinging(self) -> Side | None:
        """The foot in the air by plan."""
        half = self.half_step
        return half.swing.side if half is not None and half.single_support else None

    def step(
        self, gait: Gait, loads: dict[Side, float], toes: dict[Side, float], steady: bool, dt: float
    ) -> Side | None:
        """One tick.

        Args:
            gait: Walking parameters.
            loads: Measured normal force of either foot [N].
            toes: Reference angle of either toe joint [rad].
            steady: False while the DCM is too far off for a foot to leave the ground.
            dt: Tick [s].

        Returns:
            The foot that has landed by plan with this tick, or None.
        """
        if gait.walk_speed > 0.0 and gait is not self._pace:
            self._go_at(gait)
        if self.half_step is None and gait.walk_speed > 0.0:
            self._begin(self._first_swing(gait), gait, toes, self._config.first_transfer)
        if self.gives_up(gait):
            self._stand()
        half = self.half_step
        if half is None or self.landing is None:
            self.zmp.advance(self._planner.rest_point(self.feet), max(self._stand_remaining, dt), dt)
            self._stand_remaining -= dt
            self._share_load(None, math.inf, dt)
            return None
        if half.swing_progress < self._config.freeze:
            half.closing = gait.walk_speed == 0.0
            self.landing = self._aim(half, gait)
        if self._waits(half, steady, dt):
            self._share_load(None, math.inf, dt)
            return None
        context, load = self._planner.context(half.stance, self.landing, gait), loads[half.swing.side]
        ended = half.advance(context, load, self.zmp, self._duration, dt) or self._touches(half, load)
        self._share_load(half.swing.side, half.until_lift_off(), dt)
        return self._land(gait, toes) if ended else None

    def _touches(self, half: HalfStep, load: float) -> bool:
        """Whether the swing has met the ground early, when every moment counts."""
        late = half.swing_progress >= self._config.early_touchdown
        return self.recovering and late and load > self._config.touchdown_load

    def _waits(self, half: HalfStep, steady: bool, dt: float) -> bool:
        """Before its load is taken off, a foot waits for the DCM; not for ever."""
        if half.single_support or steady or half.until_lift_off() > self._load_time:
            return False
        half.waited += dt
        return half.waited < self._config.patience * self._duration

    @property
    def untouched(self) -> bool:
        """Whether the present half-step goes where and as fast as the walking parameters say."""
        half = self.half_step
        paces = half is None or half.pace == half.transfer_pace == 1.0
        return paces and self.shift.tolist() == [0.0, 0.0]

    def outlook(self, plan: Plan) -> SwingOutlook | None:
        """The swing that runs or comes next, as fast as the walking parameters say; None: nothing to move."""
        half = self.half_step
        if half is None or self.landing is None or half.swing_progress >= self._config.freeze:
            return None
        lead, swing = plan.zmp[: plan.lift_off], plan.zmp[plan.lift_off : plan.landing]
        if half.single_support:
            lead, swing = [], plan.zmp[: plan.landing]
        usual = shifted(self.landing, -self.shift)
        return SwingOutlook(
            zmp=self.zmp.position,
            lead=lead,
            swing=[(target, duration / half.pace) for target, duration in swing],
            rest=plan.zmp[plan.landing :],
            transfer=self._sequence.double_time(self._duration),
            moved=self.landing.xy - usual.xy,
            landing=usual,
            foot=half.swing.place.position,
            left=1.0 - half.swing_progress,
        )

    def catch(self, wanted: Capture, outlook: SwingOutlook) -> None:
        """Moves the landing of the present swing, in place and time."""
        half = self.half_step
        if half is None:
            return
        if not half.single_support:
            if self.recovering and wanted.cost > 0.0:
                half.transfer_pace = self._config.hurried_transfer
            return
        self.shift = wanted.shift
        half.pace = wanted.time / outlook.time

    def anchor(self, side: Side, foot: FootPose) -> None:
        """The foot stands where it is measured, not where it was sent; its yaw stays on the known branch."""
        known = self.feet[side].yaw
        foot = replace(foot, yaw=known + wrap_angle(foot.yaw - known))
        self.feet[side] = foot
        if self.half_step is not None and self.half_step.stance.side is side:
            self.half_step.stance = foot
        if self.taken and self.taken[-1][0].side is side:
            self.taken[-1] = (foot, self.taken[-1][1])

    def plan_ahead(self, gait: Gait) -> Plan:
        """The ZMP from now on, and the feet it will stand on."""
        half = self.half_step
        if half is None or self.landing is None:
            return Plan([(self._planner.rest_point(self.feet), max(self._stand_remaining, 1e-3))])
        return self._planner.plan(half, self.feet, gait, self.landing, half.closing, self._duration)

    def plan_with(self, gait: Gait) -> Plan:
        """What the plan would be if these were the walking parameters from now on."""
        half = self.half_step
        if half is None or self.landing is None:
            return self.plan_ahead(gait)
        place, closing, duration = self._with(half, self.landing, gait)
        return self._planner.plan(half, self.feet, gait, place, closing, duration)

    def swing_effort(self, gait: Gait) -> tuple[float, float]:
        """How hard the foot in the air must accelerate with these walking parameters, see `HalfStep`."""
        half = self.half_step
        if half is None or self.landing is None:
            return 0.0, 0.0
        place, _, duration = self._with(half, self.landing, gait)
        return half.swing_effort(self._planner.context(half.stance, place, gait), duration)

    def support(self) -> Array:
        """Support polygon by plan, counter-clockwise, shape (n, 2) [m]."""
        swinging = self.swinging
        return _support(*(foot for side, foot in self.feet.items() if side is not swinging))

    def contacts(self) -> ContactPlan:
        """Planned shares of the weight."""
        return self._loads.contacts()

    def heading(self) -> float:
        """Yaw between the two feet, the swing foot's own while it turns [rad]."""
        if self.half_step is None:
            return mean_yaw(self.feet[Side.LEFT].yaw, self.feet[Side.RIGHT].yaw)
        swing = self.half_step.swing
        turning, still = float(swing.attitude.position[0]), self.feet[swing.side.other].yaw
        return mean_yaw(turning, still) if swing.side is Side.LEFT else mean_yaw(still, turning)

    def _go_at(self, pace: Gait) -> None:
        """From now on half-steps take the time that these walking parameters ask for."""
        self._pace = pace
        self._duration = self._planner.duration(pace)

    def _begin(
        self, swing: Side, gait: Gait, toes: dict[Side, float], first_transfer: float | None = None
    ) -> None:
        self.shift = np.zeros(2)
        stance = self.feet[swing.other]
        foot = SwingFoot(self.feet[swing], toes[swing])
        closing = gait.walk_speed == 0.0
        self.half_step = HalfStep(self._sequence, stance, foot, closing, first_transfer)
        self.landing = self._planner.landing(stance, gait)

    def _land(self, gait: Gait, toes: dict[Side, float]) -> Side:
        half = self.half_step
        if half is None or self.landing is None:
            raise RuntimeError("a foot lands only at the end of a half-step")
        landed = half.swing.side
        self.feet[landed] = self.landing
        self.taken.append((self.landing, not half.closing))
        # A step that was not meant to be the last has left the body in motion: a closing one follows.
        if gait.walk_speed == 0.0 and half.closing and self._together():
            self._stand()
        else:
            self._begin(landed.other, gait, toes)
        return landed

    def _stand(self) -> None:
        self.half_step = None
        self.landing = None
        self._stand_remaining = self._config.stand_time

    def gives_up(self, gait: Gait) -> bool:
        """Asked to stop before the first foot has left the ground."""
        half = self.half_step
        turns_back = half is not None and half.first and half.transfer_progress < COMMITTED
        return turns_back and gait.walk_speed == 0.0

    def _together(self) -> bool:
        left, right = self.feet[Side.LEFT], self.feet[Side.RIGHT]
        place = beside(left, self._footsteps)
        away = math.hypot(place.x - right.x, place.y - right.y)
        return away < TOGETHER and abs(wrap_angle(left.yaw - right.yaw)) < 3.0 * TOGETHER

    def _first_swing(self, gait: Gait) -> Side:
        """The foot on the side of the travel or the turn; the right one when straight ahead."""
        heading = self.heading()
        aside = math.sin(gait.walk_dir - heading) + wrap_angle(gait.heading - heading)
        return Side.LEFT if aside > 0.05 else Side.RIGHT

    def _with(self, half: HalfStep, landing: FootPose, gait: Gait) -> tuple[FootPose, bool, float]:
        """Landing, whether it closes and time [s] of the present half-step with these walking parameters."""
        duration = self._planner.duration(gait if gait.walk_speed > 0.0 else self._pace)
        if half.swing_progress >= self._config.freeze:
            return landing, half.closing, duration
        return self._aim(half, gait), gait.walk_speed == 0.0, duration

    def _aim(self, half: HalfStep, gait: Gait) -> FootPose:
        """Where the present half-step goes, what catches a push included."""
        return shifted(self._planner.landing(half.stance, gait), self.shift)

    @property
    def _load_time(self) -> float:
        config = self._config
        return config.hurried_load_time if self.recovering else config.load_time

    def _share_load(self, leaving: Side | None, until_lift: float, dt: float) -> None:
        self._loads.advance(leaving, until_lift, self.swinging, self._load_time, dt)
