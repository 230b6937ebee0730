"""A place where people hold or push the robot: from the wrench they send to what acts in a step."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import Wrench
from follower_humanoid.plant.grip import ZERO
from follower_humanoid.plant.pull_limits import PullLimiter
from follower_humanoid.plant.pulls import Pull
from follower_humanoid.plant.robot_plant import RobotPlant

WORLD_NAMES = ("", "world")


class HeldPlace:
    """One of the places that people may pull at.

    Attributes:
        applied: What acts during this control tick, axes of world.
    """

    def __init__(self, name: str, frame: int, limiter: PullLimiter, plant: RobotPlant) -> None:
        """Nobody there.

        Args:
            name: Of the place, one of the keys of `PullLimiter.cut`.
            frame: Pinocchio frame at whose origin wrenches act.
            limiter: Cuts what is too much.
            plant: The robot.
        """
        self._name, self._frame = name, frame
        self._limiter, self._plant = limiter, plant
        self._unchanging: Wrench | None = None
        self._pull: Pull | None = None
        self.applied = ZERO

    def let_go(self) -> None:
        """Nothing acts any more."""
        self._unchanging = self._pull = None
        self.applied = ZERO

    def take(self, wrench: Wrench | None) -> Pull | None:
        """The pull of this control tick, turned into world once; None if there is none.

        People send the same wrench for many ticks: unless its axes turn with the robot, it is then as it
        was at the tick before.

        Args:
            wrench: What was sent; its numbers never change.

        Raises:
            UnknownNameError: It names a frame that does not exist.
        """
        if wrench is None:
            self.let_go()
        elif wrench is not self._unchanging:
            self._look_at(wrench)
        return self._pull

    def _look_at(self, sent: Wrench) -> None:
        wrench = self._limiter.limited(self._name, sent)
        in_world = wrench.frame in WORLD_NAMES
        # One that was cut is counted again at the next tick.
        self._unchanging = sent if in_world and wrench is sent else None
        if not (np.count_nonzero(wrench.force) or np.count_nonzero(wrench.torque)):
            self._pull, self.applied = None, ZERO
            return
        # Copies: a message's numbers may be read-only, which compiled loops do not take.
        force, torque = np.array(wrench.force), np.array(wrench.torque)
        if not in_world:
            turn = self._plant.frame_rotation(self._plant.robot.frame_id(wrench.frame))
            force, torque = turn @ force, turn @ torque
        self.applied = Wrench(force, torque)
        self._pull = Pull(self._frame, force, torque)
