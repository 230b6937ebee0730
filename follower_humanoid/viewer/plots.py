"""Curves beside the scene: the last seconds of forces, gait, ZMP margin, voltage, speed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
import viser
import viser.uplot

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.pictures.palette import AXIS_COLORS, DCM, PCM, SIDE_COLORS, ZMP
from follower_humanoid.viewer.moment import Moment
from follower_humanoid.viewer.telling import tell_data

WINDOW = 12.0
"""Length of the curves [s]."""
STEP = 0.05
"""Time between two points of a curve [s]."""
_GAP = 1.0  # a longer silence parts the curves [s]
_HEIGHT = 140  # pixels
_PADDING = (10, 24, 0, 0)  # of a plot, so that the uppermost number is whole [pixels]
# A line that stays at zero lies in the middle of −1 to 1.
_SOFT: Any = {"min": {"soft": -1.0, "mode": 2, "pad": 0.1}, "max": {"soft": 1.0, "mode": 2, "pad": 0.1}}
_SCALES = {"x": viser.uplot.Scale(time=False), "y": viser.uplot.Scale(range=_SOFT)}


@dataclass(frozen=True)
class Curve:
    """One line of a plot: its name, colour, and value at a moment (NaN: none)."""

    name: str
    color: str
    value: Callable[[Moment], float]


Past = Callable[[float, float, float], Iterable[Moment]]
"""What was there after one time and before another, every so many seconds [s]."""


def _gait(name: str) -> Callable[[Moment], float]:
    return lambda moment: getattr(moment["gait"], name) if "gait" in moment else np.nan


def _force(topic: str, axis: int) -> Callable[[Moment], float]:
    return lambda moment: float(moment[topic].force[axis]) if topic in moment else np.nan


PLOTS: Mapping[str, Sequence[Curve]] = {
    **{
        f"Force on the {side.value} hand [N]": [
            Curve(name, color, _force(f"{side.value}_hand/applied", axis))
            for axis, (name, color) in enumerate(zip("xyz", AXIS_COLORS, strict=True))
        ]
        for side in SIDES
    },
    "Gait [of nominal]": [
        Curve("speed", DCM, _gait("walk_speed")),
        Curve("length", PCM, _gait("step_length")),
    ],
    "Weight on the feet [N]": [
        Curve(side.value, SIDE_COLORS[side], _force(f"{side.value}_foot/wrench", 2)) for side in SIDES
    ],
    "ZMP margin [mm]": [Curve("margin", ZMP, lambda moment: 1000.0 * moment.zmp_margin())],
    "Largest voltage [V]": [Curve("voltage", AXIS_COLORS[1], Moment.peak_voltage)],
    "Real-time factor": [Curve("factor", AXIS_COLORS[0], lambda moment: moment.speed)],
}


class Plots:
    """The plots of a page."""

    def __init__(self, gui: viser.GuiApi, without: Sequence[str] = ()) -> None:
        """Adds the plots where the GUI's context is; `without` names those that are left out."""
        self._plots = {title: curves for title, curves in PLOTS.items() if title not in without}
        self._columns = list(pairwise(accumulate(map(len, self._plots.values()), initial=0)))
        self._rows = _Rows(self._columns[-1][1])
        self._handles: list[Any] = []
        for title, curves in self._plots.items():
            series = [viser.uplot.Series(label="t")]
            series += [viser.uplot.Series(label=c.name, stroke=c.color, width=1.5) for c in curves]
            self._handles.append(
                gui.add_uplot(
                    tuple(np.zeros(1) for _ in series),
                    tuple(series),
                    title=title,
                    scales=_SCALES,
                    legend=viser.uplot.Legend(show=len(curves) > 1, live=False),
                    height=_HEIGHT,
                    padding=_PADDING,
                )
            )

    def add(self, moment: Moment, past: Past | None = None) -> bool:
        """Takes a moment in; False where too little time has passed for a new point.

        Args:
            moment: What is seen now.
            past: What was there before, where that is known: curves of a recording have no gaps.
        """
        times = self._rows.times
        last = float(times[-1]) if len(times) else -np.inf
        if last <= moment.time < last + STEP:
            return False
        # Otherwise it is another run, a bag wound to elsewhere, or a page that was closed for long.
        if not last <= moment.time < last + _GAP:
            self._rows.clear()
            last = moment.time - WINDOW
        for before in past(last, moment.time, STEP) if past is not None else ():
            self._append(before)
        self._append(moment)
        self._rows.drop_before(moment.time - WINDOW)
        return True

    def __len__(self) -> int:
        return len(self._plots)

    def show(self, plot: int) -> None:
        """Sends the curves of a plot to the pages."""
        first, end = self._columns[plot]
        times, values = self._rows.times, self._rows.columns[first:end]
        known = np.isfinite(values).all(axis=0)
        if known.any():
            tell_data(self._handles[plot], (times[known], *(column[known] for column in values)))

    def _append(self, moment: Moment) -> None:
        values = [curve.value(moment) for curves in self._plots.values() for curve in curves]
        self._rows.append(moment.time, values)


class _Rows:
    """Numbers at times, the oldest of which are dropped now and then."""

    _ROOM = 1024  # more than twice as many rows as a window holds

    def __init__(self, width: int) -> None:
        self._all = np.empty((1 + width, self._ROOM))
        self._begin = self._end = 0

    @property
    def times(self) -> Array:
        """Of all rows, shape (n,) [s]."""
        return self._all[0, self._begin : self._end]

    @property
    def columns(self) -> Array:
        """The numbers, shape (width, n)."""
        return self._all[1:, self._begin : self._end]

    def append(self, time: float, numbers: Sequence[float]) -> None:
        if self._end == self._ROOM:
            kept = self._all[:, max(self._begin, self._ROOM // 2) :].copy()
            self._begin, self._end = 0, kept.shape[1]
            self._all[:, : self._end] = kept
        self._all[:, self._end] = (time, *numbers)
        self._end += 1

    def drop_before(self, time: float) -> None:
        self._begin += int(np.searchsorted(self.times, time))

    def clear(self) -> None:
        self._begin = self._end = 0
