"""The three tests by which gains are set, with a picture each (`./scripts/benchmark --tuning DIR`).

As at lipm_walking_controller: push the standing robot, walk in place, walk forward. Each picture shows what
the gains of docs/tuning.md do: DCM against its plan, ZMP against its command, margin, voltages.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from follower_humanoid.bench.disturbances import walk
from follower_humanoid.bench.disturbed import Course, Push
from follower_humanoid.core.samples import Gait
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.simulate import Parameters, simulate
from follower_humanoid.pictures.palette import BAND, COMMAND, DCM, PLAN, ZMP
from follower_humanoid.pictures.style import RC, figure, legend, stacked_axes
from follower_humanoid.pictures.zmp import polygon_extent, zmp_margins

PUSHED = Push(1.0, np.array([0.0, 20.0]))


@dataclass(frozen=True)
class StandardTest:
    """A run and its picture.

    Attributes:
        name: Of the file, too.
        title: Above the picture.
        course: What happens.
        duration: [s]
        parameters: Of the nodes.
    """

    name: str
    title: str
    course: Course
    duration: float
    parameters: Parameters


def in_place(time: float) -> Gait:
    """Steps of no length from 0.5 s on."""
    return Gait(1.0 if time > 0.5 else 0.0, 0.0, 0.0, 1.0, 0.0)


STANDARD_TESTS = (
    StandardTest("push_standing", "20 N·s to the left, standing", Course(push=PUSHED), 4.0, {}),
    StandardTest(
        "walk_in_place", "Walking in place, 0.7 s a step", Course(gait=in_place), 7.0,
        {"motion_composition": {"walker.shortest_half_step": 0.7, "walker.stand_time": 0.7}},
    ),
    StandardTest(
        "walk_forward", "0.5 m/s: 0.35 m in 0.7 s", Course(left=(1.0, 0.0, 0.0)), 7.0, walk(0.35, 0.7)
    ),
)  # fmt: skip


def draw_standard_tests(folder: Path, parameters: Parameters | None = None) -> Iterator[Path]:
    """Runs the tests and writes a PNG each.

    Args:
        folder: Made if it is not there.
        parameters: Gains to try, laid over those of the tests.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for test in STANDARD_TESTS:
        settings = {name: dict(values) for name, values in test.parameters.items()}
        for name, values in (parameters or {}).items():
            settings.setdefault(name, {}).update(values)
        run = simulate("fig4", test.duration, settings, interference=test.course)
        file = folder / f"{test.name}.png"
        with rc_context(RC):
            tuning_figure(run, test.title).savefig(file)
        yield file


def tuning_figure(run: Run, title: str) -> Figure:
    """DCM and ZMP along and across against what was wanted; margin; largest leg voltage."""
    fig = figure(7.0)
    rows = stacked_axes(fig, 4, run.duration, (2, 2, 1, 1))
    for axis, axes in enumerate(rows[:2]):
        times, low, high = polygon_extent(run["support_polygon"], axis)
        axes.fill_between(
            times, low, high, color=BAND, linewidth=0.0, alpha=0.7, label="support", step="post"
        )
        for topic, color, style, label in (
            ("dcm_reference", PLAN, ":", "DCM planned"), ("dcm", DCM, "-", "DCM measured"),
            ("zmp_command", COMMAND, "-", "ZMP commanded"), ("zmp", ZMP, "-", "ZMP measured"),
        ):  # fmt: skip
            series = run[topic]
            axes.plot(series.times, series.xyz[:, axis], style, color=color, label=label)
        axes.set(ylabel=f"{'xy'[axis]} [m]")
    times, margins = zmp_margins(run)
    rows[2].plot(times, 1e3 * margins, color=ZMP)
    rows[2].set(ylabel="margin [mm]")
    voltage = run["legs/command"]
    rows[3].plot(voltage.times, np.abs(voltage.effort).max(axis=1), color=PLAN)
    rows[3].set(ylabel="voltage [V]")
    rows[0].set_title(title, loc="left")
    legend(rows[0])
    return fig
