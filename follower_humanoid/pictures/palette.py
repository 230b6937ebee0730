"""Colours with a meaning and scales that all pictures share, on paper and in the browser."""

from __future__ import annotations

from follower_humanoid.core.samples import Side

# Colours that colour-blind readers can tell apart (Okabe and Ito).
LEFT, RIGHT, MIDDLE = "#0072B2", "#D55E00", "#444444"
ZMP, PCM, PLAN, COMMAND, BAND = "#CC3377", "#009E73", "#222222", "#E69F00", "#DDDDDD"
SIDE_COLORS = {Side.LEFT: LEFT, Side.RIGHT: RIGHT}

AXIS_COLORS = ("#0072B2", "#E69F00", "#009E73")  # x, y, z
FORCE, DCM = "#E69F00", "#56B4E9"

HAND_FORCE_SCALE = 0.05
"""Length of an arrow that shows what pulls at a hand [m/N]."""
PUSH_SCALE = 0.01
"""Length of an arrow that shows what pushes the pelvis [m/N]."""
FOOT_FORCE_SCALE = 0.0007
"""Length of an arrow that shows what the ground does to a foot [m/N]."""


def rgb(color: str) -> tuple[int, int, int]:
    """`#RRGGBB` as three numbers, 0…255."""
    red, green, blue = (int(color[at : at + 2], 16) for at in (1, 3, 5))
    return red, green, blue
