"""Handles at the robot's hands that can be dragged, and the leashes that show the pull."""

from __future__ import annotations

import time
from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np
import viser

from follower_humanoid.core.samples import SIDES, Array, Side
from follower_humanoid.pictures.palette import FORCE, SIDE_COLORS, rgb
from follower_humanoid.viewer.hands import Hands, level_target
from follower_humanoid.viewer.stage import Stage
from follower_humanoid.viewer.telling import Place, tell_moved

_RADIUS = 0.055  # m


class Leashes:
    """A handle at either hand."""

    def __init__(self, server: viser.ViserServer, stage: Stage, hands: Hands) -> None:
        """Puts the handles there."""
        self._server, self._stage, self._hands = server, stage, hands
        self._balls = {side: Place(self._add_ball(side)) for side in SIDES}
        self._lines = {side: self._add_line(side) for side in SIDES}
        self._targets: dict[Side, Array] = {}
        self._level = dict.fromkeys(SIDES, True)

    def draw(self) -> None:
        """Moves the handles with the hands."""
        for side, ball in self._balls.items():
            grip = self._stage.skeleton.position(f"{side.prefix}_gripper")
            ball.move(*grip.tolist())
            held = self._hands.held(side) and side in self._targets
            self._lines[side].visible = held
            if held:
                target = self._targets[side] - self._stage.offset
                target[2] = grip[2] if self._level[side] else target[2]
                tell_moved(self._lines[side], "points", np.array([[grip, target]], dtype=np.float32))

    def _add_ball(self, side: Side) -> Any:
        ball = self._server.scene.add_icosphere(
            f"/world/handles/{side.value}_hand",
            _RADIUS,
            rgb(SIDE_COLORS[side]),
            subdivisions=2,
            opacity=0.45,
            cast_shadow=False,
        )
        ball.on_drag("left")(self._dragged(side, level=True))
        ball.on_drag("left", modifier="shift")(self._dragged(side, level=False))
        return ball

    def _add_line(self, side: Side) -> Any:
        return self._server.scene.add_line_segments(
            f"/world/leashes/{side.value}_hand",
            np.zeros((1, 2, 3)),
            rgb(FORCE),
            thickness=0.008,
            visible=False,
        )

    def _dragged(self, side: Side, level: bool) -> Callable[[Any], Coroutine[Any, Any, None]]:
        async def dragged(event: Any) -> None:  # async: the library then keeps the order of events
            if event.phase == "end":
                self._targets.pop(side, None)
                self._hands.let_go(side, event.client_id)
                return
            start = np.array(event.start_position)
            target = np.array(event.end_position)
            if level:
                target = level_target(np.array(event.client.camera.position), target, float(start[2]))
            self._targets[side] = target
            grip = None
            if event.phase == "start":
                hand = self._stage.skeleton.position(f"{side.prefix}_gripper") + self._stage.offset
                grip = start - hand
            self._level[side] = level
            self._hands.pull_to(side, event.client_id, target, time.monotonic(), grip, level)

        return dragged
