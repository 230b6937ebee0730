"""What is seen at one moment, from a running robot or from a bag: both are drawn by the same code."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from follower_humanoid.balance.support_polygon import convex_hull, polygon_margin
from follower_humanoid.core.samples import Array, Footstep


@dataclass(frozen=True)
class Moment:
    """The newest sample of every topic.

    Attributes:
        time: Simulated time [s].
        samples: Topic → sample; a topic that nobody has published yet is left out.
        reports: Node → key → text of its last diagnostics.
        missing: Nodes that should be there and give no sign of life.
        silent: Wall time since the robot's state last changed [s].
        speed: Simulated seconds per wall second, NaN where it is not known.
    """

    time: float
    samples: Mapping[str, Any] = field(default_factory=dict)
    reports: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    silent: float = 0.0
    speed: float = math.nan

    def __contains__(self, topic: object) -> bool:
        return topic in self.samples

    def __getitem__(self, topic: str) -> Any:
        return self.samples[topic]

    @property
    def has_robot(self) -> bool:
        """Whether the robot can be drawn."""
        return "joint_states" in self.samples and "odom" in self.samples

    def zmp_margin(self) -> float:
        """Distance of the ZMP to the edge of the support polygon [m], NaN where there is none."""
        if "zmp" not in self or "support_polygon" not in self:
            return math.nan
        vertices = self["support_polygon"].vertices
        if len(vertices) < 3:
            return math.nan
        return polygon_margin(convex_hull(vertices[:, :2]), self["zmp"].xyz[:2])

    def peak_voltage(self) -> float:
        """Largest motor voltage of legs and arms [V], NaN where none is commanded."""
        volts = [self[topic].effort for topic in ("legs/command", "arms/command") if topic in self]
        return max((float(np.max(np.abs(v))) for v in volts), default=math.nan)

    def force(self, topic: str) -> Array:
        """Force of a wrench topic, zero where there is none, shape (3,) [N]."""
        return self[topic].force if topic in self else np.zeros(3)


@dataclass(frozen=True)
class Trail:
    """What the robot has left behind on the ground.

    Attributes:
        path: Where the pelvis was, shape (n, 3) in world [m].
        prints: Where soles stood.
    """

    path: Array = field(default_factory=lambda: np.zeros((0, 3)))
    prints: tuple[Footstep, ...] = ()


class TrailKeeper:
    """Lengthens a trail while the robot walks."""

    STRIDE = 0.03
    """Distance between two points of the path [m]."""
    JUMP = 0.25
    """Nobody walks that far between two looks: the robot was put elsewhere [m]."""
    _LONGEST = 2000
    _PRINTS = 400
    _SAME = 0.01  # m

    def __init__(self) -> None:
        """Nothing yet."""
        self.trail = Trail()
        self._over: Any = None  # footsteps of a walk that is over

    def add(self, moment: Moment) -> Trail:
        """The trail with this moment; the same object where nothing has been added."""
        path, prints = self.trail.path, self.trail.prints
        if "odom" in moment:
            here = moment["odom"].position
            gap = np.linalg.norm(here[:2] - path[-1, :2]) if len(path) else self.STRIDE + 1e-9
            if gap > self.JUMP:
                path, prints = path[:0], ()
                self._over = moment.samples.get("footsteps")
            if gap > self.STRIDE:
                path = np.vstack((path, here))[-self._LONGEST :]
        if "footsteps" in moment and moment["footsteps"] is not self._over:
            new = [s for s in moment["footsteps"].steps if s.taken and not self._known(prints, s)]
            prints = (*prints, *new)[-self._PRINTS :]
        if path is not self.trail.path or len(prints) != len(self.trail.prints):
            self.trail = Trail(path, prints)
        return self.trail

    def forget(self) -> None:
        """Begins anew."""
        self.trail = Trail()

    def _known(self, prints: tuple[Footstep, ...], step: Footstep) -> bool:
        return any(
            old.side is step.side and np.linalg.norm(old.position[:2] - step.position[:2]) < self._SAME
            for old in prints[-6:]
        )
