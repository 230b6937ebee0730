"""One half-step in the making: which primitives run now, and the channels they move."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import Array, Side
from follower_humanoid.gait.channel import ConstantSpeedChannel, MinimumJerkChannel
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.preview import ZmpLeg
from follower_humanoid.gait.primitives import Primitive, StepContext
from follower_humanoid.gait.sequence import Phase, Sequence, primitive_name

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
        stance: The foot that carries during the swing.
        closing: True for a step that only brings the feet together.
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
        shortest_transfer: float = 0.0,
    ) -> None:
        self._sequence = sequence
        self._phases = sequence.phases
        self._index = 0
        swings = [phase.share if phase.single_support else 0.0 for phase in self._phases]
        # Of the swing, the part before and during each phase.
        whole = sum(swings)
        self._swing_parts = [(sum(swings[:n]) / whole, part / whole) for n, part in enumerate(swings)]
        self._shortest_transfer = shortest_transfer
        self._targets: dict[tuple[int, int], Array] = {}
        self._done: set[tuple[int, int]] = set()
        self.stance = stance
        self.swing = swing
        self.closing = closing
        self.progress = 0.0
        self.waited = 0.0
        self.pace = 1.0
        self.transfer_pace = 1.0
        self.duration = 1.0

    @property
    def first(self) -> bool:
        """Whether it begins out of standing."""
        return self._shortest_transfer > 0.0

    @property
    def phase(self) -> Phase:
        """The present phase."""
        return self._phases[self._index]

    @property
    def single_support(self) -> bool:
        """Whether the swing foot is off the ground by plan."""
        return self.phase.single_support

    @property
    def swing_progress(self) -> float:
        """Progress over all phases of single support, 0…1; 0 before them."""
        past, present = self._swing_parts[self._index]
        return past + self.progress * present

    def until_lift_off(self) -> float:
        """Time until the swing foot leaves the ground by plan, 0 once it has [s]."""
        if self.single_support:
            return 0.0
        ahead = [p for p in self._phases[self._index :] if not p.single_support]
        times = [self._phase_time(phase, self.duration) for phase in ahead]
        return sum(times) - self.progress * times[0]

    def until_landing(self) -> float:
        """Time until the swing foot touches down by plan [s]."""
        times = [self._phase_time(phase, self.duration) for phase in self._phases[self._index :]]
        return sum(times) - self.progress * times[0]

    def advance(self, context: StepContext, zmp: ConstantSpeedChannel, duration: float, dt: float) -> bool:
        """One tick of every active primitive.

        Args:
            context: What targets are computed from.
            zmp: The ZMP channel, which outlives the half-step.
            duration: Time of the half-step by the walking parameters of this tick [s].
            dt: Tick [s].

        Returns:
            True when the last phase has ended with this tick.
        """
        self.duration = duration
        phase_time = self._phase_time(self.phase, duration)
        owned = set()
        for number, primitive in enumerate(self.phase.primitives):
            if not primitive.active(self.progress):
                continue
            if self._finished(number, primitive, context):
                continue
            owned.add(primitive.channel)
            remaining = (primitive.end - self.progress) * phase_time
            channel = zmp if primitive.channel == "zmp" else self.swing.channels[primitive.channel]
            channel.advance(self._target(number, primitive, context), remaining, dt)
        for name, channel in self.swing.channels.items():
            if name not in owned:
                channel.hold(dt)
        if "zmp" not in owned:
            zmp.hold(dt)
        self.progress += dt / phase_time
        if self.progress < 1.0 - 1e-9:
            return False
        self.progress = 0.0
        self._index += 1
        if self._index < len(self._phases):
            return False
        self._index -= 1
        self.progress = 1.0
        return True

    def zmp_plan(self, context: StepContext, duration: float) -> tuple[list[ZmpLeg], list[ZmpLeg]]:
        """What the primitives still to come ask of the ZMP: until lift-off, and until touchdown."""
        transfer: list[ZmpLeg] = []
        swing: list[ZmpLeg] = []
        for number, phase in enumerate(self._phases[self._index :]):
            begin = self.progress if number == 0 else 0.0
            part = swing if phase.single_support else transfer
            part += phase_zmp_plan(phase, begin, context, self._phase_time(phase, duration))
        return transfer, swing

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
            phase_time = self._phase_time(self.phase, duration)
            for primitive in self.phase.primitives:
                if primitive.channel in efforts and primitive.active(self.progress):
                    remaining = (primitive.end - self.progress) * phase_time
                    channel = self.swing.channels[primitive.channel]
                    efforts[primitive.channel] = channel.effort(primitive.target(context), remaining)
        return efforts["swing_place"], efforts["swing_attitude"]

    def _finished(self, number: int, primitive: Primitive, context: StepContext) -> bool:
        """Whether a primitive's work is done; late in its window for good: a foot may bounce."""
        key = (self._index, number)
        if key in self._done:
            return True
        finished = primitive.finished(context, self.progress)
        if finished and primitive.completion(self.progress) > DONE_FOR_GOOD:
            self._done.add(key)
        return finished

    def _target(self, number: int, primitive: Primitive, context: StepContext) -> Array:
        """The target of a primitive of the present phase, kept once it has settled."""
        key = (self._index, number)
        if key not in self._targets or primitive.completion(self.progress) < primitive.settled:
            self._targets[key] = primitive.target(context)
        return self._targets[key]

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
        running = [p for p in self.phase.primitives if p.active(self.progress)]
        return tuple(map(primitive_name, running)), tuple([p.completion(self.progress) for p in running])


def phase_zmp_plan(phase: Phase, begin: float, context: StepContext, time: float) -> list[ZmpLeg]:
    """What the primitives of a phase of `time` [s] ask of the ZMP from progress `begin` on; gaps rest."""
    legs: list[ZmpLeg] = []
    for primitive in phase.on_zmp:
        if primitive.end <= begin:
            continue
        if primitive.start > begin:
            legs.append((None, (primitive.start - begin) * time))
            begin = primitive.start
        legs.append((primitive.target(context), (primitive.end - begin) * time))
        begin = primitive.end
    if begin < 1.0:
        legs.append((None, (1.0 - begin) * time))
    return legs
