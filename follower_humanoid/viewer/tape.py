"""A recorded run, moment by moment."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from follower_humanoid.core.samples import Array, Footstep
from follower_humanoid.graph.record import Run, Series
from follower_humanoid.viewer.moment import Moment, Trail, TrailKeeper

SHOWN = (
    "joint_states", "odom", "left_foot/wrench", "right_foot/wrench", "left_hand/applied",
    "right_hand/applied", "base/applied", "gait", "primitives", "footsteps", "zmp", "com", "dcm",
    "support_polygon", "legs/command", "arms/command",
)  # fmt: skip
_LOOK = 0.02  # time between two looks for footprints and path [s]


class Tape:
    """What was seen at any time of a run.

    Attributes:
        run: The run.
        begin, end: Its first and last time [s].
    """

    def __init__(self, run: Run) -> None:
        """Goes once through the run for what it left on the ground."""
        self.run = run
        states = run["joint_states"].times
        self.begin, self.end = float(states[0]), float(states[-1])
        self._series = {name: run[name] for name in SHOWN if name in run}
        self._path_times, self._path = self._walked()
        self._prints = self._stood()

    def moment(self, time: float) -> Moment:
        """What was there at a time [s]: of every topic the last sample before it."""
        stamp = round(time * 1e9)
        samples: dict[str, Any] = {}
        for name, series in self._series.items():
            row = int(np.searchsorted(series.stamps, stamp, side="right")) - 1
            if row >= 0 or name in ("joint_states", "odom"):
                samples[name] = _sample(series, max(row, 0))
        return Moment(time, samples)

    def moments(self, after: float, before: float, step: float) -> Iterator[Moment]:
        """What was there after a time and before another, every `step` [s]."""
        count = int((before - after) / step - 1e-6)
        times = (after + step * number for number in range(1, count + 1))
        return (self.moment(time) for time in times if time >= self.begin)

    def trail(self, time: float) -> Trail:
        """What lay on the ground at a time [s]."""
        count = int(np.searchsorted(self._path_times, time, side="right"))
        return Trail(self._path[:count], tuple(step for since, step in self._prints if since <= time))

    def _walked(self) -> tuple[Array, Array]:
        odometry = self.run["odom"]
        every = max(1, round(_LOOK / self.run.tick))
        times, places = odometry.times[::every], odometry.position[::every]
        kept = [0]
        for row in range(1, len(places)):
            if np.linalg.norm(places[row, :2] - places[kept[-1], :2]) > TrailKeeper.STRIDE:
                kept.append(row)
        return times[kept], places[kept]

    def _stood(self) -> list[tuple[float, Footstep]]:
        if "footsteps" not in self.run:
            return []
        keeper, found = TrailKeeper(), []
        series = self.run["footsteps"]
        for time, sample in zip(series.times, series.samples, strict=True):
            before = len(keeper.trail.prints)
            prints = keeper.add(Moment(float(time), {"footsteps": sample})).prints
            found += [(float(time), step) for step in prints[before:]]
        return found


def _sample(series: Series, row: int) -> Any:
    if series.samples:
        return series.samples[row]
    values: dict[str, Any] = {name: values[row] for name, values in series.fields.items()}
    kind = series.topic.kind
    wanted = {field.name for field in dataclasses.fields(kind)}
    values = {name: v if np.ndim(v) else float(v) for name, v in values.items() if name in wanted}
    values.update({name: words[row] for name, words in series.texts.items()})
    return kind(**values)
