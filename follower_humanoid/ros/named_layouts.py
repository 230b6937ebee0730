"""Formats of the JointState messages: joints under their names, and named values that are no joints."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from sensor_msgs.msg import JointState

from follower_humanoid.core import samples
from follower_humanoid.core.samples import Array
from follower_humanoid.core.topics import Topic
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.layouts import Blocks, Stamped
from follower_humanoid.ros.validation import column, order_of


class JointsFormat(Stamped):
    """Joint values under their names."""

    message_type = JointState

    def __init__(self, topic: Topic, robot: RobotModel) -> None:
        super().__init__(topic)
        names = robot.joint_names
        if topic.joints != "all":
            group = robot.groups.legs if topic.joints == "legs" else robot.groups.arms
            names = tuple(names[i] for i in group)
        self._names = names
        # Commands may leave out the references they were computed for, references the effort.
        self._optional: dict[str, float] = {}
        if topic.joints != "all":
            self._optional = {"position": math.nan, "velocity": math.nan}
        elif topic.name != "joint_states":
            self._optional = {"effort": 0.0}

    def template(self, shape: None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        n = len(self._names)
        zeros = [0.0] * n
        message = JointState(name=list(self._names), position=zeros, velocity=zeros, effort=zeros)
        return self.framed(message), (("position", n), ("velocity", n), ("effort", n))

    def numbers(self, sample: samples.Joints) -> tuple[Array, ...]:
        """One array per block."""
        return sample.position, sample.velocity, sample.effort

    def sample(self, blocks: list[Array], shape: None) -> samples.Joints:
        """The inverse of `numbers`."""
        return samples.Joints(*blocks)

    def read(self, message: JointState) -> samples.Joints:
        """Any valid message, the slow way."""
        order = order_of(self.topic.name, message.name, self._names)
        return samples.Joints(
            *(
                column(
                    self.topic.name, name, getattr(message, name), order, len(order), self._optional.get(name)
                )
                for name in ("position", "velocity", "effort")
            )
        )


class _NamedValues(Stamped):
    """A JointState whose names are not joints; velocity and effort mean nothing and stay zero."""

    message_type = JointState

    def _named(self, names: tuple[str, ...]) -> tuple[Any, Blocks]:
        zeros = [0.0] * len(names)
        message = JointState(name=list(names), position=zeros, velocity=zeros, effort=zeros)
        return self.framed(message), (("position", len(names)),) if names else ()


class GaitFormat(_NamedValues):
    """The walking parameters."""

    NAMES = ("walk_speed", "walk_dir", "step_length", "step_height", "heading")

    def template(self, shape: None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        return self._named(self.NAMES)

    def numbers(self, sample: samples.Gait) -> tuple[Array, ...]:
        """One array per block."""
        return (np.array([getattr(sample, name) for name in self.NAMES]),)

    def sample(self, blocks: list[Array], shape: None) -> samples.Gait:
        """The inverse of `numbers`."""
        return samples.Gait(*blocks[0].tolist())

    def read(self, message: JointState) -> samples.Gait:
        """Any valid message, the slow way."""
        name = self.topic.name
        order = order_of(name, message.name, self.NAMES, optional=("heading",))
        if order[-1] < 0:  # no heading: the pelvis looks where it goes
            order[-1] = order[self.NAMES.index("walk_dir")]
        return self.sample([column(name, "position", message.position, order, len(message.name))], None)


class ContactPlanFormat(_NamedValues):
    """Planned share of the weight per foot."""

    NAMES = ("left", "right")

    def template(self, shape: None) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        return self._named(self.NAMES)

    def numbers(self, sample: samples.ContactPlan) -> tuple[Array, ...]:
        """One array per block."""
        return (np.array([sample.left, sample.right]),)

    def sample(self, blocks: list[Array], shape: None) -> samples.ContactPlan:
        """The inverse of `numbers`."""
        return samples.ContactPlan(*blocks[0].tolist())

    def read(self, message: JointState) -> samples.ContactPlan:
        """Any valid message, the slow way."""
        order = order_of(self.topic.name, message.name, self.NAMES)
        return self.sample([column(self.topic.name, "position", message.position, order, 2)], None)


class PrimitivesFormat(_NamedValues):
    """Active motion primitives and their completion."""

    fast_reading = False

    def shape(self, sample: samples.PrimitiveStates) -> tuple[str, ...]:
        """What decides the template."""
        return sample.names

    def template(self, shape: tuple[str, ...]) -> tuple[Any, Blocks]:
        """The message without its numbers, and where they lie."""
        return self._named(shape)

    def numbers(self, sample: samples.PrimitiveStates) -> tuple[Array, ...]:
        """One array per block."""
        return (np.array(sample.completion, dtype=np.float64),) if sample.names else ()

    def sample(self, blocks: list[Array], shape: tuple[str, ...]) -> samples.PrimitiveStates:
        """The inverse of `numbers`."""
        return samples.PrimitiveStates(shape, tuple(blocks[0].tolist()) if shape else ())

    def read(self, message: JointState) -> samples.PrimitiveStates:
        """Any valid message, the slow way."""
        names = tuple(message.name)
        order = order_of(self.topic.name, names, names)
        return self.sample([column(self.topic.name, "position", message.position, order, len(names))], names)
