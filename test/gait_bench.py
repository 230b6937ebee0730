"""Help for the tests of gait and balance: a standing robot, a walker without a body, an ideal body."""

from __future__ import annotations

import copyreg
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Any

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import SIDES, Array, Footstep, Gait, Joints, Odometry, Side, Wrench
from follower_humanoid.gait.composition import CompositionOutputs, MotionComposition
from follower_humanoid.gait.differential_ik import DifferentialIk
from follower_humanoid.gait.feet import FootPose, FootstepConfig
from follower_humanoid.gait.motion_config import CompositionConfig
from follower_humanoid.gait.sequence import Sequence, load_sequence
from follower_humanoid.gait.walk_plan import WalkerConfig
from follower_humanoid.gait.walker import Walker
from follower_humanoid.robot.model import RobotModel

STAND = Gait(0.0, 0.0, 1.0, 1.0, 0.0)
AHEAD = Gait(1.0, 0.0, 1.0, 1.0, 0.0)
WEIGHT = 716.0  # about what the robot weighs [N]

GaitPlan = Callable[[float], Gait]


@cache
def robot() -> RobotModel:
    return RobotModel()


def always(gait: Gait) -> GaitPlan:
    return lambda time: gait


def until(time: float, first: Gait, then: Gait = STAND) -> GaitPlan:
    return lambda now: first if now < time else then


def mirrored_gait(gait: Gait) -> Gait:
    """Reflected in the plane y = 0."""
    return replace(gait, walk_dir=-gait.walk_dir, heading=-gait.heading)


@cache
def standing_configuration() -> Array:
    """Feet parallel below the hips, flat on the ground, knees bent, CoM over the feet, shape (52,)."""
    model, data = robot().pin_model, robot().pin_model.createData()
    q = np.array(pin.neutral(model))
    for prefix in "lr":
        for name, value in (("hip_pitch", -0.35), ("knee", 0.7), ("ankle_pitch", -0.35), ("elbow", -1.5)):
            q[7 + robot().joint_index(f"{prefix}_{name}")] = value
    pin.forwardKinematics(model, data, q)
    sole = pin.updateFramePlacement(model, data, robot().frame_id("l_sole"))
    q[0] -= sole.translation[0]
    q[2] -= sole.translation[2]
    return q


def standing_feet() -> dict[Side, FootPose]:
    return {side: FootPose(side, 0.0, side.sign * 0.09, 0.0) for side in SIDES}


def odometry_of(q: Array, v: Array | None = None) -> Odometry:
    v = np.zeros(6) if v is None else v
    return Odometry(q[:3].copy(), q[3:7].copy(), v[:3].copy(), v[3:6].copy())


def frame_pose(q: Array, name: str) -> pin.SE3:
    model, data = robot().pin_model, robot().pin_model.createData()
    pin.forwardKinematics(model, data, q)
    return pin.updateFramePlacement(model, data, robot().frame_id(name)).copy()


def frame_at(position: Array, rotation: Array) -> Array:
    """Axes and origin of a frame, shape (4, 3), as in `pose_table`."""
    return np.array([*rotation.T, position])


def inputs_of(component: Any, **known: Any) -> Any:
    """Inputs of a component; what is not given has not come yet."""
    return component.Inputs(**{**dict.fromkeys(component.Inputs.__match_args__), **known})


def vertical(force: float) -> Wrench:
    return Wrench(np.array([0.0, 0.0, force]), np.zeros(3))


@dataclass
class Tick:
    """What a walker did in one tick."""

    time: float
    zmp: Array
    zmp_speed: Array
    swinging: Side | None
    place: dict[Side, Array]
    landed: Side | None
    shares: dict[Side, float]
    primitives: tuple[str, ...]
    toe: float


