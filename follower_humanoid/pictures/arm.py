"""Figures of an arm experiment: stick diagram of the arm, forces on the hand, elbow (figs. 1 to 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from follower_humanoid.control.arm_modes import COMPENSATION
from follower_humanoid.core.samples import Array
from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.palette import AXIS_COLORS, BAND, COMMAND, LEFT, MIDDLE, PLAN
from follower_humanoid.pictures.style import View, end_of, figure, legend, stacked_axes, widen

TARGET = "left_hand/target"
_CHAIN = ("l_upper_arm", "l_forearm", "l_wrist", "l_gripper")
_ELBOW = "l_elbow"


def arm_sticks_figure(compared: Sequence[View], period: float = 0.25) -> Figure:
    """The left arm from the side, and the hand's path as one looks at the board from behind the robot."""
    fig = figure(3.4 * len(compared))
    rows = fig.subplots(len(compared), 2, squeeze=False)
    for (side, front), view in zip(rows, compared, strict=True):
        _draw_arm(side, view, period)
        _draw_path(front, view)
        title = f"Left arm, every {period:g} s"
        side.set_title(title if len(compared) == 1 else f"{title}: {view.label}", loc="left")
        front.set_title("Path of the hand", loc="left")
    return fig


def _draw_arm(axes: Axes, view: View, period: float) -> None:
    ticks = view.every(period)
    points = np.stack([view.body.pose(frame, ticks).position for frame in _CHAIN], axis=1)
    sticks = points[..., [0, 2]]
    axes.add_collection(LineCollection(list(sticks), colors=LEFT, linewidths=0.7, alpha=0.7))
    axes.plot(*sticks[:, -1].T, ".", color=MIDDLE, markersize=3)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")


def _draw_path(axes: Axes, view: View) -> None:
    ticks = view.every(0.01)
    hand, base = view.body.pose("l_gripper", ticks).position, view.body.pose("base_link", ticks).position
    planned = view.run[TARGET].position + base[0]
    axes.plot(planned[:, 1], planned[:, 2], color=COMMAND, linewidth=2.5, label="target")
    axes.plot(hand[:, 1], hand[:, 2], color=PLAN, linewidth=0.9, label="hand")
    axes.set_aspect("equal", adjustable="datalim")
    axes.invert_xaxis()  # left is left
    axes.set_xlabel("y [m]")
    axes.set_ylabel("z [m]")
    axes.legend(loc="best")


def hand_force_figure(compared: Sequence[View]) -> Figure:
    """Force on the left hand along x, y and z, as sensed and as it was."""
    fig = figure(5.2)
    rows = stacked_axes(fig, 3, end_of(compared))
    for view in compared:
        for axis, (axes, color) in enumerate(zip(rows, AXIS_COLORS, strict=True)):
            _draw_force(axes, view, axis, color if len(compared) == 1 else view.color, len(compared) > 1)
    for name, axes in zip("xyz", rows, strict=True):
        axes.set_ylabel(f"$F_{name}$ [N]")
        widen(axes, 1.0)
    _shade(rows, compared)
    rows[0].set_title("Force on the left hand", loc="left")
    legend(rows[0])
    return fig


def _draw_force(axes: Axes, view: View, axis: int, color: str, several: bool) -> None:
    run, prefix = view.run, f"{view.label} " if several else ""
    sensed = run["left_hand/wrench"]
    axes.plot(sensed.times, sensed.force[:, axis], color=color, label=f"{prefix}sensed")
    acting = [run[name] for name in ("left_hand/contact", "left_hand/applied") if name in run]
    if acting:
        total = sum(series.held("force", acting[0].ticks)[:, axis] for series in acting)
        axes.plot(acting[0].times, total, color=MIDDLE, linewidth=0.5, label=f"{prefix}acting")


def elbow_figure(compared: Sequence[View]) -> Figure:
    """Velocity and torque of the left elbow; shaded while the hand is led."""
    fig = figure(3.8)
    rows = stacked_axes(fig, 2, end_of(compared))
    for view in compared:
        joints = view.run["joint_states"]
        column = view.run.joint_names.index(_ELBOW)
        color = LEFT if len(compared) == 1 else view.color
        rows[0].plot(joints.times, joints.velocity[:, column], color=color, label=view.label)
        rows[1].plot(joints.times, joints.effort[:, column], color=color)
    rows[0].set_ylabel("velocity [rad/s]")
    rows[1].set_ylabel("torque [N·m]")
    for axes in rows:
        widen(axes, 0.1)
    _shade(rows, compared)
    rows[0].set_title("Left elbow (shaded: controlled gravity compensation)", loc="left")
    if len(compared) > 1:
        legend(rows[0])
    return fig


def _shade(rows: Sequence[Axes], compared: Sequence[View]) -> None:
    """Marks when the left hand of the first run is in gravity compensation."""
    for begin, end in _led_times(compared[0].run):
        for axes in rows:
            axes.axvspan(begin, end, color=BAND, alpha=0.6, linewidth=0)


def _led_times(run: Run) -> list[tuple[float, float]]:
    if "arms/mode" not in run:
        return []
    series = run["arms/mode"]
    led = [any(COMPENSATION in name and name.startswith("left") for name in s.names) for s in series.samples]
    change: Array = np.diff(np.array([False, *led, False]).astype(np.int8))
    times: Array = np.append(series.times, run.duration)
    return list(zip(times[change == 1].tolist(), times[change == -1].tolist(), strict=True))
