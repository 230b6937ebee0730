"""One robot model for all nodes of a process."""

from __future__ import annotations

from functools import lru_cache

from follower_humanoid.robot.model import RobotModel


@lru_cache(maxsize=2)
def shared_robot(urdf: str) -> RobotModel:
    """The model of a URDF, made once: it is never written to.

    Raises:
        ConfigurationError: Not a URDF of this robot's structure.
    """
    return RobotModel(urdf)