class WalkerBench:
    """A walker without a body: feet land exactly where they are sent."""

    def __init__(
        self, config: WalkerConfig | None = None, sequence: Sequence | None = None,
        footsteps: FootstepConfig | None = None, dt: float = 0.01,
    ) -> None:  # fmt: skip
        self.config = config or WalkerConfig()
        self.footsteps = footsteps or FootstepConfig()
        self.sequence = sequence or load_sequence()
        self.dt = dt
        self.time = 0.0
        rest = np.array([self.config.stand_forward, 0.0])
        self.walker = Walker(self.config, self.footsteps, self.sequence, standing_feet(), rest)
        self.history: list[Tick] = []

    def tick(self, gait: Gait, loads: dict[Side, float] | None = None, steady: bool = True) -> Tick:
        walker = self.walker
        toes = dict.fromkeys(SIDES, 0.0)
        loads = loads or dict.fromkeys(SIDES, 0.0)
        landed = walker.step(gait=gait, loads=loads, toes=toes, steady=steady, dt=self.dt)
        self.time += self.dt
        half = walker.half_step
        place = {
            side: np.array([foot.x, foot.y, foot.z, foot.yaw, 0.0]) for side, foot in walker.feet.items()
        }
        if half is not None:
            swing = half.swing
            place[swing.side] = np.concatenate(
                (swing.place.position, swing.height.position, swing.attitude.position)
            )
        done = Tick(
            self.time, walker.zmp.position.copy(), walker.zmp.velocity.copy(), walker.swinging, place, landed,
            dict(walker.shares), half.active()[0] if half is not None else (),
            float(half.swing.toe.position[0]) if half is not None else 0.0,
        )  # fmt: skip
        self.history.append(done)
        return done

    def run(self, seconds: float, gait: GaitPlan) -> list[Tick]:
        """The ticks of so many seconds more."""
        return [self.tick(gait(self.time)) for _ in range(round(seconds / self.dt))]

    def landings(self) -> list[Tick]:
        return [tick for tick in self.history if tick.landed is not None]

    def swings(self) -> list[list[Tick]]:
        """The ticks of each single support."""
        found: list[list[Tick]] = []
        last: Side | None = None
        for tick in self.history:
            if tick.swinging is not None:
                if last is not tick.swinging:
                    found.append([])
                found[-1].append(tick)
            last = tick.swinging
        return found


def _own_copy(ik: DifferentialIk) -> DifferentialIk:
    twin = DifferentialIk(robot(), ik._config, ik.q)
    twin.v = ik.v.copy()
    twin.update()
    return twin


# For `copy.deepcopy` of an ideal robot: views that are copied would no longer follow Pinocchio's memory.
copyreg.pickle(DifferentialIk, lambda ik: (partial(_own_copy, ik), ()))


@dataclass
class IdealRobot:
    """Motion composition on a body that does exactly what the reference says."""

    dt: float = 0.01
    config: CompositionConfig = field(default_factory=CompositionConfig)
    time: float = 0.0
    outputs: list[CompositionOutputs] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.composition = MotionComposition(self.config, robot(), self.dt)
        q = standing_configuration()
        self.joints = Joints(q[7:].copy(), np.zeros(45), np.zeros(45))
        self.base = odometry_of(q)
        self.loads = dict.fromkeys(SIDES, 0.5)

    def tick(self, gait: Gait | None) -> CompositionOutputs:
        left, right = (vertical(WEIGHT * self.loads[side]) for side in SIDES)
        known = {
            "joints": self.joints,
            "odometry": self.base,
            "left_foot": left,
            "right_foot": right,
            "gait": gait,
        }
        out = self.composition.step(inputs_of(MotionComposition, **known), self.time)
        self.time += self.dt
        self.joints, self.base = out.reference, out.base
        total = out.contacts.left + out.contacts.right
        self.loads = {Side.LEFT: out.contacts.left / total, Side.RIGHT: out.contacts.right / total}
        self.outputs.append(out)
        return out

    def run(self, seconds: float, gait: GaitPlan) -> list[CompositionOutputs]:
        return [self.tick(gait(self.time)) for _ in range(round(seconds / self.dt))]

    def sole(self, side: Side) -> pin.SE3:
        return frame_pose(configuration_of(self.outputs[-1]), f"{side.prefix}_sole")

    def foot(self, side: Side) -> FootPose:
        sole = self.sole(side)
        return FootPose(side, *map(float, sole.translation[:2]), yaw_of(sole.rotation))

    def steps(self) -> list[Footstep]:
        """All steps taken so far, in order, from what was published."""
        found: dict[tuple[float, ...], Footstep] = {}
        for out in self.outputs:
            for step in out.footsteps.steps if out.footsteps is not None else ():
                if step.taken:
                    found.setdefault((*step.position, step.yaw), step)
        return list(found.values())


def configuration_of(out: CompositionOutputs) -> Array:
    return robot().configuration(out.base, out.reference.position)


def velocity_of(out: CompositionOutputs) -> Array:
    return robot().velocity(out.base, out.reference.velocity)


def yaw_of(rotation: Array) -> float:
    return math.atan2(rotation[1, 0], rotation[0, 0])
