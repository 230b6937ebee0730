"""Motion composition: from the walking parameters to the reference of every joint.

Savić et al. 2016, section "RAMP-based framework": primitives are combined into half-steps, their
parameters follow the walking parameters at every tick, and the result is a vector of joint velocities.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import parameter
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
from follower_humanoid.gait.capture import CaptureConfig, footprint_weight, landing_shift, shifted
from follower_humanoid.gait.feet import FootPose, FootstepConfig, half_step_length
from follower_humanoid.gait.limits import GaitLimits, limited
from follower_humanoid.gait.pendulum import ReferencePendulum, momentum_shift, natural_frequency
from follower_humanoid.gait.preview import planned_dcm
from follower_humanoid.gait.sequence import Sequence, load_sequence
from follower_humanoid.gait.walker import Walker, WalkerConfig
from follower_humanoid.gait.whole_body import BodyConfig, ReferenceBody
from follower_humanoid.robot.model import RobotModel

STANDING = Gait(walk_speed=0.0, walk_dir=0.0, step_length=1.0, step_height=1.0, heading=0.0)
SHOWN_STEPS = 8  # taken footsteps that stay in the message


@dataclass(frozen=True)
class CompositionConfig:
    """Parameters of motion composition."""

    sequence: str = parameter(
        "", "file with the sequence of primitives; empty: the package's half-step", path=True
    )
    dcm_convergence: float = parameter(
        4.0, "rate at which the reference DCM joins a changed plan", "1/s", 0.5, 20
    )
    zmp_reach: float = parameter(
        0.03, "largest ZMP shift to join a changed plan, one foot carrying", "m", 0, 0.1
    )
    zmp_reach_double: float = parameter(0.09, "the same, both feet carrying", "m", 0, 0.2)
    walker: WalkerConfig = field(default_factory=WalkerConfig)
    footsteps: FootstepConfig = field(default_factory=FootstepConfig)
    limits: GaitLimits = field(default_factory=GaitLimits)
    capture: CaptureConfig = field(default_factory=CaptureConfig)
    body: BodyConfig = field(default_factory=BodyConfig)


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
        self._footsteps_sent: tuple[int, float | None] | None = None
        self._lengths: list[float] = []
        self._cut_ticks = 0

    def step(self, inputs: CompositionInputs, time: float) -> CompositionOutputs:
        """One tick: walking parameters in, joint reference out."""
        del time
        q = self._robot.configuration(inputs.odometry, inputs.joints.position)
        if self._motion is None:
            feet = {side: self._measured_foot(side, q) for side in SIDES}
            self._motion = ReferenceMotion(self._config, self._robot, self._sequence, feet, q)
        motion, walker = self._motion, self._motion.walker
        asked = inputs.gait if inputs.gait is not None else STANDING
        gait = limited(asked, self._config.limits)
        self._cut_ticks += int(gait != asked)
        loads = {Side.LEFT: float(inputs.left_foot.force[2]), Side.RIGHT: float(inputs.right_foot.force[2])}
        dcm = None if inputs.dcm is None else inputs.dcm.xyz[:2]
        landed = walker.step(gait, loads, motion.body.toes, motion.steady(dcm), self._period)
        if landed is not None:
            self._anchor(walker, landed, q)
        coming = motion.advance(gait, dcm, self._period)
        reference, base = motion.body.samples()
        pendulum = motion.pendulum.state
        names, completion = walker.half_step.active() if walker.half_step is not None else ((), ())
        return CompositionOutputs(
            reference=reference,
            base=base,
            zmp_reference=Point(np.array([pendulum.zmp[0], pendulum.zmp[1], 0.0])),
            dcm_reference=Point(np.array([pendulum.dcm[0], pendulum.dcm[1], 0.0])),
            contacts=walker.contacts(),
            primitives=PrimitiveStates(names, completion),
            footsteps=self._changed_footsteps(walker, coming),
        )

    def diagnostics(self) -> dict[str, float | str]:
        """Counted half-steps and their measured lengths."""
        lengths = ", ".join(f"{length:.3f}" for length in self._lengths)
        heading = self._motion.walker.heading() if self._motion is not None else 0.0
        return {
            "half_steps": len(self._lengths),
            "lengths [m]": lengths,
            "heading [rad]": heading,
            "gait_limited_ticks": self._cut_ticks,
        }

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

    def _changed_footsteps(self, walker: Walker, coming: tuple[FootPose, ...]) -> Footsteps | None:
        """The steps, when one was taken or the next one moved by a millimetre."""
        state = (len(walker.taken), round(coming[0].x + coming[0].y + coming[0].yaw, 3) if coming else None)
        if state == self._footsteps_sent:
            return None
        self._footsteps_sent = state
        taken = [_footstep(foot, True, counted) for foot, counted in walker.taken[-SHOWN_STEPS:]]
        return Footsteps((*taken, *(_footstep(foot, False, True) for foot in coming)))


class ReferenceMotion:
    """Walker, pendulum and body that move together, tick by tick.

    Attributes:
        walker: Half-steps and plan.
        pendulum: Reference CoM, DCM, ZMP.
        body: Reference configuration.
    """

    def __init__(
        self,
        config: CompositionConfig,
        robot: RobotModel,
        sequence: Sequence,
        feet: dict[Side, FootPose],
        q: Array,
    ) -> None:
        """Starts at rest in the measured configuration q, shape (52,), on the measured feet."""  # fmt: skip
        self._config = config
        self._mass = robot.mass
        self.body = ReferenceBody(config.body, robot, q)
        com = self.body.ik.com[:2]
        self.walker = Walker(config.walker, config.footsteps, sequence, feet, com)
        self.pendulum = ReferencePendulum(com, config.dcm_convergence)

    def steady(self, dcm: Array | None) -> bool:
        """Whether the DCM is near enough to the reference for a foot to leave the ground."""
        config = self._config.capture
        if dcm is None or not config.enabled:
            return True
        error = dcm - self.pendulum.state.dcm
        return math.hypot(error[0], error[1]) < config.lift_off

    def advance(self, gait: Gait, dcm: Array | None, dt: float) -> tuple[FootPose, ...]:
        """One tick after the walker's.

        Args:
            gait: Walking parameters.
            dcm: Measured, in world, shape (2,) [m]; None before the first.
            dt: Tick [s].

        Returns:
            The coming footsteps.
        """
        config, walker, ik = self._config, self.walker, self.body.ik
        plan = walker.plan_ahead(gait)
        omega = natural_frequency(float(ik.com[2]))
        momentum = momentum_shift(ik.angular_momentum, self._mass)
        dcm_plan = planned_dcm(walker.zmp.position, plan.zmp, omega, config.walker.preview)
        if dcm is not None:
            self._catch(dcm, dcm_plan - omega * momentum, omega)
        reach = config.zmp_reach_double if walker.swinging is None else config.zmp_reach
        self.pendulum.advance(walker.zmp.position, dcm_plan, momentum, omega, reach, dt)
        self.body.advance(walker, plan, self.pendulum.state, omega, config.walker.preview, dt)
        return plan.footsteps

    def _catch(self, dcm: Array, dcm_plan: Array, omega: float) -> None:
        """A DCM that the ZMP cannot bring back moves the landing place, and the reference with it."""
        config, walker = self._config.capture, self.walker
        if not config.enabled or not walker.catching or walker.landing is None:
            return
        landing = walker.landing
        weight = footprint_weight(*walker.landing_times(), omega)
        present = shifted(landing, walker.shift).xy - landing.xy
        shift = landing_shift(dcm - (dcm_plan - weight * present), landing, weight, config)
        walker.catch(shift, config.hurry)
        if np.any(shift != 0.0):
            self.pendulum.take_over(dcm)


def _footstep(foot: FootPose, taken: bool, counted: bool) -> Footstep:
    return Footstep(foot.side, np.array([foot.x, foot.y, foot.z]), foot.yaw, taken, counted)
