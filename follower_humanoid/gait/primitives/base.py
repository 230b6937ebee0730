"""What a motion primitive is (Savić et al. 2016, section RAMP; Raković et al., refs. [5-7] there).

A primitive owns one channel for a window of its phase. It has a target, computed from the four
walking parameters whenever they change, a speed, set by its window and the pace of the half-step, and an
end condition. Primitives of different channels run in parallel; those of one channel follow one another.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from follower_humanoid.core.samples import Array, Gait
from follower_humanoid.gait.feet import FootPose

ZMP = "zmp"
"""The one channel that outlives a half-step; the others are the swing foot's."""


@dataclass(frozen=True, slots=True)
class StepContext:
    """What primitives compute their targets from; the same one as long as the half-step is not re-aimed.

    Attributes:
        stance: The foot that carries during the swing.
        landing: Where the swing foot is going.
        gait: The walking parameters.
        swing_height: Nominal height of the swing foot [m].
        touchdown_load: Normal force that counts as contact [N].
    """

    stance: FootPose
    landing: FootPose
    gait: Gait
    swing_height: float
    touchdown_load: float


@dataclass(frozen=True)
class Primitive:
    """A motion primitive.

    Attributes:
        channel: The coordinate it moves.
        settled: Part of the window after which the target is kept: too late a change would be a jerk.
        start, end: Window within the phase, 0…1; the shorter, the faster.
    """

    channel: ClassVar[str]
    settled: ClassVar[float] = 1.0

    start: float = 0.0
    end: float = 1.0

    def target(self, context: StepContext) -> Array:
        """Where the channel must be at the end of the window."""
        raise NotImplementedError

    def finished(self, context: StepContext, load: float, progress: float) -> bool:
        """Whether the work is done before the window is over; the channel then rests.

        Args:
            context: As for the target.
            load: Normal force measured under the swing foot [N].
            progress: Of the phase, 0…1.
        """
        del context, load, progress
        return False

    def active(self, progress: float) -> bool:
        """Whether the window is open at this progress of the phase."""
        return self.start <= progress < self.end

    def completion(self, progress: float) -> float:
        """How far the window has passed, 0…1."""
        return min(1.0, max(0.0, (progress - self.start) / (self.end - self.start)))
