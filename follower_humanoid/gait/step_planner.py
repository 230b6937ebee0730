"""Half-steps to come: how long they take, where their feet land, what they ask of the ZMP."""

from __future__ import annotations

from functools import lru_cache

from follower_humanoid.core.samples import Array, Gait, Side
from follower_humanoid.gait.feet import FootPose, FootstepConfig, beside, landing_pose, midpoint
from follower_humanoid.gait.half_step import HalfStep, zmp_legs
from follower_humanoid.gait.primitives import StepContext
from follower_humanoid.gait.sequence import Sequence
from follower_humanoid.gait.walk_plan import Plan, WalkerConfig


class StepPlanner:
    """What walking parameters mean for half-steps; knows nothing of the present one."""

    def __init__(self, config: WalkerConfig, footsteps: FootstepConfig, sequence: Sequence) -> None:
        self._config = config
        self._footsteps = footsteps
        self._sequence = sequence
        # Asked for again and again while nothing changes.
        self._landing_pose = lru_cache(maxsize=16)(landing_pose)
        self._context: StepContext | None = None

    def landing(self, stance: FootPose, gait: Gait) -> FootPose:
        """Where the other foot lands, beside the stance foot to stand."""
        if gait.walk_speed == 0.0:
            return beside(stance, self._footsteps)
        return self._landing_pose(stance, gait, self._footsteps)

    def duration(self, pace: Gait) -> float:
        """Time of a half-step [s]."""
        time = self._config.half_step_time * pace.step_length / pace.walk_speed
        return max(time, self._config.shortest_half_step)

    def rest_point(self, feet: dict[Side, FootPose]) -> Array:
        """ZMP of standing on both feet, shape (2,) [m]."""
        return midpoint(feet[Side.LEFT], feet[Side.RIGHT], self._config.stand_forward)

    def context(self, stance: FootPose, landing: FootPose, gait: Gait) -> StepContext:
        """What primitives of a half-step compute their targets from: the last one if nothing differs."""
        last = self._context
        if last is None or last.stance is not stance or last.landing is not landing or last.gait is not gait:
            config = self._config
            last = StepContext(stance, landing, gait, config.swing_height, config.touchdown_load)
            self._context = last
        return last

    def plan(
        self, half: HalfStep, feet: dict[Side, FootPose], gait: Gait, place: FootPose, closing: bool,
        duration: float,
    ) -> Plan:  # fmt: skip
        """From now on: the rest of a half-step, and those after it as far as the preview goes.

        Args:
            half: The present half-step.
            feet: Where the soles stand, or stood before the swing.
            gait: Walking parameters of all that comes.
            place: Where the present half-step lands.
            closing: Whether it only brings the feet together.
            duration: Time of half-steps [s].
        """
        feet = dict(feet)
        context = self.context(half.stance, place, gait)
        transfer, swing = half.zmp_plan(context, duration)
        legs = transfer + swing
        landing = len(legs)
        lift_off, lifting = len(transfer), None if half.single_support else feet[half.swing.side]
        coming = [place]
        feet[place.side] = place
        time = sum(leg[1] for leg in legs)
        while time < self._config.preview and not (gait.walk_speed == 0.0 and closing):
            closing = gait.walk_speed == 0.0
            stance = coming[-1]
            place = self.landing(stance, gait)
            context = self.context(stance, place, gait)
            transfer, swing = zmp_legs(self._sequence.phases, 0.0, context, self._sequence.times(duration))
            if lifting is None:
                lift_off, lifting = len(legs) + len(transfer), feet[place.side]
            legs += transfer + swing
            time += duration
            coming.append(place)
            feet[place.side] = place
        if closing:
            legs.append((self.rest_point(feet), self._config.stand_time))
        return Plan(legs, landing, lift_off, lifting, tuple(coming))
