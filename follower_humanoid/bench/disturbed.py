"""Runs that something happens to: pulls, pushes, walking parameters out of the blue, late commands."""

from __future__ import annotations

import math
import multiprocessing
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from follower_humanoid.balance.support_polygon import polygon_margin
from follower_humanoid.core.samples import Array, Gait, Odometry, Polygon, Sample, Wrench
from follower_humanoid.graph.record import RunRecorder
from follower_humanoid.graph.simulate import TICK, Chain, Parameters

UPRIGHT = math.radians(5.0)
COMMANDS = ("legs/command", "arms/command")


@dataclass(frozen=True)
class Push:
    """A force on the pelvis.

    Attributes:
        begin, time: When and how long [s].
        impulse: In world over the ground, shape (2,) [N·s].
    """

    begin: float
    impulse: Array
    time: float = 0.1

    def force(self, time: float) -> Array:
        """Force at a time, shape (3,) [N]."""
        acts = self.begin - 1e-9 <= time < self.begin + self.time - 1e-9
        return np.array([*(self.impulse / self.time), 0.0]) if acts else np.zeros(3)


@dataclass
class Course:
    """What happens in a run; takes the place of what the leader and the mapping publish.

    Attributes:
        left, right: Force on either hand [N].
        gait: Walking parameters over time, None: as the hands say.
        push: Force on the pelvis.
        delay: Ticks by which motor voltages come late.
    """

    left: tuple[float, float, float] = (0.0, 0.0, 0.0)
    right: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gait: Callable[[float], Gait] | None = None
    push: Push | None = None
    delay: int = 0
    _late: dict[str, deque[Any]] = field(default_factory=dict)

    def __call__(self, topic: str, tick: int, sample: Any) -> Any:
        """An `Interference` of the chain."""
        time = tick * TICK
        if topic == "leader/left_hand/wrench":
            return Wrench(np.array(self.left), np.zeros(3))
        if topic == "leader/right_hand/wrench":
            return Wrench(np.array(self.right), np.zeros(3))
        if topic == "base/push":
            return Wrench(self.push.force(time) if self.push is not None else np.zeros(3), np.zeros(3))
        if topic == "gait" and self.gait is not None:
            return self.gait(time)
        if topic in COMMANDS and self.delay:
            queue = self._late.setdefault(topic, deque([sample] * self.delay))
            queue.append(sample)
            return queue.popleft()
        return sample


@dataclass(frozen=True)
class Ending:
    """How a run went.

    Attributes:
        time: Simulated time at its end [s].
        fall: What showed the fall, empty without one.
        margin: Smallest distance of the ZMP to the edge of the support polygon, of all its run [m].
        settled: Upright at the end with the ZMP inside the support polygon.
        steps: Counted half-steps.
        place: base_link over the ground and its yaw, shape (3,) [m], [rad].
        voltage: Largest voltage of a leg motor [V].
    """

    time: float
    fall: str
    margin: float
    settled: bool
    steps: int
    place: Array
    voltage: float


class Trial:
    """A chain on its course, which may branch."""

    def __init__(self, course: Course, parameters: Parameters | None = None) -> None:
        self.course = course
        settings = {name: dict(values) for name, values in (parameters or {}).items()}
        settings.setdefault("leader", {}).setdefault("programme", "fig4")  # replaced by the course
        self._chain = Chain(settings, interference=self._interfere)
        self._chain.recorder = _Forgetful(TICK, (), "")
        self._zmp: Array | None = None
        self._polygon: Array | None = None
        self._odometry: Odometry | None = None
        self._margin = math.inf
        self._inside = True

    def run(self, until: float) -> Ending:
        """Goes on until a time or a fall."""
        chain = self._chain
        while chain.tick < round(until / TICK) and chain.simulator.fall is None:
            self._zmp = self._polygon = None
            chain.advance()
            if self._zmp is not None and self._polygon is not None:
                margin = polygon_margin(self._polygon, self._zmp)
                self._margin, self._inside = min(self._margin, margin), margin > 0.0
        return self._ending()

    def branch(self, until: float, push: Push) -> Ending:
        """How it would go on with a push; this trial itself stays where it is."""
        here, there = multiprocessing.Pipe(duplex=False)
        process = multiprocessing.get_context("fork").Process(target=self._branch, args=(until, push, there))
        process.start()
        there.close()
        ending: Ending = here.recv()
        process.join()
        return ending

    def close(self) -> None:
        """Ends the physics engine."""
        self._chain.close()

    def _branch(self, until: float, push: Push, out: Connection) -> None:
        self.course.push = push
        self._margin = math.inf
        out.send(self.run(until))

    def _interfere(self, topic: str, tick: int, sample: Any) -> Any:
        sample = self.course(topic, tick, sample)
        if topic == "zmp" and sample is not None:
            self._zmp = sample.xyz[:2]
        elif topic == "support_polygon" and isinstance(sample, Polygon):
            self._polygon = np.ascontiguousarray(sample.vertices[:, :2])
        elif topic == "odom":
            self._odometry = sample
        return sample

    def _ending(self) -> Ending:
        chain, odometry = self._chain, self._odometry
        if odometry is None:
            raise RuntimeError("a run has a state")
        x, y, z, w = odometry.quat_xyzw
        tilt = math.acos(min(1.0, max(-1.0, 1.0 - 2.0 * (x * x + y * y))))
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        fall = chain.simulator.fall
        motion = chain.components["motion_composition"].diagnostics()
        legs = chain.components["leg_controller"].diagnostics()
        return Ending(
            time=chain.tick * TICK,
            fall="" if fall is None else f"{fall.reason} at {fall.time:.2f} s",
            margin=self._margin,
            settled=fall is None and tilt < UPRIGHT and self._inside,
            steps=int(motion["half_steps"]),
            place=np.array([*odometry.position[:2], yaw]),
            voltage=float(legs["peak_voltage [V]"]),
        )


class _Forgetful(RunRecorder):
    """Keeps nothing: five minutes of every sample would fill the memory."""

    def add(self, topic: str, tick: int, sample: Sample) -> None:
        """Nothing."""
