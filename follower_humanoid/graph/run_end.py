"""When a run is over, free of ROS: after its duration, once the robot stands, or a second after a fall."""

from __future__ import annotations

import math

from follower_humanoid.core.samples import Array
from follower_humanoid.graph.graph_config import RunConfig
from follower_humanoid.robot.model import GRAVITY, RobotModel

AFTER_FALL = 1.0
_STILL = 1.0  # s without motion
_BASE_SPEED = 0.02  # m/s, below the slowest shift of weight between two steps
_FOOT_SHARE = 0.2  # of the weight on each foot


class RunEnd:
    """Looks at every tick whether the run is over."""

    def __init__(self, config: RunConfig, robot: RobotModel) -> None:
        """Args: the times, and the robot whose weight the feet carry."""
        self._config = config
        self._least_force = _FOOT_SHARE * robot.mass * GRAVITY
        self._moved_at = 0.0

    def over(
        self, time: float, base_velocity: Array, feet: tuple[Array, Array], fallen_at: float | None
    ) -> bool:
        """Whether the run ends now.

        Args:
            time: Simulated time [s].
            base_velocity: Of base_link, shape (3,) [m/s].
            feet: Force on each foot in sole axes, shape (3,) [N].
            fallen_at: Time of the fall [s], None while upright.
        """
        if fallen_at is not None:
            return time >= fallen_at + AFTER_FALL - 1e-9
        config = self._config
        carried = min(float(force[2]) for force in feet)
        if math.hypot(*base_velocity.tolist()) > _BASE_SPEED or carried < self._least_force:
            self._moved_at = time
        if config.duration <= 0.0 or time < config.duration - 1e-9:
            return False
        if time >= config.duration + config.settle - 1e-9:
            return True
        return time - self._moved_at >= _STILL
