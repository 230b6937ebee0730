"""Which format each topic has."""

from __future__ import annotations

from typing import cast

from follower_humanoid.core import samples
from follower_humanoid.core.topics import PEOPLE, Topic
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.footstep_layout import FootstepsFormat
from follower_humanoid.ros.layouts import (
    Format,
    InertialFormat,
    OdometryFormat,
    PointFormat,
    PolygonFormat,
    WrenchFormat,
)
from follower_humanoid.ros.named_layouts import ContactPlanFormat, GaitFormat, JointsFormat, PrimitivesFormat

_SIMPLE: dict[type, type] = {
    samples.Odometry: OdometryFormat,
    samples.Inertial: InertialFormat,
    samples.Point: PointFormat,
    samples.Polygon: PolygonFormat,
    samples.Gait: GaitFormat,
    samples.ContactPlan: ContactPlanFormat,
    samples.PrimitiveStates: PrimitivesFormat,
    samples.Footsteps: FootstepsFormat,
}


def format_of(topic: Topic, robot: RobotModel) -> Format:
    """The format of one topic."""
    if topic.kind is samples.Joints:
        return cast(Format, JointsFormat(topic, robot))
    if topic.kind is samples.Wrench:
        return cast(Format, WrenchFormat(topic, topic.name in PEOPLE))
    return cast(Format, _SIMPLE[topic.kind](topic))
