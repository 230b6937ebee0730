"""A report on recorded runs: figures as PNG, in one PDF and on one HTML page; the steps as CSV."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.arm import TARGET, arm_sticks_figure, elbow_figure, hand_force_figure
from follower_humanoid.pictures.ground import ground_figure
from follower_humanoid.pictures.page import write_page
from follower_humanoid.pictures.signals import feet_figure, gait_figure, voltage_figure
from follower_humanoid.pictures.stick import stick_figure
from follower_humanoid.pictures.style import FEET, RC, View, views
from follower_humanoid.pictures.table import table_figure, write_csv
from follower_humanoid.pictures.zmp import zmp_figure


@dataclass(frozen=True)
class Picture:
    """One figure of the report.

    Attributes:
        name: File name without ending.
        title: What it shows.
        draw: Makes it from the compared runs.
        needs: Topics without which it cannot be drawn.
    """

    name: str
    title: str
    draw: Callable[[Sequence[View]], Figure]
    needs: tuple[str, ...]


PICTURES = (
    Picture("sticks", "Stick diagram", stick_figure, ()),
    Picture("footprints", "Footprints", ground_figure, FEET),
    Picture("zmp", "ZMP and CoM", zmp_figure, ("zmp",)),
    Picture(
        "forces_and_gait",
        "Forces and walking parameters",
        gait_figure,
        ("left_hand/applied", "right_hand/applied", "gait"),
    ),
    Picture("feet_and_primitives", "Foot forces and primitives", feet_figure, FEET),
    Picture("voltages", "Joint voltages", voltage_figure, ("legs/command", "arms/command")),
    Picture("steps", "Half-steps", table_figure, FEET),
)

# Of an arm experiment: the trunk is fixed, nothing walks.
ARM_PICTURES = (
    Picture("arm_sticks", "Stick diagram of the arm", arm_sticks_figure, (TARGET,)),
    Picture("hand_force", "Force on the hand", hand_force_figure, (TARGET, "left_hand/wrench")),
    Picture("elbow", "Elbow", elbow_figure, (TARGET,)),
)


@dataclass(frozen=True)
class Report:
    """What was made.

    Attributes:
        views: The runs.
        files: Everything written.
        notes: What is missing, one sentence each.
        has_steps: Whether the runs have a step table; an arm experiment has none.
    """

    views: tuple[View, ...]
    files: tuple[Path, ...]
    notes: tuple[str, ...]
    has_steps: bool


def make_report(runs: Sequence[tuple[str, Run]], out: Path) -> Report:
    """Draws everything that the runs allow.

    Args:
        runs: Labels and runs; several are compared on the same figures.
        out: Folder for the files; made where it does not exist.

    Raises:
        ConfigurationError: The folder cannot be written.
    """
    compared = views(runs)
    notes = [f"{label}: {note}" for label, run in runs for note in run.notes]
    walks = not all(TARGET in view.run for view in compared)
    pictures = PICTURES if walks else ARM_PICTURES
    try:
        out.mkdir(parents=True, exist_ok=True)
        with rc_context(RC), PdfPages(out / "report.pdf") as pages:
            saved = {picture: _save(picture, compared, out, pages, notes) for picture in pictures}
        files = [out / "report.html", out / "report.pdf", *(file for file in saved.values() if file)]
        has_steps = walks and all(name in view.run for view in compared for name in FEET)
        # The page has the table as text.
        shown = [(p.title, file) for p, file in saved.items() if file and p.draw is not table_figure]
        write_page(out / "report.html", compared, shown, notes, has_steps)
        if has_steps:
            write_csv(out / "steps.csv", compared)
            files.append(out / "steps.csv")
    except OSError as error:
        raise ConfigurationError(f"report {out} cannot be written: {error.strerror}") from None
    return Report(tuple(compared), tuple(files), tuple(notes), has_steps)


def _save(picture: Picture, compared: Sequence[View], out: Path, pages: Any, notes: list[str]) -> Path | None:
    missing = sorted({name for view in compared for name in picture.needs if name not in view.run})
    if missing:
        notes.append(f"no picture '{picture.name}': {', '.join(missing)} not recorded")
        return None
    drawn = picture.draw(compared)
    file = out / f"{picture.name}.png"
    drawn.savefig(file)
    drawn.set_layout_engine("none")  # it is laid out: that is half the time a figure takes
    pages.savefig(drawn)
    return file
