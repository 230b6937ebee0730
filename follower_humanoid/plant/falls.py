"""When the robot counts as fallen."""

from __future__ import annotations

import math
from dataclasses import dataclass

from follower_humanoid.plant.robot_plant import RobotPlant


@dataclass(frozen=True)
class Fall:
    """The first moment at which the robot had fallen.

    Attributes:
        time: Simulated time [s].
        place: base_link in world [m].
        reason: What showed it.
    """

    time: float
    place: tuple[float, float, float]
    reason: str


class FallWatch:
    """Base too low, tilted too far, or a link other than the feet on the ground."""

    LOWEST_SHARE = 0.60
    LARGEST_TILT = math.radians(45.0)
    _LEAST_UPRIGHT = math.cos(LARGEST_TILT)

    def __init__(self, standing_height: float) -> None:
        """`standing_height` is base_link's height at time 0 [m]."""
        self._lowest = self.LOWEST_SHARE * standing_height

    def look(self, plant: RobotPlant) -> Fall | None:
        """The fall, if the robot is fallen now."""
        reason = self._reason(plant)
        if reason is None:
            return None
        x, y, z = (float(value) for value in plant.q[:3])
        return Fall(plant.time, (x, y, z), reason)

    def _reason(self, plant: RobotPlant) -> str | None:
        height = float(plant.q[2])
        if height < self._lowest:
            return f"base_link at {height:.2f} m, below {self._lowest:.2f} m"
        upright = float(plant.rotation[2, 2])
        if upright < self._LEAST_UPRIGHT:
            tilt = math.degrees(math.acos(max(-1.0, upright)))
            return f"tilted by {tilt:.0f}°"
        link = plant.world.link_on_ground(plant.bullet.body)
        if link is not None:
            return f"{plant.bullet.link_names[link]} on the ground"
        return None
