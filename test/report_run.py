"""A made-up run for the report: two steps and a closing one on straight legs, 100 ticks a second."""

from __future__ import annotations

import numpy as np

from follower_humanoid.core.samples import (
    SIDES,
    Array,
    Footstep,
    Footsteps,
    Gait,
    Joints,
    Odometry,
    Point,
    Polygon,
    PrimitiveStates,
    Sample,
    Side,
    Wrench,
)
from follower_humanoid.graph.record import Run, RunRecorder
from follower_humanoid.robot.model import RobotModel

TICK = 0.01
LEG = 0.42 + 0.41
ANKLE = 0.08
WEIGHT = 716.0
# side, lift-off, landing, from, to
SWINGS = ((Side.RIGHT, 1.0, 2.0, 0.0, 0.4), (Side.LEFT, 3.0, 4.0, 0.0, 0.8), (Side.RIGHT, 5.0, 6.0, 0.4, 0.8))
DURATION = 7.0


def knee_at(side: Side, time: float) -> float:
    """Bend of the knee that lifts a foot on its way [rad]."""
    for swing_side, lifted, landed, _, _ in SWINGS:
        if swing_side is side and lifted < time < landed:
            return 0.6 * np.sin(np.pi * (time - lifted) / (landed - lifted))
    return 0.0


def foot_at(side: Side, time: float) -> tuple[float, bool]:
    """Place of a foot along x [m], and whether it is in the air."""
    place = 0.0
    for swing_side, lifted, landed, begin, end in SWINGS:
        if swing_side is side and time >= lifted:
            part = min((time - lifted) / (landed - lifted), 1.0)
            place = begin + (end - begin) * part
            if lifted <= time < landed:
                return place, True
    return place, False


def state(robot: RobotModel, time: float) -> tuple[Joints, Odometry]:
    """The posture that puts the feet where they belong, soles level."""
    feet = {side: foot_at(side, time)[0] for side in SIDES}
    middle = sum(feet.values()) / 2
    position = np.zeros(45)
    for side in SIDES:
        angle = -np.arcsin((feet[side] - middle) / LEG)
        knee = knee_at(side, time)
        position[robot.joint_index(f"{side.prefix}_hip_pitch")] = angle - knee / 2
        position[robot.joint_index(f"{side.prefix}_knee")] = knee
        position[robot.joint_index(f"{side.prefix}_ankle_pitch")] = -angle - knee / 2
    height = ANKLE + LEG * np.cos(angle)
    base = Odometry(np.array([middle, 0.0, height]), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))
    return Joints(position, np.zeros(45), np.zeros(45)), base


def carried(time: float) -> dict[Side, float]:
    """Vertical force on each foot [N]; a landing foot bounces once."""
    in_air = {side: foot_at(side, time)[1] for side in SIDES}
    forces = {side: 0.0 if in_air[side] else WEIGHT / (1 + (not in_air[side.other])) for side in SIDES}
    if 2.02 <= time < 2.05:
        forces[Side.RIGHT] = 0.0
    return forces


def sole_corners(x: float, y: float) -> Array:
    return np.array(
        [[x - 0.07, y - 0.05, 0], [x + 0.19, y - 0.05, 0], [x + 0.19, y + 0.05, 0], [x - 0.07, y + 0.05, 0]]
    )


def flow(robot: RobotModel, tick: int) -> dict[str, Sample]:
    """Everything that is published at a tick."""
    time = tick * TICK
    joints, odometry = state(robot, time)
    forces = carried(time)
    middle = float(odometry.position[0])
    pull, zero = np.array([5.0, 0.0, -10.0]), np.zeros(3)
    volts = 10.0 * np.sin(time + np.arange(45.0))
    at = {side: sole_corners(foot_at(side, time)[0], 0.09 * side.sign) for side in SIDES if forces[side] > 0}
    moving = any(lifted - 0.5 <= time < landed for _, lifted, landed, _, _ in SWINGS)
    taken = [
        Footstep(side, np.array([end, 0.09 * side.sign, 0.0]), 0.0, time >= landed, counted=number < 2)
        for number, (side, _, landed, _, end) in enumerate(SWINGS)
    ]
    return {
        "joint_states": joints,
        "odom": odometry,
        **{f"{side.value}_foot/wrench": Wrench(np.array([0.0, 0.0, forces[side]]), zero) for side in SIDES},
        "left_hand/applied": Wrench(pull, zero),
        "right_hand/applied": Wrench(zero, zero),
        "left_hand/wrench": Wrench(pull, zero),
        "right_hand/wrench": Wrench(zero, zero),
        "gait": Gait(1.0, 0.1, 1.25, 1.0, 0.1),
        "primitives": PrimitiveStates(("lean", "bend"), (0.5, 0.5)) if moving else PrimitiveStates((), ()),
        "footsteps": Footsteps(tuple(taken)),
        "zmp": Point(np.array([middle, 0.0, 0.0])),
        "com": Point(np.array([middle, 0.01, 0.9])),
        "support_polygon": Polygon(np.concatenate(list(at.values()))),
        "legs/command": Joints(zero[:0], zero[:0], volts[:31]),
        "arms/command": Joints(zero[:0], zero[:0], volts[31:]),
    }


def walking(without: tuple[str, ...] = (), until: float = DURATION) -> Run:
    """The whole run, or its beginning."""
    robot = RobotModel()
    recorder = RunRecorder(TICK, robot.joint_names, robot.urdf)
    for tick in range(round(until / TICK) + 1):
        for topic, sample in flow(robot, tick).items():
            if topic not in without:
                recorder.add(topic, tick, sample)
    return recorder.finish()
