"""Half-steps to come: how long they take, where their feet land, what they ask of the ZMP."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from follower_humanoid.core.samples import Array, Gait, Side
from follower_humanoid.gait.feet import FootPose, FootstepConfig, beside, landing_pose, midpoint
from follower_humanoid.gait.half_step import HalfStep, zmp_legs, zmp_points
from follower_humanoid.gait.preview import ZmpLeg
from follower_humanoid.gait.primitives import StepContext
from follower_humanoid.gait.sequence import Sequence
from follower_humanoid.gait.walk_plan import Plan, WalkerConfig


class _Following(NamedTuple):
    """Half-steps after the present one.

    Attributes:
        zmp: Pieces of the ZMP plan.
        lift_off: How many of them pass until the first lift-off.
        footsteps: The landing poses.
    """

    zmp: tuple[ZmpLeg, ...]
    lift_off: int
    footsteps: tuple[FootPose, ...]


class StepPlanner:
    """What walking parameters mean for half-steps; knows nothing of the present one."""

    def __init__(self, config: WalkerConfig, footsteps: FootstepConfig, sequence: Sequence) -> None:
        self._config = config
        self._footsteps = footsteps
        self._sequence = sequence
        # Asked for again and again while nothing changes: both depend on their frozen arguments and on
        # parameters that stay for good, and what they give is only read.
        self.landing = lru_cache(maxsize=16)(self._landing)
        self._after = lru_cache(maxsize=16)(self._following)
        self._context: StepContext | None = None

    def _landing(self, stance: FootPose, gait: Gait) -> FootPose:
        """Where the other foot lands, beside the stance foot to stand."""
        if gait.walk_speed == 0.0:
            return beside(stance, self._footsteps)
        return landing_pose(stance, gait, self._footsteps)

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
            last = self._context = self._aimed(stance, landing, gait)
        return last

    def _aimed(self, stance: FootPose, landing: FootPose, gait: Gait) -> StepContext:
        return StepContext(stance, landing, gait, self._config.swing_height, self._config.touchdown_load)

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
        transfer, swing = half.zmp_plan(self.context(half.stance, place, gait), duration)
        present = transfer + swing
        steps, stop = 0, gait.walk_speed == 0.0
        time = sum([leg[1] for leg in present])
        while time < self._config.preview and not (stop and closing):
            closing = stop
            time += duration
            steps += 1
        other = feet[place.side.other]
        later = self._after(place, other, gait, steps, closing, duration)
        if not half.single_support:
            lift_off, lifting = len(transfer), feet[half.swing.side]
        elif steps > 0:
            lift_off, lifting = len(present) + later.lift_off, other
        else:
            lift_off, lifting = 0, None
        return Plan([*present, *later.zmp], len(present), lift_off, lifting, (place, *later.footsteps))

    def _following(
        self, place: FootPose, other: FootPose, gait: Gait, steps: int, closing: bool, duration: float
    ) -> _Following:
        """So many half-steps after a landing.

        Args:
            place: Where the foot lands.
            other: Where the other one stands.
            gait: Walking parameters.
            steps: How many there are.
            closing: Whether the last one, that landing if there is none, brings the feet together for good.
            duration: Time of half-steps [s].
        """
        legs: list[ZmpLeg] = []
        lift_off, footsteps = 0, []
        feet = {place.side: place, other.side: other}
        phases, times = self._sequence.phases, self._sequence.times(duration)
        for number in range(steps):
            stance, place = place, self.landing(place, gait)
            points = zmp_points(phases, self._aimed(stance, place, gait))
            transfer, swing = zmp_legs(phases, points, 0.0, times)
            if number == 0:
                lift_off = len(transfer)
            legs += transfer + swing
            footsteps.append(place)
            feet[place.side] = place
        if closing:
            legs.append((self.rest_point(feet), self._config.stand_time))
        return _Following(tuple(legs), lift_off, tuple(footsteps))
