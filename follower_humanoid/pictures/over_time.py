"""Curves over time: ZMP and CoM, forces and walking parameters, foot forces, primitives, voltages."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from follower_humanoid.balance.zmp import convex_hull, polygon_margin
from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.graph.record import Run, Series
from follower_humanoid.pictures.style import (
    BAND,
    COMMAND,
    MIDDLE,
    PCM,
    PLAN,
    SIDE_COLORS,
    ZMP,
    View,
    figure,
    legend,
    stacked_axes,
)

_AXIS_NAMES = "xyz"


def end_of(compared: Sequence[View]) -> float:
    """End of the longest run [s]."""
    return max(view.run.duration for view in compared)


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


def gait_figure(compared: Sequence[View]) -> Figure:
    """Forces on the hands and the walking parameters they lead to."""
    several = len(compared) > 1
    fig = figure(6.2)
    rows = stacked_axes(fig, 4 if several else 5, end_of(compared))
    for view in compared:
        _draw_forces(rows, view, several)
        axes = rows[-3:]
        run = view.run
        if "gait" not in run:
            continue
        gait = run["gait"]
        names = (("step_length", "length factor"), ("walk_speed", "speed factor"))
        for name, label in names:
            style = {"color": view.color, "label": view.label} if several else {"label": label}
            axes[0 if name == "step_length" else 1].plot(gait.times, gait.fields[name], **style)
        for name, style_ in (("walk_dir", "-"), ("heading", "--")):
            label = f"{view.label} {name}" if several else name
            color = view.color if several else None
            axes[2].plot(gait.times, np.degrees(gait.fields[name]), style_, color=color, label=label)
    rows[-3].set_ylabel("step length\n[of nominal]")
    rows[-2].set_ylabel("walking speed\n[of nominal]")
    rows[-1].set_ylabel("direction [°]")
    for axes in rows[-3:-1]:
        axes.set_ylim(bottom=0.0)
    rows[0].set_title("Forces on the hands and walking parameters", loc="left")
    for axes in (*rows[:-3], rows[-1]):
        legend(axes)
    return fig


def _draw_forces(rows: list[Axes], view: View, several: bool) -> None:
    """Per hand the components, or for comparisons the horizontal size of both hands' sum."""
    run = view.run
    if several:
        total = sum(run[f"{side.value}_hand/applied"].force for side in SIDES)
        times = run["left_hand/applied"].times
        rows[0].plot(times, np.hypot(total[:, 0], total[:, 1]), color=view.color, label=view.label)
        rows[0].set_ylabel("horizontal\nforce [N]")
        return
    for axes, side in zip(rows[:2], SIDES, strict=True):
        for axis, name in enumerate(_AXIS_NAMES):
            color = f"C{axis}"
            sensed, applied = f"{side.value}_hand/wrench", f"{side.value}_hand/applied"
            if sensed in run:
                axes.plot(
                    run[sensed].times, run[sensed].force[:, axis], color=color, linewidth=0.5, alpha=0.5
                )
            if applied in run:
                axes.plot(run[applied].times, run[applied].force[:, axis], color=color, label=f"f{name}")
        axes.set_ylabel(f"{side.value} hand [N]")


def feet_figure(compared: Sequence[View]) -> Figure:
    """Vertical foot forces and the motion primitives that are active."""
    names = _primitive_names(compared[0].run) if len(compared) == 1 else []
    fig = figure(2.4 + 0.16 * len(names))
    rows = stacked_axes(
        fig, 2 if names else 1, end_of(compared), (2, 0.3 + 0.17 * len(names)) if names else None
    )
    for view in compared:
        for side, style in zip(SIDES, ("-", "--"), strict=True):
            wrench = view.run[f"{side.value}_foot/wrench"]
            several = len(compared) > 1
            label = f"{view.label} {side.value}" if several else side.value
            color = view.color if several else SIDE_COLORS[side]
            line = style if several else "-"
            rows[0].plot(wrench.times, wrench.force[:, 2], line, color=color, label=label, linewidth=0.8)
    rows[0].set_ylabel("vertical foot force [N]")
    rows[0].set_title("Foot forces and motion primitives" if names else "Foot forces", loc="left")
    legend(rows[0])
    if names:
        _draw_primitives(rows[1], compared[0].run, names)
    return fig


def _primitive_names(run: Run) -> list[str]:
    if "primitives" not in run:
        return []
    return list(dict.fromkeys(name for sample in run["primitives"].samples for name in sample.names))


def _draw_primitives(axes: Axes, run: Run, names: list[str]) -> None:
    """A bar while a primitive is active, the darker the further it has come."""
    series = run["primitives"]
    every = max(1, len(series) // 1500)
    completion = np.full((len(names), len(range(0, len(series), every))), np.nan)
    for column, sample in enumerate(series.samples[::every]):
        for name, value in zip(sample.names, sample.completion, strict=True):
            completion[names.index(name), column] = value
    edges = np.append(series.times[::every], series.times[-1])
    axes.pcolormesh(
        edges, np.arange(len(names) + 1), completion, cmap="Blues", vmin=-0.35, vmax=1.0, rasterized=True
    )
    axes.set_yticks(np.arange(len(names)) + 0.5, names)
    axes.set_ylim(len(names), 0)
    axes.grid(visible=False)


def voltage_figure(compared: Sequence[View]) -> Figure:
    """Motor voltages by limb; for comparisons the largest of each limb."""
    limbs = ("left leg", "right leg", "trunk and neck", "left arm", "right arm")
    fig = figure(7.6)
    rows = stacked_axes(fig, len(limbs), end_of(compared))
    several = len(compared) > 1
    for view in compared:
        for axes, limb in zip(rows, limbs, strict=True):
            times, names, volts = limb_voltages(view, limb)
            if several:
                axes.plot(
                    times, np.max(np.abs(volts), axis=1), color=view.color, label=view.label, linewidth=0.7
                )
                continue
            for column, name in enumerate(names):
                axes.plot(times, volts[:, column], label=name, linewidth=0.7)
    for axes, limb in zip(rows, limbs, strict=True):
        axes.set_ylabel(f"{limb}\n{'largest ' if several else ''}[V]")
        if not several and axes.lines:
            legend(axes, 2 if len(axes.lines) > 8 else 1)
    if several:
        legend(rows[0])
    rows[0].axhline(0.0, color=MIDDLE, linewidth=0.4)
    rows[0].set_title("Joint voltages", loc="left")
    return fig


def limb_voltages(view: View, limb: str) -> tuple[Array, list[str], Array]:
    """Times [s], joint names and motor voltages of a limb, shape (T, n) [V]."""
    arms = limb.endswith("arm")
    series = view.run["arms/command" if arms else "legs/command"]
    names = view.body.command_joints(arms)
    if limb.startswith("trunk"):
        columns = [index for index, name in enumerate(names) if not name.startswith(("l_", "r_"))]
    else:
        columns = [index for index, name in enumerate(names) if name.startswith(limb[0] + "_")]
    shown = [names[column].removeprefix(limb[0] + "_").replace("_", " ") for column in columns]
    return series.times, shown, series.effort[:, columns]
