"""The half-steps of a run with what the planner said of them, and the table they make."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from follower_humanoid.graph.half_steps import HalfStep, half_steps
from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.body import Body

# A planned step nearer to where the foot landed than this is the same one [m].
_SAME_PLACE = 0.15
# The planner's word of a landing is out by then [s].
_TOLD = 0.3


@dataclass(frozen=True)
class Step(HalfStep):
    """One half-step.

    Attributes:
        duration: From the landing before it, or from the first shift of weight after a rest [s].
    """

    duration: float


def find_steps(run: Run, body: Body) -> tuple[Step, ...]:
    """Every half-step in the order of landing; the planner says which are counted, where it was heard."""
    steps: list[Step] = []
    for found in half_steps(run, body.sole):
        begin = _begin(run, steps[-1].landing if steps else 0.0, found)
        values = {field.name: getattr(found, field.name) for field in dataclasses.fields(HalfStep)}
        values["counted"] = _counted(run, found)
        steps.append(Step(**values, duration=found.landing - begin))
    return tuple(steps)


def _begin(run: Run, last_landing: float, step: HalfStep) -> float:
    """When a half-step began: with the landing before it, or when its first primitive did after a rest."""
    if "primitives" in run:
        series = run["primitives"]
        before = (series.times > last_landing) & (series.times < step.lift_off)
        idle = [
            time
            for time, index in zip(series.times[before], np.flatnonzero(before), strict=True)
            if not series.samples[index].names
        ]
        return float(idle[-1]) if idle else last_landing
    rested = step.lift_off - last_landing >= step.landing - step.lift_off
    return step.lift_off if rested else last_landing


def _counted(run: Run, found: HalfStep) -> bool:
    if "footsteps" in run:
        series = run["footsteps"]
        after = int(np.searchsorted(series.times, found.landing + _TOLD, side="right"))
        for sample in series.samples[:after][::-1]:
            for step in sample.steps[::-1]:
                near = np.linalg.norm(step.position[:2] - found.position[:2]) < _SAME_PLACE
                if step.side is found.side and near:
                    return bool(step.counted)
    return found.counted


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
                f"{step.lift_off:.2f}",
                f"{step.landing:.2f}",
                f"{step.duration:.2f}",
                f"{step.length:.3f}",
                f"{abs(step.width):.3f}",
                f"{round(math.degrees(step.heading), 1) + 0.0:.1f}",
                "step" if step.counted else "closing",
            )
        )
    return rows
