"""The step table, as a figure and as text."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from follower_humanoid.pictures.steps import COLUMNS, table_rows
from follower_humanoid.pictures.style import View, figure

_ROW = 0.21  # inches


def rows_of(compared: Sequence[View]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heads and rows of all runs, with the run's name in front where there are several."""
    if len(compared) == 1:
        return COLUMNS, table_rows(compared[0].steps)
    rows = [(view.label, *row) for view in compared for row in table_rows(view.steps)]
    return ("run", *COLUMNS), rows


def table_figure(compared: Sequence[View]) -> Figure:
    """One line per half-step."""
    heads, rows = rows_of(compared)
    fig = figure(0.55 + _ROW * (len(rows) + 1))
    axes = fig.subplots()
    axes.axis("off")
    axes.set_title("Half-steps" if rows else "Half-steps: none", loc="left")
    if rows:
        table = axes.table(
            cellText=rows, colLabels=heads, loc="upper center", cellLoc="center", edges="horizontal"
        )
        table.auto_set_font_size(False)
        table.set_fontsize(7.5)
        for cell in table.get_celld().values():
            cell.set_height(1.0 / (len(rows) + 1.5))
            cell.set_edgecolor("#CCCCCC")
    return fig


def write_csv(path: Path, compared: Sequence[View]) -> None:
    """The table for spreadsheets."""
    heads, rows = rows_of(compared)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(heads)
        writer.writerows(rows)


def text_table(compared: Sequence[View]) -> str:
    """The table for a terminal."""
    heads, rows = rows_of(compared)
    if not rows:
        return "no half-steps"
    widths = [max(len(row[column]) for row in (heads, *rows)) for column in range(len(heads))]
    lines = [
        "  ".join(word.rjust(width) for word, width in zip(row, widths, strict=True))
        for row in (heads, *rows)
    ]
    return "\n".join(lines)
