"""Format of the footsteps: one marker per planned or taken step."""

from __future__ import annotations

import colorsys
import math
from typing import Any

import numpy as np
from visualization_msgs.msg import Marker, MarkerArray

from follower_humanoid.core import samples
from follower_humanoid.core.samples import Array, Side
from follower_humanoid.core.topics import CLOSING_STEP
from follower_humanoid.ros.layouts import Blocks, Stamped
from follower_humanoid.ros.validation import MessageError


class FootstepsFormat(Stamped):
    """Sole poses as markers: green left, red right, pale while planned."""

    message_type = MarkerArray
    fast_reading = False

    def shape(self, sample: samples.Footsteps) -> tuple[tuple[Side, bool], ...]:
        """What decides the template."""
        return tuple((step.side, step.counted) for step in sample.steps)

    def template(self, shape: tuple[tuple[Side, bool], ...]) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        markers = []
        blocks: list[tuple[str, int]] = []
        for index, (side, counted) in enumerate(shape):
            marker = Marker(ns=side.value, id=index, type=Marker.CUBE, action=Marker.ADD)
            marker.text = "" if counted else CLOSING_STEP
            marker.scale.x, marker.scale.y, marker.scale.z = 0.24, 0.09, 0.004
            markers.append(self.framed(marker))
            blocks += [(f"markers[{index}].pose.position.x", 7), (f"markers[{index}].color.r", 4)]
        return MarkerArray(markers=markers), tuple(blocks)

    def numbers(self, sample: samples.Footsteps) -> tuple[Array, ...]:
        """One array per block."""
        arrays: list[Array] = []
        for step in sample.steps:
            half = 0.5 * step.yaw
            arrays.append(np.array([*step.position, 0.0, 0.0, math.sin(half), math.cos(half)]))
            hue = 0.33 if step.side is Side.LEFT else 0.0
            arrays.append(np.array([*colorsys.hsv_to_rgb(hue, 0.8, 0.8), 1.0 if step.taken else 0.35]))
        return tuple(arrays)

    def sample(self, blocks: list[Array], shape: tuple[tuple[Side, bool], ...]) -> samples.Footsteps:
        """The inverse of `numbers`."""
        steps = []
        for (side, counted), pose, color in zip(shape, blocks[::2], blocks[1::2], strict=True):
            yaw = 2.0 * math.atan2(pose[5], pose[6])
            steps.append(samples.Footstep(side, pose[:3].copy(), yaw, bool(color[3] > 0.5), counted))
        return samples.Footsteps(tuple(steps))

    def read(self, message: MarkerArray) -> samples.Footsteps:
        """Any valid message, the slow way."""
        shape: list[tuple[Side, bool]] = []
        blocks: list[Array] = []
        for marker in message.markers:
            if marker.ns not in (Side.LEFT.value, Side.RIGHT.value):
                raise MessageError(self.topic.name, f"marker namespace '{marker.ns}'; valid: left, right")
            self.check_frame(marker)
            p, q, c = marker.pose.position, marker.pose.orientation, marker.color
            shape.append((Side(marker.ns), marker.text != CLOSING_STEP))
            blocks += [self.finite(p.x, p.y, p.z, q.x, q.y, q.z, q.w), self.finite(c.r, c.g, c.b, c.a)]
        return self.sample(blocks, tuple(shape))
