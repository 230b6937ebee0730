"""How all figures look: colours with a meaning, axes with units, figures made without a display."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from follower_humanoid.core.samples import SIDES
from follower_humanoid.graph.record import Integers, Run
from follower_humanoid.pictures.body import Body
from follower_humanoid.pictures.steps import Step, find_steps

RUN_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC3377", "#E69F00", "#56B4E9", "#000000")

FEET = tuple(f"{side.value}_foot/wrench" for side in SIDES)

WIDTH = 7.2  # inches: a page's text width
RC: dict[Any, Any] = {
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 8.5,
    "axes.grid": True,
    "grid.color": "#E8E8E8",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "lines.linewidth": 1.1,
    "savefig.dpi": 160,
    "pdf.fonttype": 42,
}


@dataclass(frozen=True)
class View:
    """A run as the figures see it.

    Attributes:
        label: Name in legends.
        run: What was recorded.
        body: Forward kinematics of it.
        color: Of the run where several are compared.
    """

    label: str
    run: Run
    body: Body
    color: str = RUN_COLORS[0]

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        """Half-steps in the order of landing; none where the feet were not recorded."""
        if any(topic not in self.run for topic in FEET):
            return ()
        return find_steps(self.run, self.body)

    def every(self, period: float) -> Integers:
        """Ticks at a fixed distance over the whole run; `period` in [s]."""
        ticks = self.run["joint_states"].ticks
        return np.arange(ticks[0], ticks[-1] + 1, max(1, round(period / self.run.tick)), dtype=np.int64)


def views(runs: Sequence[tuple[str, Run]]) -> list[View]:
    """Labelled runs as views, each with a colour of its own."""
    return [
        View(label, run, Body(run), RUN_COLORS[number % len(RUN_COLORS)])
        for number, (label, run) in enumerate(runs)
    ]


def end_of(compared: Sequence[View]) -> float:
    """End of the longest run [s]."""
    return max(view.run.duration for view in compared)


def figure(height: float, width: float = WIDTH) -> Figure:
    """An empty figure; sizes in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def stacked_axes(fig: Figure, rows: int, end: float, heights: Sequence[float] | None = None) -> list[Axes]:
    """Axes below one another with one time axis at the bottom; `end` in [s]."""
    made = fig.subplots(rows, 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    made[-1].set_xlim(0.0, end)
    made[-1].set_xlabel("time [s]")
    fig.align_ylabels(list(made))
    return list(made)


def widen(axes: Axes, least: float) -> None:
    """Shows at least a range of `least`, so that rounding noise does not fill the axes."""
    low, high = axes.get_ylim()
    missing = least - (high - low)
    if missing > 0.0:
        axes.set_ylim(low - missing / 2, high + missing / 2)


def legend(axes: Axes, columns: int = 1) -> None:
    """A legend beside the axes, where it hides no curve."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, ncols=columns)
