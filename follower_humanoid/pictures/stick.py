"""The stick diagram: the body seen from the side, drawn over the ground it walked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from follower_humanoid.pictures.palette import LEFT, MIDDLE, RIGHT
from follower_humanoid.pictures.style import WIDTH, View, figure

_COLORS = {"l": LEFT, "r": RIGHT, "": MIDDLE}
_MARGIN = 0.3
_TOP = 1.7


def draw_sticks(axes: Axes, view: View, period: float) -> None:
    """One run's sticks in the x–z plane of the world.

    Args:
        axes: Where to draw.
        view: The run.
        period: Time between two sticks [s].
    """
    lines = view.body.lines(view.every(period))
    across = lines.ends[..., [0, 2]]
    # The far side is drawn first, the near side over it.
    for side in ("l", "", "r"):
        chosen = [index for index, name in enumerate(lines.sides) if name == side]
        segments = across[:, chosen].reshape(-1, 2, 2)
        axes.add_collection(LineCollection(list(segments), colors=_COLORS[side], linewidths=0.6, alpha=0.75))
    axes.axhline(0.0, color="#888888", linewidth=0.8)
    left, right = float(np.min(across[..., 0])), float(np.max(across[..., 0]))
    axes.set_xlim(left - _MARGIN, right + _MARGIN)
    axes.set_ylim(-0.08, _TOP)
    axes.set_aspect("equal")
    axes.set_ylabel("z [m]")


def stick_figure(compared: Sequence[View], period: float = 0.5) -> Figure:
    """Stick diagrams, one below the other where several runs are compared."""
    reach = [_reach(view) for view in compared]
    height = sum((WIDTH - 0.7) * (_TOP + 0.08) / span + 0.45 for span in reach) + 0.2
    fig = figure(height)
    rows = fig.subplots(len(compared), 1, squeeze=False)[:, 0]
    for axes, view in zip(rows, compared, strict=True):
        draw_sticks(axes, view, period)
        title = f"Stick diagram, every {period:g} s"
        axes.set_title(title if len(compared) == 1 else f"{title}: {view.label}", loc="left")
    rows[-1].set_xlabel("x [m]")
    handles = [
        Line2D([], [], color=color, label=label) for color, label in ((LEFT, "left"), (RIGHT, "right"))
    ]
    rows[0].legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    return fig


def _reach(view: View) -> float:
    x = view.run["odom"].position[:, 0]
    return float(np.ptp(x)) + 2 * _MARGIN + 0.5
