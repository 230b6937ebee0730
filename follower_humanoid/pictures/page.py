"""The report as one HTML page that carries everything it shows."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path

from follower_humanoid.pictures.player import SCRIPT
from follower_humanoid.pictures.scene import scene
from follower_humanoid.pictures.style import View
from follower_humanoid.pictures.table import rows_of

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 60rem; margin: 2rem auto; }
h1 { font-size: 1.5rem; }
h2 { font-size: 1.15rem; margin-top: 2rem; }
img, canvas { max-width: 100%; }
canvas { background: #f6f7f8; touch-action: none; cursor: grab; display: block; }
table { border-collapse: collapse; font-size: 0.9rem; }
th, td { padding: 0.15rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right; }
pre { background: #f6f7f8; padding: 0.8rem; overflow: auto; max-height: 30rem; font-size: 0.8rem; }
.controls { display: flex; gap: 0.8rem; align-items: center; margin: 0.5rem 0; }
#player input { flex: 1; }
output { font-variant-numeric: tabular-nums; min-width: 5rem; }
.note { color: #a33; }
"""


def write_page(
    path: Path,
    compared: Sequence[View],
    pictures: Sequence[tuple[str, Path]],
    notes: Sequence[str],
    with_steps: bool = True,
) -> None:
    """Writes the page.

    Args:
        path: The HTML file.
        compared: The runs.
        pictures: Title and PNG file of each figure.
        notes: What is missing.
        with_steps: Whether there is a step table; an arm experiment has none.
    """
    labels = ", ".join(view.label for view in compared)
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(labels)}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{escape(labels)}</h1>",
        *(f'<p class="note">{escape(note)}</p>' for note in notes),
        _player(compared),
        *(["<h2>Half-steps</h2>", _table(compared)] if with_steps else []),
        *(_picture(title, file) for title, file in pictures),
        *(_about(view) for view in compared),
        "</body></html>",
    ]
    path.write_text("\n".join(parts), encoding="utf-8")


def _player(compared: Sequence[View]) -> str:
    # A closing tag within the data would end the script.
    data = json.dumps([scene(view) for view in compared], separators=(",", ":")).replace("<", "\\u003c")
    chooser = ""
    if len(compared) > 1:
        options = (f'<option value="{i}">{escape(view.label)}</option>' for i, view in enumerate(compared))
        chooser = f'<select class="run" aria-label="run">{"".join(options)}</select>'
    speeds = "".join(
        f'<option value="{speed}"{" selected" if speed == 1 else ""}>{speed}×</option>'
        for speed in (0.1, 0.25, 0.5, 1, 2, 4)
    )
    return (
        '<div id="player"><canvas width="960" height="560"></canvas><div class="controls">'
        '<button type="button">Play</button><input type="range" min="0" value="0" step="1" aria-label="time">'
        f'<output></output><select class="speed" aria-label="speed">{speeds}</select>{chooser}</div>'
        "<p>Drag to turn, scroll to come nearer. Green: projection of the centre of mass; red: ZMP; "
        "yellow: force on the hand, 5 cm for 1 N.</p></div>"
        f'<script type="application/json" id="runs">{data}</script><script>{SCRIPT}</script>'
    )


def _table(compared: Sequence[View]) -> str:
    heads, rows = rows_of(compared)
    if not rows:
        return "<p>No half-step.</p>"
    lines = [f"<tr>{''.join(f'<th>{escape(head)}</th>' for head in heads)}</tr>"]
    lines += [f"<tr>{''.join(f'<td>{escape(word)}</td>' for word in row)}</tr>" for row in rows]
    return f"<table>{''.join(lines)}</table>"


def _picture(title: str, file: Path) -> str:
    data = base64.b64encode(file.read_bytes()).decode("ascii")
    return f'<h2>{escape(title)}</h2><img alt="{escape(title)}" src="data:image/png;base64,{data}">'


def _about(view: View) -> str:
    texts = "".join(
        f"<h3>{escape(name)}</h3><pre>{escape(text)}</pre>" for name, text in sorted(view.run.about.items())
    )
    if not texts:
        return ""
    return f"<details><summary>What {escape(view.label)} was made of</summary>{texts}</details>"
