"""ZMP and CoM over time, against the support polygon."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from follower_humanoid.balance.support_polygon import convex_hull, polygon_margin
from follower_humanoid.core.samples import Array
from follower_humanoid.graph.record import Run, Series
from follower_humanoid.pictures.palette import BAND, COMMAND, PCM, PLAN, ZMP
from follower_humanoid.pictures.style import View, end_of, figure, legend, stacked_axes


def zmp_figure(compared: Sequence[View]) -> Figure:
    """ZMP and CoM over time, and how far the ZMP stays inside the support polygon."""
    fig = figure(5.4)
    rows = stacked_axes(fig, 3, end_of(compared), (3, 2, 1.4))
    several = len(compared) > 1
    for view in compared:
        for axis, axes in enumerate(rows[:2]):
            _draw_zmp(axes, view, axis, several)
        times, margins = zmp_margins(view.run)
        rows[2].plot(times, 1000 * margins, color=view.color if several else ZMP, linewidth=0.8)
    rows[0].set(ylabel="x [m]")
    rows[1].set(ylabel="y [m]")
    rows[2].set(ylabel="margin [mm]")
    rows[2].set_ylim(bottom=min(0.0, rows[2].get_ylim()[0]))
    rows[0].set_title("ZMP over time" if several else "ZMP and projection of the CoM over time", loc="left")
    legend(rows[0])
    return fig


def _draw_zmp(axes: Axes, view: View, axis: int, several: bool) -> None:
    run = view.run
    if several:
        if "zmp" in run:
            axes.plot(run["zmp"].times, run["zmp"].xyz[:, axis], color=view.color, label=view.label)
        return
    if "support_polygon" in run:
        times, low, high = polygon_extent(run["support_polygon"], axis)
        axes.fill_between(
            times, low, high, color=BAND, linewidth=0.0, alpha=0.7, label="support", step="post"
        )
    for topic, color, style, label in (
        ("zmp_reference", PLAN, ":", "ZMP planned"),
        ("zmp_command", COMMAND, "-", "ZMP commanded"),
        ("zmp", ZMP, "-", "ZMP measured"),
        ("com", PCM, "-", "PCM"),
    ):
        if topic in run:
            axes.plot(run[topic].times, run[topic].xyz[:, axis], style, color=color, label=label)


def polygon_extent(series: Series, axis: int) -> tuple[Array, Array, Array]:
    """Times [s] and smallest and largest coordinate of the support polygon [m], NaN without one."""
    extents = np.full((len(series.samples), 2), np.nan)
    for row, polygon in enumerate(series.samples):
        if len(polygon.vertices):
            column = polygon.vertices[:, axis]
            extents[row] = column.min(), column.max()
    return series.times, extents[:, 0], extents[:, 1]


def zmp_margins(run: Run) -> tuple[Array, Array]:
    """Times [s] and distance of the measured ZMP to the edge of the published support polygon [m].

    At the instants of the polygon; NaN where one of the two is missing.
    """
    if "support_polygon" not in run or "zmp" not in run:
        return np.zeros(0), np.zeros(0)
    polygons = run["support_polygon"]
    zmp = run["zmp"].held("xyz", polygons.ticks)[:, :2]
    every = max(1, round(0.01 / run.tick) if len(polygons) > 1 and np.diff(polygons.ticks[:2])[0] == 1 else 1)
    rows = range(0, len(polygons), every)
    margins = np.full(len(rows), np.nan)
    for target, row in enumerate(rows):
        vertices = polygons.samples[row].vertices[:, :2]
        if len(vertices) > 2 and np.isfinite(zmp[row]).all():
            margins[target] = polygon_margin(convex_hull(vertices), zmp[row])
    return polygons.times[::every], margins
