"""One half-step in the making: which primitives run now, and the channels they move."""

from __future__ import annotations

import math

import numpy as np

from follower_humanoid.core.samples import Array, Side
from follower_humanoid.gait.channel import ConstantSpeedChannel, MinimumJerkChannel
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.preview import ZmpLeg
from follower_humanoid.gait.primitives import ZMP, Primitive, StepContext
from follower_humanoid.gait.sequence import Phase, Sequence

DONE_FOR_GOOD = 0.85  # part of its window after which a primitive that has finished stays so


class SwingFoot:
    """The channels of the foot in the air.

    Attributes:
        place: Sole origin over the ground, shape (2,) [m].
        height: Sole height, shape (1,) [m].
        attitude: (yaw, pitch) of the sole, shape (2,) [rad].
        toe: Toe joint, shape (1,) [rad].
        channels: All of them by the names that primitives use.
    """

    def __init__(self, foot: FootPose, toe: float) -> None:
        self.side: Side = foot.side
        self.place = MinimumJerkChannel(foot.xy)
        self.height = MinimumJerkChannel(np.array([foot.z]))
        self.attitude = MinimumJerkChannel(np.array([foot.yaw, 0.0]))
        self.toe = MinimumJerkChannel(np.array([toe]))
        self.channels = {
            "swing_place": self.place,
            "swing_height": self.height,
            "swing_attitude": self.attitude,
            "swing_toe": self.toe,
        }


class HalfStep:
    """Runs the phases of a sequence once.

    Attributes:
        first: Whether it begins out of standing.
        stance: The foot that carries during the swing.
        swing: The other foot.
        closing: True for a step that only brings the feet together.
        phase: The present phase.
        single_support: Whether the swing foot is off the ground by plan.
        progress: Progress of the present phase, 0…1.
        waited: How long the foot has waited to lift off [s].
        pace: Factor on the times of single support; 1 = as the walking parameters say.
        transfer_pace: The same for double support.
        duration: Present time of the whole half-step [s]; may change at any tick.
    """

    def __init__(
        self,
        sequence: Sequence,
        stance: FootPose,
        swing: SwingFoot,
        closing: bool,
        first_transfer: float | None = None,
    ) -> None:
        """Begins with the first phase.

        Args:
            sequence: What to run.
            stance, swing: The feet.
            closing: Whether it only brings the feet together.
            first_transfer: Shortest time of double support [s] where it begins out of standing; else None.
        """
        self._sequence = sequence
        self._phases = sequence.phases
        self._swing_parts = _parts([p.share if p.single_support else 0.0 for p in self._phases])
        self._transfer_parts = _parts([0.0 if p.single_support else p.share for p in self._phases])
        self._shortest_transfer = first_transfer or 0.0
        self.first = first_transfer is not None
        self.stance = stance
        self.swing = swing
        self.closing = closing
        self.waited = 0.0
        self.pace = 1.0
        self.transfer_pace = 1.0
        self.duration = 1.0
        self._timed_for: tuple[float, float, float] | None = None
        self._phase_times: tuple[float, ...] = ()
        self._zmp_context: StepContext | None = None
        self._zmp_points: list[ZmpPoints] = []
        self._enter(0)

    def _enter(self, index: int) -> None:
        """Begins a phase."""
        self._index = index
        self.phase = self._phases[index]
        self.single_support = self.phase.single_support
        self.progress = 0.0
        self._targets: dict[int, tuple[StepContext, Array]] = {}
        self._done: set[int] = set()
        self._open_windows()

    def _open_windows(self) -> None:
        """Which primitives are active from here on, and until which progress."""
        self._active = [
            (number, primitive, None if primitive.channel == ZMP else self.swing.channels[primitive.channel])
            for number, primitive in enumerate(self.phase.primitives)
            if primitive.active(self.progress)
        ]
        self._active_names = tuple([self.phase.names[number] for number, _, _ in self._active])
        edges = [edge for p in self.phase.primitives for edge in (p.start, p.end) if edge > self.progress]
        self._next_edge = min(edges, default=math.inf)

    @property
    def swing_progress(self) -> float:
        """Progress over all phases of single support, 0…1; 0 before them."""
        past, present = self._swing_parts[self._index]
        return past + self.progress * present

    @property
    def transfer_progress(self) -> float:
        """Progress over all phases of double support, 0…1; 1 after them."""
        past, present = self._transfer_parts[self._index]
        return past + self.progress * present

    def until_lift_off(self) -> float:
        """Time until the swing foot leaves the ground by plan, 0 once it has [s]."""
        if self.single_support:
            return 0.0
        ahead = self._times(self.duration)[self._index : self._sequence.doubles]
        return sum(ahead) - self.progress * ahead[0]

    def advance(
        self, context: StepContext, load: float, zmp: ConstantSpeedChannel, duration: float, dt: float
    ) -> bool:
        """One tick of every active primitive.

        Args:
            context: What targets are computed from.
            load: Normal force measured under the swing foot [N].
            zmp: The ZMP channel, which outlives the half-step.
            duration: Time of the half-step by the walking parameters of this tick [s].
            dt: Tick [s].

        Returns:
            True when the last phase has ended with this tick.
        """
        self.duration = duration
        phase_time = self._times(duration)[self._index]
        owned = set()
        for number, primitive, channel in self._active:
            if self._finished(number, primitive, context, load):
                continue
            owned.add(primitive.channel)
            remaining = (primitive.end - self.progress) * phase_time
            moved = zmp if channel is None else channel
            moved.advance(self._target(number, primitive, context), remaining, dt)
        for name, channel in self.swing.channels.items():
            if name not in owned:
                channel.hold(dt)
        if ZMP not in owned:
            zmp.hold(dt)
        self.progress += dt / phase_time
        if self.progress < 1.0 - 1e-9:
            if self.progress >= self._next_edge:
                self._open_windows()
            return False
        if self._index + 1 < len(self._phases):
            self._enter(self._index + 1)
            return False
        self.progress = 1.0
        self._open_windows()
        return True

    def zmp_plan(self, context: StepContext, duration: float) -> tuple[list[ZmpLeg], list[ZmpLeg]]:
        """What the primitives still to come ask of the ZMP: until lift-off, and until touchdown."""
        if context is not self._zmp_context:
            self._zmp_context, self._zmp_points = context, zmp_points(self._phases, context)
        now = slice(self._index, None)
        times = self._times(duration)
        return zmp_legs(self._phases[now], self._zmp_points[now], self.progress, times[now])

    def swing_effort(self, context: StepContext, duration: float) -> tuple[float, float]:
        """How hard the foot in the air must accelerate to its landing: over the ground, about the vertical.

        Args:
            context: The landing asked for.
            duration: Time of the half-step asked for [s].

        Returns:
            Largest accelerations [m/s²], [rad/s²]; 0 before lift-off, when every landing is as near.
        """
        efforts = {"swing_place": 0.0, "swing_attitude": 0.0}
        if self.single_support:
            phase_time = self._times(duration)[self._index]
            for primitive in self.phase.primitives:
                if primitive.channel in efforts and primitive.active(self.progress):
                    remaining = (primitive.end - self.progress) * phase_time
                    channel = self.swing.channels[primitive.channel]
                    efforts[primitive.channel] = channel.effort(primitive.target(context), remaining)
        return efforts["swing_place"], efforts["swing_attitude"]

    def _finished(self, number: int, primitive: Primitive, context: StepContext, load: float) -> bool:
        """Whether a primitive's work is done; late in its window for good: a foot may bounce."""
        if number in self._done:
            return True
        finished = primitive.finished(context, load, self.progress)
        if finished and primitive.completion(self.progress) > DONE_FOR_GOOD:
            self._done.add(number)
        return finished

    def _target(self, number: int, primitive: Primitive, context: StepContext) -> Array:
        """Where a primitive of the present phase goes: it changes with the context until it has settled."""
        aim = self._targets.get(number)
        if aim is None or (aim[0] is not context and primitive.completion(self.progress) < primitive.settled):
            aim = self._targets[number] = context, primitive.target(context)
        return aim[1]

    def _times(self, duration: float) -> tuple[float, ...]:
        """Time of every phase [s], worked out when the pace changes."""
        timed_for = duration, self.pace, self.transfer_pace
        if timed_for != self._timed_for:
            self._timed_for = timed_for
            self._phase_times = tuple([self._phase_time(phase, duration) for phase in self._phases])
        return self._phase_times

    def _phase_time(self, phase: Phase, duration: float) -> float:
        """Time of a phase; the transfer out of standing takes its own [s]."""
        time = self._sequence.phase_time(phase, duration)
        if phase.single_support:
            return time * self.pace
        if self._shortest_transfer == 0.0 or self.transfer_pace < 1.0:
            return time * self.transfer_pace
        return max(time, self._shortest_transfer * phase.share / self._sequence.double_share)

    def active(self) -> tuple[tuple[str, ...], tuple[float, ...]]:
        """Names of the active primitives and their completion."""
        return self._active_names, tuple([p.completion(self.progress) for _, p, _ in self._active])


