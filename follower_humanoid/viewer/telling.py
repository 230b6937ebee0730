"""What has moved, told to the pages in as few words as possible.

The setters of viser's handles cast, compare and copy each value, which costs ten times as much as telling it.
Who moves things thirty times a second knows which have moved, and puts the same messages into viser's queue
directly: with parts of viser that it does not document, all of which are here.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from viser import _messages as messages

from follower_humanoid.core.samples import Array
from follower_humanoid.viewer.carried import VISIBLE, Singles


def without_delay(server: Any) -> None:
    """Sends a picture when it is drawn: it comes in one piece, and need not wait for more of it."""
    server._websock_server.get_message_buffer().window_duration_sec = 0.0


def at_once(server: Any) -> AbstractContextManager[None]:
    """Within it everything told is one picture; viser's own `atomic` wakes it once more for each page."""
    together: AbstractContextManager[None] = server._websock_server.atomic()
    return together


def tell(handle: Any, *names: str) -> None:
    """Tells properties of a node, arrays that have been changed where they are."""
    changed = {name: getattr(handle, name).copy() for name in names}  # sent later: here they change again
    _queue(handle, messages.SceneNodeUpdateMessage(handle.name, changed))


def tell_moved(handle: Any, name: str, points: Singles) -> None:
    """Tells points [m] that are more, fewer, or visibly elsewhere than before."""
    told = getattr(handle, name)
    if told.shape != points.shape:
        setattr(handle, name, points)
    elif np.abs(told - points).max() > VISIBLE:
        told[:] = points
        tell(handle, name)


def tell_data(plot: Any, columns: tuple[Array, ...]) -> None:
    """Tells a plot's times and values, one array per line; they must not change any more."""
    plot._queue_update("data", columns)


class Place:
    """Where a node is: told when that can be seen to have changed."""

    def __init__(self, handle: Any) -> None:
        """It stays where the handle has it."""
        self._handle = handle
        self.xyz = tuple(handle.position.tolist())

    def move(self, x: float, y: float, z: float) -> None:
        """Puts it to a point in the frame of its parent [m]."""
        old_x, old_y, old_z = self.xyz
        if max(abs(x - old_x), abs(y - old_y), abs(z - old_z)) > VISIBLE:
            self.xyz = self._handle.position[:] = (x, y, z)
            _queue(self._handle, messages.SetPositionMessage(self._handle.name, self.xyz))


def _queue(handle: Any, message: Any) -> None:
    handle._impl.api._queue_scene_message(message)
