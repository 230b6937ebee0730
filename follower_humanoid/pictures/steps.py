"""The half-steps of a run, as the feet made them: from the measured foot forces and the soles' places."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.graph.record import NANOSECONDS, Run
from follower_humanoid.pictures.body import Body

# A foot with less than this is in the air; shorter interruptions are bouncing, not steps.
CARRYING = 20.0
_SHORTEST = 0.1
# The foot is measured when it has come to rest.
_SETTLE = 0.3
# Without the planner's word, a step shorter than this along the heading only closes the feet.
_CLOSING = 0.05
_SAME_PLACE = 0.15


@dataclass(frozen=True)
class Step:
    """One half-step.

    Attributes:
        side: The foot that moved.
        lifted, landed: When it left the ground and came back [s].
        position: Sole origin after landing, shape (3,), in world [m].
        yaw: Heading of the foot in world [rad].
        length: Distance of the two sole origins along that heading [m].
        width: Distance across it, positive to the left [m].
        duration: From the landing before it, or from the first shift of weight after a rest [s].
        counted: False where the step only brings the feet together.
    """

    side: Side
    lifted: float
    landed: float
    position: Array
    yaw: float
    length: float
    width: float
    duration: float
    counted: bool


def find_steps(run: Run, body: Body) -> tuple[Step, ...]:
    """Every half-step in the order of landing."""
    swings = sorted(
        ((lifted, landed, side) for side in SIDES for lifted, landed in swing_times(run, side)),
        key=lambda swing: swing[1],
    )
    steps: list[Step] = []
    for number, (lifted, landed, side) in enumerate(swings):
        later = [swing[0] for swing in swings[number + 1 :] if swing[0] >= landed]
        rest = min([landed + _SETTLE, *later, run.duration])
        tick = np.array([round(rest / run.tick)])
        foot, other = body.sole(side, tick), body.sole(side.other, tick)
        yaw = float(foot.yaw[0])
        forward, left = (math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))
        apart = foot.position[0, :2] - other.position[0, :2]
        length = float(apart @ forward)
        since = _begin(run, steps[-1].landed if steps else 0.0, lifted, landed)
        counted = _counted(run, side, foot.position[0], landed, length)
        width = float(apart @ left)
        steps.append(
            Step(side, lifted, landed, foot.position[0], yaw, length, width, landed - since, counted)
        )
    return tuple(steps)


def swing_times(run: Run, side: Side) -> list[tuple[float, float]]:
    """When a foot left the ground and came back [s], bouncing left out."""
    series = run[f"{side.value}_foot/wrench"]
    shortest = round(_SHORTEST / run.tick)
    in_air = _without_short(series.force[:, 2] < CARRYING, shortest)
    edges = np.diff(in_air.astype(np.int8))
    times = series.stamps / NANOSECONDS
    lifted = [float(times[index + 1]) for index in np.flatnonzero(edges > 0)]
    landed = [float(times[index + 1]) for index in np.flatnonzero(edges < 0)]
    if len(in_air) and in_air[0]:
        landed = landed[1:]
    return list(zip(lifted, landed, strict=False))


def _without_short(flags: NDArray[np.bool_], shortest: int) -> NDArray[np.bool_]:
    """Flags with runs shorter than `shortest` turned over, first those that are set."""
    flags = flags.copy()
    for value in (True, False):
        edges = np.flatnonzero(np.diff(flags)) + 1
        for begin, end in zip([0, *edges], [*edges, len(flags)], strict=True):
            inside = begin > 0 and end < len(flags)
            if inside and flags[begin] == value and end - begin < shortest:
                flags[begin:end] = not value
    return flags


def _begin(run: Run, last_landing: float, lifted: float, landed: float) -> float:
    """When a half-step began: with the landing before it, or when its first primitive did after a rest."""
    if "primitives" in run:
        series = run["primitives"]
        before = (series.times > last_landing) & (series.times < lifted)
        idle = [
            time
            for time, index in zip(series.times[before], np.flatnonzero(before), strict=True)
            if not series.samples[index].names
        ]
        return float(idle[-1]) if idle else last_landing
    return last_landing if lifted - last_landing < landed - lifted else lifted


def _counted(run: Run, side: Side, position: Array, landed: float, length: float) -> bool:
    if "footsteps" in run:
        series = run["footsteps"]
        after = int(np.searchsorted(series.times, landed + _SETTLE, side="right"))
        for sample in series.samples[:after][::-1]:
            for step in sample.steps[::-1]:
                near = np.linalg.norm(step.position[:2] - position[:2]) < _SAME_PLACE
                if step.side is side and near:
                    return bool(step.counted)
    return abs(length) > _CLOSING


COLUMNS = (
    "step",
    "foot",
    "lifted [s]",
    "landed [s]",
    "half-step [s]",
    "length [m]",
    "width [m]",
    "heading [°]",
    "kind",
)


def table_rows(steps: tuple[Step, ...]) -> list[tuple[str, ...]]:
    """The steps as text under `COLUMNS`; counted ones are numbered."""
    rows: list[tuple[str, ...]] = []
    number = 0
    for step in steps:
        number += step.counted
        rows.append(
            (
                str(number) if step.counted else "–",
                step.side.value,
                f"{step.lifted:.2f}",
                f"{step.landed:.2f}",
                f"{step.duration:.2f}",
                f"{step.length:.3f}",
                f"{abs(step.width):.3f}",
                f"{round(math.degrees(step.yaw), 1) + 0.0:.1f}",
                "step" if step.counted else "closing",
            )
        )
    return rows