ZmpPoints = list[Array | None]
"""Where the ZMP goes in each of the windows of a phase, shape (2,) [m]; None = stay."""


def zmp_points(phases: tuple[Phase, ...], context: StepContext) -> list[ZmpPoints]:
    """Targets of what moves the ZMP, phase by phase."""
    return [[None if p is None else p.target(context) for p, _, _ in phase.zmp_windows] for phase in phases]


def zmp_legs(
    phases: tuple[Phase, ...], points: list[ZmpPoints], begin: float, times: tuple[float, ...]
) -> tuple[list[ZmpLeg], list[ZmpLeg]]:
    """What primitives ask of the ZMP: until lift-off, and until touchdown.

    Args:
        phases: Those to come, the present one first.
        points: Of the same phases, see `zmp_points`.
        begin: Progress of the first one.
        times: Of the phases [s].
    """
    transfer: list[ZmpLeg] = []
    swing: list[ZmpLeg] = []
    for phase, targets, time in zip(phases, points, times, strict=True):
        part = swing if phase.single_support else transfer
        for target, (_, start, end) in zip(targets, phase.zmp_windows, strict=True):
            if end > begin:
                part.append((target, (end - max(start, begin)) * time))
        begin = 0.0
    return transfer, swing


def _parts(shares: list[float]) -> list[tuple[float, float]]:
    """The part of a whole before and during each phase."""
    whole = sum(shares)
    return [(sum(shares[:n]) / whole, share / whole) for n, share in enumerate(shares)]
