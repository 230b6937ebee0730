"""Bare physics: the torques and forces of a run, played back into PyBullet with nothing else around."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.plant.bullet_robot import BulletRobot

Call = tuple[str, tuple[Any, ...]]
_RECORDED = ("drive", "support", "pull")


@dataclass(frozen=True)
class Cost:
    """Of one tick.

    Attributes:
        wall, cpu: [s].
    """

    wall: float
    cpu: float


class Tape:
    """What the plant asks of PyBullet in each physics step of a run.

    Attributes:
        ticks: Control ticks on it.
        state: Configuration at the end of the last playing, shape (52,).
    """

    def __init__(self, leader: str, ticks: int, tick: float) -> None:
        """Records. Args: force programme, length, and control tick [s]."""
        self.ticks = ticks
        self.state: Array = np.zeros(0)
        self._leader, self._tick = leader, tick
        self._steps: list[list[Call]] = [[]]
        chain = self._chain()
        plant = chain.simulator.plant
        for name in _RECORDED:
            setattr(plant.bullet, name, self._noting(name, getattr(plant.bullet, name)))
        step = plant.world.step

        def step_and_turn_page() -> None:
            step()
            self._steps.append([])

        plant.world.step = step_and_turn_page
        try:
            for _ in range(ticks):
                chain.advance()
        finally:
            chain.close()

    def _chain(self) -> Chain:
        return Chain({"leader": {"programme": self._leader}}, self._tick)

    def _noting(self, name: str, call: Callable[..., None]) -> Callable[..., None]:
        def note_and_call(*arguments: Any) -> None:
            kept = tuple(a.copy() if isinstance(a, np.ndarray) else a for a in arguments)
            self._steps[-1].append((name, kept))
            call(*arguments)

        return note_and_call

    def play(self) -> Cost:
        """Plays it into a fresh world: forces in, `stepSimulation`, and nothing read."""
        chain = self._chain()
        plant = chain.simulator.plant
        bullet: BulletRobot = plant.bullet
        wall = cpu = 0.0
        try:
            for calls in self._steps[:-1]:
                wall_before, cpu_before = time.perf_counter(), time.process_time()
                for name, arguments in calls:
                    getattr(bullet, name)(*arguments)
                plant.world.step()
                wall += time.perf_counter() - wall_before
                cpu += time.process_time() - cpu_before
                # Not part of it: without, forces would act at last step's places and the robot would fall.
                bullet.read()
            self.state = bullet.q.copy()
        finally:
            chain.close()
        return Cost(wall / self.ticks, cpu / self.ticks)
