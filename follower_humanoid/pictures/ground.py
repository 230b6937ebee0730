"""Seen from above: footprints, support polygons, ZMP and projection of the CoM (PCM)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.pictures.palette import BAND, PCM, SIDE_COLORS, ZMP
from follower_humanoid.pictures.style import WIDTH, View, figure

_MARGIN = 0.12
_NUMBER_AT = (-0.045, 0.028)  # in the sole frame: outside of the heel, clear of the ZMP


def footprints(view: View) -> list[tuple[Side, Array]]:
    """Outlines of the soles where they stood, shape (6, 2) each in world [m]."""
    prints = []
    start = np.array([view.run["joint_states"].ticks[0]])
    for side in SIDES:
        outline = view.body.sole_outline(side)
        pose = view.body.sole(side, start)
        places = [(pose.position[0], float(pose.yaw[0]))]
        places += [(step.position, step.heading) for step in view.steps if step.side is side]
        for position, yaw in places:
            c, s = np.cos(yaw), np.sin(yaw)
            turned = outline[:, :2] @ np.array([[c, s], [-s, c]])
            prints.append((side, turned + position[:2]))
    return prints


def draw_ground(axes: Axes, view: View, own_color: bool) -> None:
    """One run seen from above.

    Args:
        axes: Where to draw.
        view: The run.
        own_color: Everything in the run's colour, for comparisons.
    """
    if not own_color:
        for polygon in _polygons(view):
            axes.add_patch(Polygon(polygon, facecolor=BAND, edgecolor="#BBBBBB", linewidth=0.4, alpha=0.45))
    for side, outline in footprints(view):
        color = view.color if own_color else SIDE_COLORS[side]
        axes.add_patch(Polygon(outline, facecolor="none", edgecolor=color, linewidth=1.0))
    for topic, color in (("com", PCM), ("zmp", ZMP)):
        if topic in view.run and not (own_color and topic == "com"):
            xyz = view.run[topic].xyz
            axes.plot(xyz[:, 0], xyz[:, 1], color=view.color if own_color else color, linewidth=0.8)
    if not own_color:
        for number, step in enumerate((step for step in view.steps if step.counted), start=1):
            c, s = np.cos(step.heading), np.sin(step.heading)
            x, y = _NUMBER_AT[0], step.side.sign * _NUMBER_AT[1]
            place = (step.position[0] + c * x - s * y, step.position[1] + s * x + c * y)
            axes.annotate(
                str(number), place, color=SIDE_COLORS[step.side], ha="center", va="center", fontsize=6
            )


def ground_figure(compared: Sequence[View]) -> Figure:
    """Footprints with support polygons, ZMP and PCM; several runs over one another."""
    outlines = np.concatenate([outline for view in compared for _, outline in footprints(view)])
    low, high = outlines.min(axis=0) - _MARGIN, outlines.max(axis=0) + _MARGIN
    span = high - low
    fig = figure(min(9.0, (WIDTH - 0.7) * span[1] / span[0] + 0.9))
    axes = fig.subplots()
    several = len(compared) > 1
    for view in compared:
        draw_ground(axes, view, own_color=several)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]")
    axes.set_aspect("equal")
    axes.set_title(
        "Footprints and ZMP" if several else "Footprints, support polygons, ZMP and PCM", loc="left"
    )
    if several:
        handles: list[Artist] = [Line2D([], [], color=view.color, label=view.label) for view in compared]
    else:
        handles = [
            Line2D([], [], color=ZMP, label="ZMP"),
            Line2D([], [], color=PCM, label="PCM"),
            Patch(facecolor=BAND, edgecolor="#BBBBBB", label="support"),
        ]
    axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1)
    return fig


def _polygons(view: View) -> list[Array]:
    """The support polygon once in every single and every double support."""
    if "support_polygon" not in view.run:
        return []
    series = view.run["support_polygon"]
    instants = [0.0]
    for number, step in enumerate(view.steps):
        later = [other.lift_off for other in view.steps[number + 1 :]]
        until = min([*later, view.run.duration])
        instants += [(step.lift_off + step.landing) / 2, (step.landing + until) / 2]
    rows = np.maximum(np.searchsorted(series.times, instants, side="right") - 1, 0)
    return [series.samples[row].vertices[:, :2] for row in rows if len(series.samples[row].vertices) > 2]
