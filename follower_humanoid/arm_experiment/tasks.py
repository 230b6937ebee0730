"""The two tasks as target points: writing on a board, and going to a target. Axes: base_link."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from follower_humanoid.arm_experiment.target_points import TargetPoint
from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array

BOARD, COMPLIANCE = "board", "compliance"
TASKS = (BOARD, COMPLIANCE)


@dataclass(frozen=True)
class BoardTaskConfig:
    """Approach a board, write a square on it, detach (figs. 1, 2)."""

    distance: float = parameter(0.42, "where the board is believed, ahead of base_link", "m", 0.1, 1.0)
    center: tuple[float, float] = parameter((0.19, 0.28), "centre of the square, y and z", "m", -1.0, 1.5)
    side: float = parameter(0.12, "side of the square", "m", 0.01, 0.5)
    penetration: float = parameter(0.005, "how far behind the surface the target lies", "m", 0.0005, 0.05)
    standoff: float = parameter(0.02, "distance at which the approach begins", "m", 0.005, 0.2)
    approach_speed: float = parameter(0.02, "peak speed of approach and retreat", "m/s", 0.002, 0.5)
    write_speed: float = parameter(0.1, "peak speed along a side", "m/s", 0.005, 0.5)
    rest: float = parameter(0.5, "rest after touch-down and before detaching", "s", 0.0, 10.0)

    def points(self, begin: Array, speed: float) -> tuple[TargetPoint, ...]:
        """Target points from the hand's first place and back to it; `speed` in the free [m/s]."""
        y, z = self.center
        half = 0.5 * self.side
        corners = ((-half, -half), (half, -half), (half, half), (-half, half), (-half, -half))
        free, pressed = self.distance - self.standoff, self.distance + self.penetration
        on_board = [np.array((pressed, y + dy, z + dz)) for dy, dz in corners]
        above = np.array((free, *on_board[0][1:]))
        return (
            TargetPoint(above, speed, 0.2),
            TargetPoint(on_board[0], self.approach_speed, self.rest),
            *(TargetPoint(corner, self.write_speed) for corner in on_board[1:-1]),
            TargetPoint(on_board[-1], self.write_speed, self.rest),
            TargetPoint(above, self.approach_speed, 0.2),
            TargetPoint(begin, speed),
        )


@dataclass(frozen=True)
class ComplianceTaskConfig:
    """Go to a target in a straight line (fig. 3)."""

    target: tuple[float, float, float] = parameter(
        (0.45, 0.25, 0.40), "where the hand shall go, in base_link", "m", -1.5, 1.5
    )

    def points(self, begin: Array, speed: float) -> tuple[TargetPoint, ...]:
        """The one target point; `speed`: peak on the way [m/s]."""
        return (TargetPoint(np.array(self.target), speed),)


@dataclass(frozen=True)
class ArmTaskConfig:
    """What the left hand is asked to do."""

    task: str = parameter(COMPLIANCE, "what the left hand does", choices=TASKS)
    speed: float = parameter(0.12, "peak speed in the free", "m/s", 0.005, 0.5)
    leash: float = parameter(
        0.02, "distance from its line beyond which a hand counts as led", "m", 0.006, 1.0
    )
    rest_speed: float = parameter(0.01, "speed below which a led hand rests", "m/s", 0.0005, 0.1)
    rest_time: float = parameter(1.0, "how long it rests before it goes on", "s", 0.0, 60.0)
    board: BoardTaskConfig = field(default_factory=BoardTaskConfig)
    compliance: ComplianceTaskConfig = field(default_factory=ComplianceTaskConfig)

    def points(self, begin: Array) -> tuple[TargetPoint, ...]:
        """The chosen task's target points from the hand's first place, shape (3,) [m]."""
        chosen = self.board if self.task == BOARD else self.compliance
        return chosen.points(begin, self.speed)
