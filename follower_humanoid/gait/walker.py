"""The walk as a whole: standing, half-step after half-step, closing step; and the plan ahead."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from follower_humanoid.core.samples import SIDES, Array, ContactPlan, Gait, Side
from follower_humanoid.gait.capture import Capture, SwingOutlook, shifted
from follower_humanoid.gait.channel import ConstantSpeedChannel
from follower_humanoid.gait.feet import (
    FootPose,
    FootstepConfig,
    beside,
    landing_pose,
    mean_yaw,
    midpoint,
    wrap_angle,
)
from follower_humanoid.gait.half_step import HalfStep, SwingFoot, phase_zmp_plan
from follower_humanoid.gait.primitives import StepContext
from follower_humanoid.gait.sequence import Sequence
from follower_humanoid.gait.walk_plan import Plan, WalkerConfig

TOGETHER = 0.03  # feet closer than this to their places side by side stand together [m], [rad/3]


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
        self.shares = dict.fromkeys(SIDES, 1.0)
        self.taken: list[tuple[FootPose, bool]] = []
        self._stand_remaining = config.stand_time
        # Asked for again and again while nothing changes.
        self._landing_pose = lru_cache(maxsize=16)(landing_pose)
        self._pace = Gait(1.0, 0.0, 1.0, 1.0, 0.0)

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
        if gait.walk_speed > 0.0:
            self._pace = gait
        if self.half_step is None and gait.walk_speed > 0.0:
            self._begin(self._first_swing(gait), gait, toes, self._config.first_transfer)
        if self._may_give_up(gait):
            self._stand()
        half = self.half_step
        if half is None or self.landing is None:
            self.zmp.advance(self._rest_point(self.feet), max(self._stand_remaining, dt), dt)
            self._stand_remaining -= dt
            self._share_load(None, math.inf, dt)
            return None
        if half.swing_progress < self._config.freeze:
            half.closing = gait.walk_speed == 0.0
            self.landing = shifted(self._landing(half.stance, gait), self.shift)
        if self._waits(half, steady, dt):
            self._share_load(None, math.inf, dt)
            return None
        context = self._context(half.stance, self.landing, gait, loads)
        ended = half.advance(context, self.zmp, self._duration(), dt) or self._touches(half, loads)
        self._share_load(half.swing.side, half.until_lift_off(), dt)
        return self._land(gait, toes) if ended else None

    def _touches(self, half: HalfStep, loads: dict[Side, float]) -> bool:
        """Whether the swing has met the ground early, when every moment counts."""
        late = half.swing_progress >= self._config.early_touchdown
        return self.recovering and late and loads[half.swing.side] > self._config.touchdown_load

    def _waits(self, half: HalfStep, steady: bool, dt: float) -> bool:
        """Before its load is taken off, a foot waits for the DCM; not for ever."""
        if half.single_support or steady or half.until_lift_off() > self._load_time:
            return False
        half.waited += dt
        return half.waited < self._config.patience * self._duration()

    @property
    def untouched(self) -> bool:
        """Whether the present half-step goes where and as fast as the walking parameters say."""
        half = self.half_step
        paces = half is None or half.pace == half.transfer_pace == 1.0
        return paces and not self.shift.any()

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
            transfer=self._sequence.double_time(self._duration()),
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
        half, feet = self.half_step, dict(self.feet)
        if half is None or self.landing is None:
            return Plan([(self._rest_point(feet), max(self._stand_remaining, 1e-3))])
        duration = self._duration()
        context = self._context(half.stance, self.landing, gait, {})
        transfer, swing = half.zmp_plan(context, duration)
        legs = transfer + swing
        landing = len(legs)
        lift_off, lifting = len(transfer), None if half.single_support else feet[half.swing.side]
        coming = [self.landing]
        feet[self.landing.side] = self.landing
        time, closing = sum(leg[1] for leg in legs), half.closing
        while time < self._config.preview and not (gait.walk_speed == 0.0 and closing):
            closing = gait.walk_speed == 0.0
            stance = coming[-1]
            place = self._landing(stance, gait)
            context = self._context(stance, place, gait, {})
            for phase in self._sequence.phases:
                if phase.single_support and lifting is None:
                    lift_off, lifting = len(legs), feet[place.side]
                legs += phase_zmp_plan(phase, 0.0, context, self._sequence.phase_time(phase, duration))
            time += duration
            coming.append(place)
            feet[place.side] = place
        if closing:
            legs.append((self._rest_point(feet), self._config.stand_time))
        return Plan(legs, landing, lift_off, lifting, tuple(coming))

    def contacts(self) -> ContactPlan:
        """Planned shares of the weight."""
        return ContactPlan(left=self.shares[Side.LEFT], right=self.shares[Side.RIGHT])

    def heading(self) -> float:
        """Yaw between the two feet, the swing foot's own while it turns [rad]."""
        if self.half_step is None:
            return mean_yaw(self.feet[Side.LEFT].yaw, self.feet[Side.RIGHT].yaw)
        swing = self.half_step.swing
        turning, still = float(swing.attitude.position[0]), self.feet[swing.side.other].yaw
        return mean_yaw(turning, still) if swing.side is Side.LEFT else mean_yaw(still, turning)

    def _begin(
        self, swing: Side, gait: Gait, toes: dict[Side, float], shortest_transfer: float = 0.0
    ) -> None:
        self.shift = np.zeros(2)
        stance = self.feet[swing.other]
        foot = SwingFoot(self.feet[swing], toes[swing])
        closing = gait.walk_speed == 0.0
        self.half_step = HalfStep(self._sequence, stance, foot, closing, shortest_transfer)
        self.landing = self._landing(stance, gait)

    def _land(self, gait: Gait, toes: dict[Side, float]) -> Side:
        half = self.half_step
        if half is None or self.landing is None:
            raise RuntimeError("a foot lands only at the end of a half-step")
        landed = half.swing.side
        self.feet[landed] = self.landing
        self.taken.append((self.landing, not half.closing))
        if gait.walk_speed == 0.0 and self._together():
            self._stand()
        else:
            self._begin(landed.other, gait, toes)
        return landed

    def _stand(self) -> None:
        self.half_step = None
        self.landing = None
        self._stand_remaining = self._config.stand_time

    def _may_give_up(self, gait: Gait) -> bool:
        """Asked to stop before the first foot has left the ground."""
        half = self.half_step
        waiting = half is not None and not half.single_support and gait.walk_speed == 0.0
        return waiting and self._together()

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

    def _landing(self, stance: FootPose, gait: Gait) -> FootPose:
        if gait.walk_speed == 0.0:
            return beside(stance, self._footsteps)
        return self._landing_pose(stance, gait, self._footsteps)

    def _duration(self) -> float:
        time = self._config.half_step_time * self._pace.step_length / self._pace.walk_speed
        return max(time, self._config.shortest_half_step)

    def _rest_point(self, feet: dict[Side, FootPose]) -> Array:
        return midpoint(feet[Side.LEFT], feet[Side.RIGHT], self._config.stand_forward)

    def _context(
        self, stance: FootPose, landing: FootPose, gait: Gait, loads: dict[Side, float]
    ) -> StepContext:
        return StepContext(
            stance=stance, landing=landing, gait=gait, swing_height=self._config.swing_height,
            swing_load=loads.get(landing.side, 0.0),
            touchdown_load=self._config.touchdown_load,
        )  # fmt: skip

    @property
    def _load_time(self) -> float:
        config = self._config
        return config.hurried_load_time if self.recovering else config.load_time

    def _share_load(self, leaving: Side | None, until_lift: float, dt: float) -> None:
        """A foot takes and leaves its load over `load_time`; in the air it has none."""
        ramp = max(self._load_time, dt)
        for side in SIDES:
            goal = 0.0 if side is leaving and until_lift <= ramp else 1.0
            change = min(max(goal - self.shares[side], -dt / ramp), dt / ramp)
            in_air = side is self.swinging
            self.shares[side] = 0.0 if in_air else self.shares[side] + change
