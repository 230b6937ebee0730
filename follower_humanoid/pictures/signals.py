"""Curves over time: what pulls, how the gait follows, what the feet carry, what the motors get."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.palette import AXIS_COLORS, LEFT, MIDDLE, RIGHT, SIDE_COLORS
from follower_humanoid.pictures.style import View, end_of, figure, legend, stacked_axes, widen

LIMBS = ("left leg", "right leg", "trunk and neck", "left arm", "right arm")


def gait_figure(compared: Sequence[View]) -> Figure:
    """Forces on the hands and the walking parameters they lead to."""
    several = len(compared) > 1
    forces = 1 if several else 2
    fig = figure(1.25 * (forces + 3))
    rows = stacked_axes(fig, forces + 3, end_of(compared))
    length, speed, direction = rows[-3:]
    for view in compared:
        if several:
            _draw_total_force(rows[0], view)
        else:
            _draw_hand_forces(rows[:2], view.run)
        if "gait" not in view.run:
            continue
        gait = view.run["gait"]
        color = view.color if several else MIDDLE
        length.plot(gait.times, gait.step_length, color=color)
        speed.plot(gait.times, gait.walk_speed, color=color)
        for name, style, own in (("walk_dir", "-", LEFT), ("heading", "--", RIGHT)):
            label = f"{view.label} {name}" if several else name
            color = view.color if several else own
            direction.plot(gait.times, np.degrees(gait.fields[name]), style, color=color, label=label)
    length.set_ylabel("step length\n[of nominal]")
    speed.set_ylabel("walk speed\n[of nominal]")
    direction.set_ylabel("direction [°]")
    for axes in (length, speed):
        axes.set_ylim(0.0, 1.4)
    widen(direction, 10.0)
    what = "Horizontal pull of both hands" if several else "Forces on the hands (bold: applied, thin: sensed)"
    rows[0].set_title(f"{what} and walking parameters", loc="left")
    for axes in (*rows[:forces], direction):
        legend(axes)
    return fig


def _draw_total_force(axes: Axes, view: View) -> None:
    run = view.run
    if all(f"{side.value}_hand/applied" in run for side in SIDES):
        left, right = (run[f"{side.value}_hand/applied"] for side in SIDES)
        total = left.force + right.held("force", left.ticks)
        axes.plot(left.times, np.hypot(total[:, 0], total[:, 1]), color=view.color, label=view.label)
    axes.set_ylabel("force [N]")


def _draw_hand_forces(rows: Sequence[Axes], run: Run) -> None:
    for axes, side in zip(rows, SIDES, strict=True):
        for axis, (name, color) in enumerate(zip("xyz", AXIS_COLORS, strict=True)):
            sensed, applied = f"{side.value}_hand/wrench", f"{side.value}_hand/applied"
            if sensed in run:
                axes.plot(
                    run[sensed].times, run[sensed].force[:, axis], color=color, linewidth=0.5, alpha=0.6
                )
            if applied in run:
                axes.plot(run[applied].times, run[applied].force[:, axis], color=color, label=f"$f_{name}$")
        axes.set_ylabel(f"{side.value} hand\n[N]")
        widen(axes, 2.0)


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
    fig = figure(7.6)
    rows = stacked_axes(fig, len(LIMBS), end_of(compared))
    several = len(compared) > 1
    for axes, limb in zip(rows, LIMBS, strict=True):
        for view in compared:
            times, names, volts = limb_voltages(view, limb)
            if several:
                axes.plot(
                    times, np.max(np.abs(volts), axis=1), color=view.color, label=view.label, linewidth=0.7
                )
            else:
                _draw_voltages(axes, times, names, volts)
        axes.set_ylabel(f"{limb}\n{'largest ' if several else ''}[V]")
        if several:
            axes.set_ylim(bottom=0.0)
        else:
            legend(axes)
    if several:
        legend(rows[0])
    rows[0].set_title("Joint voltages", loc="left")
    return fig


def _draw_voltages(axes: Axes, times: Array, names: list[str], volts: Array) -> None:
    """One curve per joint; those of the spine share a colour and a name by axis."""
    shared: dict[str, str] = {}
    for column, name in enumerate(names):
        label, color = name, f"C{column}"
        if name.startswith("spine"):
            label = f"spine {name.rpartition(' ')[2]}"
            color = AXIS_COLORS[("roll", "pitch", "yaw").index(name.rpartition(" ")[2])]
        label = "_" if label in shared else label
        shared[label] = color
        axes.plot(times, volts[:, column], label=label, color=color, linewidth=0.7)
    widen(axes, 1.0)


def limb_voltages(view: View, limb: str) -> tuple[Array, list[str], Array]:
    """Times [s], joint names and motor voltages of a limb, shape (T, n) [V]."""
    arms = limb.endswith("arm")
    series = view.run["arms/command" if arms else "legs/command"]
    names = view.body.command_joints(arms)
    prefix = "" if limb.startswith("trunk") else limb[0] + "_"
    columns = [index for index, name in enumerate(names) if _prefix(name) == prefix]
    shown = [names[column].removeprefix(prefix).replace("_", " ") for column in columns]
    return series.times, shown, series.effort[:, columns]


def _prefix(joint: str) -> str:
    return joint[:2] if joint.startswith(("l_", "r_")) else ""
