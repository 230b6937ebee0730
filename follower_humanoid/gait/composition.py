"""Motion composition: from the walking parameters to the reference of every joint.

Savić et al. 2016, section "RAMP-based framework": primitives are combined into half-steps, their
parameters follow the walking parameters at every tick, and the result is a vector of joint velocities.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import (
    SIDES,
    Array,
    ContactPlan,
    Footstep,
    Footsteps,
    Gait,
    Joints,
    Odometry,
    Point,
    PrimitiveStates,
    Side,
    Wrench,
)
from follower_humanoid.gait.feet import FootPose, half_step_length
from follower_humanoid.gait.limits import limited
from follower_humanoid.gait.motion_config import CompositionConfig
from follower_humanoid.gait.reference_motion import STANDING, ReferenceMotion
from follower_humanoid.gait.sequence import load_sequence
from follower_humanoid.gait.walker import Walker
from follower_humanoid.robot.model import RobotModel

TOLD_LENGTHS = 50  # half-steps whose lengths diagnostics tell
SHOWN_STEPS = 8  # taken footsteps that stay in the message


@dataclass(frozen=True, slots=True)
class CompositionInputs:
    """State of the tick and the walking parameters (None before the first ones)."""

    joints: Joints
    odometry: Odometry
    left_foot: Wrench
    right_foot: Wrench
    gait: Gait | None
    dcm: Point | None


@dataclass(frozen=True, slots=True)
class CompositionOutputs:
    """The reference motion and the plan behind it."""

    reference: Joints
    base: Odometry
    zmp_reference: Point
    dcm_reference: Point
    contacts: ContactPlan
    primitives: PrimitiveStates
    footsteps: Footsteps | None


class MotionComposition:
    """Composes primitives into the reference motion of the whole body."""

    Config = CompositionConfig
    Inputs = CompositionInputs
    Outputs = CompositionOutputs

    def __init__(self, config: CompositionConfig, robot: RobotModel, period: float) -> None:
        self._config = config
        self._robot = robot
        self._period = period
        self._sequence = load_sequence(config.sequence)
        self._data = robot.pin_model.createData()
        self._motion: ReferenceMotion | None = None
        self._footsteps_sent: object = None
        self._lengths: list[float] = []
        self._asked: Gait | None = None
        self._gait = STANDING
        self._cut = False
        self._cut_ticks = 0

    def step(self, inputs: CompositionInputs, time: float) -> CompositionOutputs:
        """One tick: walking parameters in, joint reference out."""
        del time
        if self._motion is None:
            q = self._measured(inputs)
            feet = {side: self._measured_foot(side, q) for side in SIDES}
            self._motion = ReferenceMotion(self._config, self._robot, self._sequence, feet, q)
        motion, walker = self._motion, self._motion.walker
        gait = motion.within_reach(self._limited(inputs.gait))
        loads = {Side.LEFT: float(inputs.left_foot.force[2]), Side.RIGHT: float(inputs.right_foot.force[2])}
        dcm = None if inputs.dcm is None else inputs.dcm.xyz[:2]
        landed = walker.step(gait, loads, motion.body.toes, motion.steady, self._period)
        if landed is not None:
            self._anchor(walker, landed, self._measured(inputs))
        coming = motion.advance(gait, dcm, self._period)
        reference, base = motion.body.samples()
        pendulum = motion.pendulum.state
        names, completion = walker.half_step.active() if walker.half_step is not None else ((), ())
        return CompositionOutputs(
            reference=reference,
            base=base,
            zmp_reference=Point.on_ground(pendulum.zmp),
            dcm_reference=Point.on_ground(pendulum.dcm),
            contacts=walker.contacts(),
            primitives=PrimitiveStates(names, completion),
            footsteps=self._changed_footsteps(walker, coming, gait),
        )

    def diagnostics(self) -> dict[str, float | str]:
        """Counted half-steps and the measured lengths of the last ones."""
        lengths = ", ".join(f"{length:.3f}" for length in self._lengths[-TOLD_LENGTHS:])
        heading = self._motion.walker.heading() if self._motion is not None else 0.0
        return {
            "half_steps": len(self._lengths),
            "lengths [m]": lengths,
            "heading [rad]": heading,
            "gait_limited_ticks": self._cut_ticks,
        }

    def _measured(self, inputs: CompositionInputs) -> Array:
        return self._robot.configuration(inputs.odometry, inputs.joints.position)

    def _limited(self, asked: Gait | None) -> Gait:
        """The walking parameters within their limits, standing before the first ones; counts what was cut."""
        if asked is not self._asked:
            self._asked = asked
            self._gait = STANDING if asked is None else limited(asked, self._config.limits)
            self._cut = asked is not None and self._gait != asked
        self._cut_ticks += int(self._cut)
        return self._gait

    def _measured_foot(self, side: Side, q: Array) -> FootPose:
        pin.forwardKinematics(self._robot.pin_model, self._data, q)
        frame = self._robot.frame_id(f"{side.prefix}_sole")
        sole = pin.updateFramePlacement(self._robot.pin_model, self._data, frame)
        yaw = math.atan2(sole.rotation[1, 0], sole.rotation[0, 0])
        return FootPose(side, float(sole.translation[0]), float(sole.translation[1]), yaw)

    def _anchor(self, walker: Walker, landed: Side, q: Array) -> None:
        """The plan goes on from where the foot really stands."""
        foot = self._measured_foot(landed, q)
        walker.anchor(landed, foot)
        if walker.taken[-1][1]:
            self._lengths.append(half_step_length(foot, walker.feet[landed.other]))

    def _changed_footsteps(
        self, walker: Walker, coming: tuple[FootPose, ...], gait: Gait
    ) -> Footsteps | None:
        """The steps, when one was taken, or the next one moved by a millimetre, or the last one is near."""
        closing = walker.half_step is not None and walker.half_step.closing
        stops, place = gait.walk_speed == 0.0, None
        if coming:
            place = round(coming[0].x, 3), round(coming[0].y, 3), round(coming[0].yaw, 3)
        state = len(walker.taken), place, closing, stops
        if state == self._footsteps_sent:
            return None
        self._footsteps_sent = state
        taken = [_footstep(foot, True, walked) for foot, walked in walker.taken[-SHOWN_STEPS:]]
        last = len(coming) - 1 if stops else None  # it brings the feet together
        planned = [
            _footstep(foot, False, not closing if n == 0 else n != last) for n, foot in enumerate(coming)
        ]
        return Footsteps((*taken, *planned))


def _footstep(foot: FootPose, taken: bool, counted: bool) -> Footstep:
    return Footstep(foot.side, np.array([foot.x, foot.y, foot.z]), foot.yaw, taken, counted)
