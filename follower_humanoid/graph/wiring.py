"""The wiring table: which node runs which object, how often, and what flows where.

The ROS graph and the ROS-free `simulate(...)` are both built from this table, so they cannot differ.
A component is a class with `Config` (a frozen dataclass), `Inputs` and `Outputs` (named tuples or frozen
dataclasses) as attributes, made by `Component(config, robot, period)` with the period in seconds, and
stepped by `step(inputs, time) -> Outputs`. An input or output that is None was not published at that tick.
"""

from __future__ import annotations

import importlib
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

from follower_humanoid.core.topics import TOPICS
from follower_humanoid.errors import UnknownNameError
from follower_humanoid.robot.model import RobotModel

SIMULATOR = "simulator"


class Component(Protocol):
    """What a node runs."""

    Config: type
    Inputs: type
    Outputs: type

    def step(self, inputs: Any, time: float) -> Any:
        """Computes the outputs of the tick at `time` [s]."""


@dataclass(frozen=True)
class NodeWiring:
    """One node.

    Attributes:
        name: Node and executable name.
        component: `module:Class` under this package, imported when the node is made.
        period: Control ticks between two steps.
        inputs: Field of `Inputs` → topic.
        outputs: Field of `Outputs` → topic.
        same_tick: True where the outputs of tick k are used at tick k (state, motor commands);
            all others are used from the node's next period on.
        later: Topics of such a node that are used from the next tick on all the same; who takes its
            place need not publish them.
    """

    name: str
    component: str
    period: int = 1
    inputs: dict[str, str] = field(default_factory=dict)
    outputs: dict[str, str] = field(default_factory=dict)
    same_tick: bool = False
    later: tuple[str, ...] = ()

    def component_class(self) -> Any:
        """Imports the component's class."""
        module, name = self.component.split(":")
        return getattr(importlib.import_module(f"follower_humanoid.{module}"), name)

    def make(self, config: Any, robot: RobotModel, tick: float) -> Component:
        """A fresh component; `tick` is the control tick [s]."""
        component: Component = self.component_class()(config, robot, self.period * tick)
        return component


_BODY_STATE = {"joints": "joint_states", "odometry": "odom"}
_FEET = {"left_foot": "left_foot/wrench", "right_foot": "right_foot/wrench"}
_HANDS = {"left_hand": "left_hand/wrench", "right_hand": "right_hand/wrench"}
_LEADER = {
    "leader_left": "leader/left_hand/wrench",
    "leader_right": "leader/right_hand/wrench",
    "push": "base/push",
}

