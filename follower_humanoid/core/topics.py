"""Every topic of the graph: kind of sample, frame, order of entries, and who may read it.

This is the contract as data. The ROS layer makes publishers, subscriptions and layouts from it;
a test reads it and the running graph and fails where they differ.
"""

from __future__ import annotations

from dataclasses import dataclass

from follower_humanoid.core import samples


@dataclass(frozen=True)
class Topic:
    """One topic.

    Attributes:
        name: Relative name.
        kind: Sample type.
        frame: Frame id of the message header.
        joints: Which joints a `Joints` sample lists: `all`, `legs` (with trunk and neck) or `arms`.
        child_frame: Child frame of an odometry message.
        everybody: False where only the simulator, the recorder and the viewer may listen.
    """

    name: str
    kind: type
    frame: str = "world"
    joints: str = ""
    child_frame: str = ""
    everybody: bool = True


_TABLE = (
    # simulator
    Topic("joint_states", samples.Joints, "base_link", joints="all"),
    Topic("odom", samples.Odometry, child_frame="base_link"),
    Topic("imu", samples.Inertial, "base_link"),
    Topic("left_foot/wrench", samples.Wrench, "l_sole"),
    Topic("right_foot/wrench", samples.Wrench, "r_sole"),
    Topic("left_hand/wrench_raw", samples.Wrench, "l_wrist"),
    Topic("right_hand/wrench_raw", samples.Wrench, "r_wrist"),
    Topic("left_hand/applied", samples.Wrench, everybody=False),
    Topic("right_hand/applied", samples.Wrench, everybody=False),
    Topic("base/applied", samples.Wrench, everybody=False),
    Topic("left_hand/contact", samples.Wrench, everybody=False),
    Topic("right_hand/contact", samples.Wrench, everybody=False),
    # leader, or anybody
    Topic("leader/left_hand/wrench", samples.Wrench, everybody=False),
    Topic("leader/right_hand/wrench", samples.Wrench, everybody=False),
    Topic("base/push", samples.Wrench, everybody=False),
    # wrench_sensing
    Topic("left_hand/wrench", samples.Wrench),
    Topic("right_hand/wrench", samples.Wrench),
    # gait_mapping
    Topic("gait", samples.Gait),
    # motion_composition
    Topic("motion/reference", samples.Joints, "base_link", joints="all"),
    Topic("motion/base", samples.Odometry, child_frame="base_link"),
    Topic("zmp_reference", samples.Point),
    Topic("dcm_reference", samples.Point),
    Topic("motion/contacts", samples.ContactPlan),
    Topic("primitives", samples.PrimitiveStates),
    Topic("footsteps", samples.Footsteps),
    # zmp_balance
    Topic("balance/reference", samples.Joints, "base_link", joints="all"),
    Topic("left_foot/wrench_reference", samples.Wrench, "l_sole"),
    Topic("right_foot/wrench_reference", samples.Wrench, "r_sole"),
    Topic("zmp", samples.Point),
    Topic("zmp_command", samples.Point),
    Topic("com", samples.Point),
    Topic("dcm", samples.Point),
    Topic("support_polygon", samples.Polygon),
    # controllers
    Topic("legs/command", samples.Joints, "base_link", joints="legs"),
    Topic("arms/command", samples.Joints, "base_link", joints="arms"),
    Topic("arms/mode", samples.PrimitiveStates),
    # arm_task
    Topic("left_hand/target", samples.Odometry, "base_link", child_frame="l_gripper_target"),
)

TOPICS: dict[str, Topic] = {topic.name: topic for topic in _TABLE}

# What people do to the robot: they have clocks of their own.
PEOPLE = frozenset({"leader/left_hand/wrench", "leader/right_hand/wrench", "base/push"})

# Text of a footprint, in `footsteps`, that is no half-step.
CLOSING_STEP = "closing step"

# Who besides "any" may read: topics not listed here are open to every node of the package.
READERS: dict[str, frozenset[str]] = {
    "left_hand/wrench_raw": frozenset({"wrench_sensing"}),
    "right_hand/wrench_raw": frozenset({"wrench_sensing"}),
    "odom": frozenset(
        {"wrench_sensing", "motion_composition", "zmp_balance", "leg_controller", "arm_controller"}
    ),
    "left_foot/wrench": frozenset(
        {"motion_composition", "zmp_balance", "leg_controller", "arm_controller"}
    ),
    "right_foot/wrench": frozenset(
        {"motion_composition", "zmp_balance", "leg_controller", "arm_controller"}
    ),
    "left_hand/wrench": frozenset({"gait_mapping", "arm_controller", "zmp_balance", "leg_controller"}),
    "right_hand/wrench": frozenset({"gait_mapping", "arm_controller", "zmp_balance", "leg_controller"}),
    "gait": frozenset({"motion_composition"}),
    "motion/reference": frozenset({"zmp_balance", "leg_controller"}),
    "balance/reference": frozenset({"leg_controller"}),
    "legs/command": frozenset({"simulator"}),
    "arms/command": frozenset({"simulator"}),
    "left_hand/target": frozenset({"arm_controller"}),
    **{topic.name: frozenset({"simulator"}) for topic in _TABLE if not topic.everybody},
}
