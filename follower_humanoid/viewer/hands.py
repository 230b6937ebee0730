"""Taking the robot's hand: what people at pages do, as a force. Free of browser and ROS.

A person holds a hand either by a leash, from the hand to the pointer, or by a steady force. The page must go
on giving signs of life: a page that is closed, lost or hung has let go.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.viewer.config import PullConfig

_STEEPEST = 0.1  # sine of the flattest look down at which a level plane can still be hit


@dataclass
class _Hold:
    """One page at one hand.

    Attributes:
        page: Number of the page.
        heard: When it last gave a sign of life [s].
        target: End of a leash in the picture, shape (3,) [m]; None where the force is steady.
        grip: From the hand to where it was taken, shape (3,) [m].
        level: Whether the leash stays level with the hand, which sinks and rises as the robot walks.
        steady: Force of a steady pull, shape (3,) [N].
    """

    page: int
    heard: float
    target: Array | None
    grip: Array
    steady: Array
    level: bool = False


class Hands:
    """Who holds which hand. Methods may be called from any thread; times are a wall clock's [s]."""

    def __init__(self, config: PullConfig) -> None:
        """Nobody holds on."""
        self._config = config
        self._holds: dict[Side, _Hold] = {}
        self._grips: dict[Side, tuple[int, Array]] = {}  # of drags whose button is down
        self._lock = threading.RLock()

    def pull_to(
        self,
        side: Side,
        page: int,
        target: Array,
        now: float,
        grip: Array | None = None,
        level: bool = False,
    ) -> None:
        """Leads a leash to a point of the picture, or level with the hand to below or above that point.

        `grip` is told when it begins [m].

        A page that had been silent and drags on takes the hand again, unless somebody else has it now.
        """
        with self._lock:
            hold = self._holds.get(side)
            if grip is not None:
                self._grips[side] = (page, grip)
            begun_by, began_at = self._grips.get(side, (None, None))
            if began_at is None or begun_by != page or (hold is not None and hold.target is None):
                return
            end = np.array(target, dtype=float)
            self._holds[side] = _Hold(page, now, end, began_at, np.zeros(3), level)

    def pull_with(self, side: Side, page: int, force: Array, now: float) -> None:
        """Pulls steadily, force in world [N]; zero lets go."""
        with self._lock:
            if not np.any(force):
                self._holds.pop(side, None)
                return
            self._holds[side] = _Hold(page, now, None, np.zeros(3), np.array(force, dtype=float))

    def let_go(self, side: Side, page: int) -> None:
        """Ends a hold of this page."""
        with self._lock:
            if side in self._grips and self._grips[side][0] == page:
                del self._grips[side]
            if side in self._holds and self._holds[side].page == page:
                del self._holds[side]

    def let_all_go(self) -> None:
        """Ends every hold."""
        with self._lock:
            self._holds.clear()
            self._grips.clear()

    def gone(self, page: int) -> None:
        """The page is closed."""
        for side in SIDES:
            self.let_go(side, page)

    def heard(self, page: int, now: float) -> None:
        """The page has given a sign of life."""
        with self._lock:
            for hold in self._holds.values():
                if hold.page == page:
                    hold.heard = now

    def pages(self) -> set[int]:
        """Pages that hold a hand."""
        with self._lock:
            return {hold.page for hold in self._holds.values()}

    def held(self, side: Side) -> bool:
        """Whether anybody holds this hand."""
        return side in self._holds

    def steady(self, side: Side) -> bool:
        """Whether this hand is pulled with a steady force."""
        hold = self._holds.get(side)
        return hold is not None and hold.target is None

    def force(self, side: Side, hand: Array, now: float) -> Array | None:
        """What the page does to a hand now.

        A leash pulls like a spring: f = k (target − hand), up to the limit.

        Args:
            side: Which hand.
            hand: Where it is in the picture, shape (3,) [m].
            now: Wall time [s].

        Returns:
            Force, shape (3,) [N]; None where nobody holds the hand.
        """
        with self._lock:
            hold = self._holds.get(side)
            if hold is None:
                return None
            if now - hold.heard > self._config.patience:
                del self._holds[side]
                return None
            force = hold.steady
            if hold.target is not None:
                force = self._config.stiffness * (hold.target - (hand + hold.grip))
                force[2] *= not hold.level
        size = float(np.linalg.norm(force))
        if size <= self._config.limit:
            return force
        limited: Array = force * (self._config.limit / size)
        return limited


def level_target(eye: Array, pointer: Array, height: float) -> Array:
    """The point at a height that the eye sees behind the pointer.

    Where the eye looks along the level rather than down at it, the point below or above the pointer.

    Args:
        eye: Place of the camera, shape (3,) [m].
        pointer: A point on the line of sight, shape (3,) [m].
        height: Of the level plane [m].
    """
    sight = pointer - eye
    drop = float(sight[2])
    if abs(drop) > _STEEPEST * float(np.linalg.norm(sight)):
        share = (height - float(eye[2])) / drop
        if 0.0 < share < 3.0:
            point: Array = eye + share * sight
            return point
    return np.array([pointer[0], pointer[1], height])