WIRING: tuple[NodeWiring, ...] = (
    NodeWiring(
        "leader",
        "leader.leader:Leader",
        period=5,
        outputs=_LEADER,
    ),
    NodeWiring(
        SIMULATOR,
        "plant.simulator:Simulator",
        inputs={"legs": "legs/command", "arms": "arms/command", **_LEADER},
        outputs={
            **_BODY_STATE,
            "imu": "imu",
            **_FEET,
            "left_wrist": "left_hand/wrench_raw",
            "right_wrist": "right_hand/wrench_raw",
            "left_applied": "left_hand/applied",
            "right_applied": "right_hand/applied",
            "base_applied": "base/applied",
            "left_contact": "left_hand/contact",
            "right_contact": "right_hand/contact",
        },
        same_tick=True,
    ),
    NodeWiring(
        "wrench_sensing",
        "sensing.hand_wrench:HandWrenchSensing",
        inputs={**_BODY_STATE, "left_wrist": "left_hand/wrench_raw", "right_wrist": "right_hand/wrench_raw"},
        outputs=_HANDS,
    ),
    NodeWiring(
        "gait_mapping",
        "gait.mapping:GaitMapping",
        period=5,
        inputs={**_HANDS, "arms": "arms/mode"},
        outputs={"gait": "gait"},
    ),
    NodeWiring(
        "motion_composition",
        "gait.composition:MotionComposition",
        inputs={**_BODY_STATE, **_FEET, "gait": "gait", "dcm": "dcm"},
        outputs={
            "reference": "motion/reference",
            "base": "motion/base",
            "zmp_reference": "zmp_reference",
            "dcm_reference": "dcm_reference",
            "contacts": "motion/contacts",
            "primitives": "primitives",
            "footsteps": "footsteps",
        },
    ),
    NodeWiring(
        "zmp_balance",
        "balance.balance:ZmpBalance",
        inputs={
            **_BODY_STATE,
            **_FEET,
            **_HANDS,
            "reference": "motion/reference",
            "base": "motion/base",
            "zmp_reference": "zmp_reference",
            "dcm_reference": "dcm_reference",
            "contacts": "motion/contacts",
        },
        outputs={
            "reference": "balance/reference",
            "left_foot_reference": "left_foot/wrench_reference",
            "right_foot_reference": "right_foot/wrench_reference",
            "zmp": "zmp",
            "zmp_command": "zmp_command",
            "com": "com",
            "dcm": "dcm",
            "support_polygon": "support_polygon",
        },
    ),
    NodeWiring(
        "leg_controller",
        "control.legs:LegController",
        inputs={
            **_BODY_STATE,
            **_FEET,
            **_HANDS,
            "reference": "balance/reference",
            "left_foot_reference": "left_foot/wrench_reference",
            "right_foot_reference": "right_foot/wrench_reference",
        },
        outputs={"command": "legs/command"},
        same_tick=True,
    ),
    NodeWiring(
        "arm_controller",
        "control.arms:ArmController",
        inputs={**_BODY_STATE, "imu": "imu", **_HANDS},
        outputs={"command": "arms/command", "mode": "arms/mode"},
        same_tick=True,
        later=("arms/mode",),
    ),
)

NODES: dict[str, NodeWiring] = {node.name: node for node in WIRING}

# Only where an experiment leads a hand: who says where it shall go, and the controller listening.
ARM_TASK = NodeWiring(
    "arm_task",
    "arm_experiment.arm_task:ArmTask",
    inputs={"joints": "joint_states", "imu": "imu"},
    outputs={"left_target": "left_hand/target"},
)
_LED_ARMS = replace(
    NODES["arm_controller"], inputs={**NODES["arm_controller"].inputs, "left_target": "left_hand/target"}
)

PRODUCER: dict[str, NodeWiring] = {
    topic: node for node in (*WIRING, ARM_TASK) for topic in node.outputs.values()
}


def nodes_with(present: Collection[str]) -> dict[str, NodeWiring]:
    """The wiring table as it is when the given nodes run: with `arm_task` the arms take its targets."""
    if ARM_TASK.name not in present:
        return NODES
    return {**NODES, _LED_ARMS.name: _LED_ARMS, ARM_TASK.name: ARM_TASK}


def node_wiring(name: str, present: Collection[str] = ()) -> NodeWiring:
    """The wiring of one node, among the given others.

    Raises:
        UnknownNameError: No node of that name.
    """
    table = nodes_with((name, *present))
    if name not in table:
        raise UnknownNameError("node", name, table)
    return table[name]


def is_same_tick(topic: str) -> bool:
    """Whether what is published for a tick is used at that tick: state and motor commands."""
    producer = PRODUCER[topic]
    return producer.same_tick and topic not in producer.later


def is_optional(topic: str) -> bool:
    """Whether somebody's own node in the place of ours may leave a topic out."""
    return topic in PRODUCER[topic].later


def used_tick(tick: int, topic: str) -> int:
    """The tick whose message on `topic` is used at `tick`; negative: none yet.

    State and commands of a tick are used at that tick; what a node with period P computes at
    tick mP is used from tick (m+1)P on.
    """
    if topic not in TOPICS:
        raise UnknownNameError("topic", topic, TOPICS)
    return tick if is_same_tick(topic) else last_period(tick, PRODUCER[topic].period)


def last_period(tick: int, period: int) -> int:
    """When the period before the one that `tick` is in began."""
    return (tick // period - 1) * period
