"""The report as one HTML page that carries everything it shows."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from pathlib import Path

from follower_humanoid.pictures.animation import animation
from follower_humanoid.pictures.palette import HAND_FORCE_SCALE
from follower_humanoid.pictures.style import View
from follower_humanoid.pictures.table import rows_of

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 60rem; margin: 2rem auto; }
h1 { font-size: 1.5rem; }
h2 { font-size: 1.15rem; margin-top: 2rem; }
img { max-width: 100%; }
iframe { width: 100%; height: min(36rem, 80vh); border: 1px solid #ddd; }
table { border-collapse: collapse; font-size: 0.9rem; }
th, td { padding: 0.15rem 0.8rem; border-bottom: 1px solid #ddd; text-align: right; }
pre { background: #f6f7f8; padding: 0.8rem; overflow: auto; max-height: 30rem; font-size: 0.8rem; }
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
    """The runs in 3D, each a page within the page."""
    frames = (
        f'<iframe title="{escape(view.label)} in 3D" srcdoc="{escape(animation(view), quote=True)}"></iframe>'
        for view in compared
    )
    return "".join(frames) + (
        "<p>Drag to turn, scroll to come nearer. Green: projection of the centre of mass; red: ZMP; light "
        f"blue: capture point; yellow: force on the hand, {100 * HAND_FORCE_SCALE:.0f} cm for 1 N.</p>"
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
