"""Forces, support polygon, ZMP, CoM, capture point and footsteps as markers, for RViz and Foxglove."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from geometry_msgs.msg import Point as PointMessage
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from follower_humanoid.core.samples import SIDES, Array
from follower_humanoid.pictures.palette import (
    DCM,
    FOOT_FORCE_SCALE,
    FORCE,
    HAND_FORCE_SCALE,
    PCM,
    PUSH_SCALE,
    SIDE_COLORS,
    ZMP,
)
from follower_humanoid.viewer.moment import Moment
from follower_humanoid.viewer.skeleton import Skeleton

_POINTS = (("com", PCM), ("zmp", ZMP), ("dcm", DCM))
_LEAST = 0.05  # a shorter arrow is not drawn [m]
_SHAFT, _HEAD = 0.02, 0.045  # m
_SOLE = (0.24, 0.09, 0.004)  # m


class Markers:
    """Makes the array of a moment."""

    def __init__(self, skeleton: Skeleton) -> None:
        """Args: the robot; it is placed anew for every moment."""
        self._skeleton = skeleton
        self._steps_shown = 0

    def of(self, moment: Moment) -> MarkerArray:
        """All markers of a moment; what is not there is taken away."""
        self._skeleton.place(moment["odom"], moment["joint_states"])
        markers = [*self._forces(moment), *self._points(moment), self._polygon(moment), *self._steps(moment)]
        seconds, nanoseconds = divmod(round(moment.time * 1e9), 1_000_000_000)
        for marker in markers:
            marker.header.frame_id = "world"
            marker.header.stamp.sec, marker.header.stamp.nanosec = seconds, nanoseconds
            marker.pose.orientation.w = marker.pose.orientation.w or 1.0
        return MarkerArray(markers=markers)

    def _forces(self, moment: Moment) -> Iterator[Marker]:
        for number, side in enumerate(SIDES):
            grip = self._skeleton.position(f"{side.prefix}_gripper")
            hand = HAND_FORCE_SCALE * moment.force(f"{side.value}_hand/applied")
            yield _arrow("hand_force", number, grip, hand, FORCE)
            sole = self._skeleton.pose(f"{side.prefix}_sole")
            foot = FOOT_FORCE_SCALE * sole.rotation @ moment.force(f"{side.value}_foot/wrench")
            yield _arrow("foot_force", number, np.array(sole.translation), foot, FORCE)
        push = PUSH_SCALE * moment.force("base/applied")
        yield _arrow("push", 0, self._skeleton.position("base_link"), push, FORCE)

    @staticmethod
    def _points(moment: Moment) -> Iterator[Marker]:
        for number, (topic, color) in enumerate(_POINTS):
            marker = Marker(ns=topic, id=0, type=Marker.CYLINDER, action=Marker.DELETE, color=_color(color))
            marker.scale.x = marker.scale.y = 0.05
            marker.scale.z = 0.002
            if topic in moment:
                marker.action = Marker.ADD
                x, y, _ = moment[topic].xyz
                marker.pose.position = _point(np.array([x, y, 0.006 + 0.001 * number]))
            yield marker

    @staticmethod
    def _polygon(moment: Moment) -> Marker:
        vertices = moment["support_polygon"].vertices if "support_polygon" in moment else np.zeros((0, 3))
        marker = Marker(ns="support_polygon", type=Marker.LINE_STRIP, color=_color(FORCE))
        marker.action = Marker.ADD if len(vertices) > 2 else Marker.DELETE
        marker.scale.x = 0.008
        marker.points = [_point(vertex) for vertex in (*vertices, *vertices[:1])]
        return marker

    def _steps(self, moment: Moment) -> Iterator[Marker]:
        steps = moment["footsteps"].steps if "footsteps" in moment else ()
        for number, step in enumerate(steps):
            opacity = 0.9 if step.taken else 0.35
            marker = Marker(ns="footsteps", id=number, type=Marker.CUBE, color=_color(SIDE_COLORS[step.side]))
            marker.color.a = opacity
            marker.scale.x, marker.scale.y, marker.scale.z = _SOLE
            marker.pose.position = _point(step.position)
            marker.pose.orientation.z, marker.pose.orientation.w = np.sin(step.yaw / 2), np.cos(step.yaw / 2)
            yield marker
        # One by one: some tools take DELETEALL for all of the topic, whatever its namespace. And in every
        # message, since one may be lost.
        self._steps_shown = max(self._steps_shown, len(steps))
        for number in range(len(steps), self._steps_shown):
            yield Marker(ns="footsteps", id=number, action=Marker.DELETE)


def _arrow(namespace: str, number: int, start: Array, arrow: Array, color: str) -> Marker:
    marker = Marker(ns=namespace, id=number, type=Marker.ARROW, color=_color(color))
    marker.action = Marker.ADD if float(np.linalg.norm(arrow)) > _LEAST else Marker.DELETE
    marker.points = [_point(start), _point(start + arrow)]
    marker.scale.x, marker.scale.y = _SHAFT, _HEAD
    return marker


def _point(xyz: Array) -> PointMessage:
    x, y, z = (float(part) for part in xyz)
    return PointMessage(x=x, y=y, z=z)


def _color(text: str) -> ColorRGBA:
    red, green, blue = (int(text[at : at + 2], 16) / 255 for at in (1, 3, 5))
    return ColorRGBA(r=red, g=green, b=blue, a=0.9)
