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
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig
from follower_humanoid.gait.feet import FootPose, FootstepConfig, half_step_length
from follower_humanoid.gait.pelvis_height import PelvisConfig, PelvisHeight, Reach
from follower_humanoid.gait.pendulum import ReferencePendulum, momentum_shift, natural_frequency
from follower_humanoid.gait.preview import com_after, planned_dcm
from follower_humanoid.gait.sequence import load_sequence
from follower_humanoid.gait.walker import Plan, Walker, WalkerConfig
from follower_humanoid.robot.model import BASE_DOF, RobotModel

STANDING = Gait(walk_speed=0.0, walk_dir=0.0, step_length=1.0, step_height=1.0, heading=0.0)


@dataclass(frozen=True)
class CompositionConfig:
    """Parameters of motion composition."""

    sequence: str = parameter("", "file with the sequence of primitives; empty: the package's half-step")
    dcm_convergence: float = parameter(4.0, "rate at which the reference DCM joins a changed plan", "1/s", 0.5, 20)
    zmp_reach: float = parameter(0.03, "largest ZMP shift to join a changed plan, one foot carrying", "m", 0, 0.1)
    zmp_reach_double: float = parameter(0.09, "the same, both feet carrying", "m", 0, 0.2)
    toe_gain: float = parameter(20.0, "position feedback of the toe reference", "1/s", 0, 100)
    walker: WalkerConfig = field(default_factory=WalkerConfig)
    footsteps: FootstepConfig = field(default_factory=FootstepConfig)
    ik: IkConfig = field(default_factory=IkConfig)
    pelvis: PelvisConfig = field(default_factory=PelvisConfig)
    capture: CaptureConfig = field(default_factory=CaptureConfig)


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
        self._toes = {side: robot.joint_index(f"{side.prefix}_toe_pitch") for side in SIDES}
        model = robot.pin_model
        self._hip_offset = float(model.jointPlacements[model.getJointId("l_hip_yaw")].translation[1])
        self._ankle_height = -float(model.frames[robot.frame_id("l_sole")].placement.translation[2])
        self._walker: Walker | None = None
        self._footsteps_sent: tuple[int, bool] | None = None
        self._lengths: list[float] = []

    def step(self, inputs: CompositionInputs, time: float) -> CompositionOutputs:
        """One tick: walking parameters in, joint reference out."""
        del time
        if self._walker is None:
            self._start(inputs)
        walker, ik, dt = self._walker, self._ik, self._period
        if walker is None:
            raise RuntimeError("motion composition has not started")
        gait = inputs.gait if inputs.gait is not None else STANDING
        loads = {Side.LEFT: float(inputs.left_foot.force[2]), Side.RIGHT: float(inputs.right_foot.force[2])}
        toes = {side: float(ik.q[7 + index]) for side, index in self._toes.items()}
        landed = walker.step(gait, loads, toes, dt)
        if landed is not None:
            self._anchor(walker, landed, inputs)
        plan = walker.plan_ahead(gait)
        omega = natural_frequency(float(ik.com[2]))
        dcm_plan = planned_dcm(walker.zmp.position, plan.zmp, omega, self._config.walker.preview)
        self._momentum = momentum_shift(ik.angular_momentum, self._robot.mass)
        self._catch(walker, dcm_plan, omega, inputs.dcm)
        reach = self._config.zmp_reach_double if walker.swinging is None else self._config.zmp_reach
        pendulum = self._pendulum.advance(walker.zmp.position, dcm_plan, self._momentum, omega, reach, dt)
        self._advance_pelvis(walker, plan, omega)
        self._advance_body(walker, pendulum.com, pendulum.com_velocity)
        names, completion = walker.half_step.active() if walker.half_step is not None else ((), ())
        return CompositionOutputs(
            reference=Joints(ik.q[7:].copy(), ik.v[6:].copy(), np.zeros(len(self._robot.joint_names))),
            base=Odometry(ik.q[:3].copy(), ik.q[3:7].copy(), ik.v[:3].copy(), ik.v[3:6].copy()),
            zmp_reference=Point(np.array([pendulum.zmp[0], pendulum.zmp[1], 0.0])),
            dcm_reference=Point(np.array([pendulum.dcm[0], pendulum.dcm[1], 0.0])),
            contacts=walker.contacts(),
            primitives=PrimitiveStates(names, completion),
            footsteps=self._changed_footsteps(walker, plan.footsteps),
        )

    def diagnostics(self) -> dict[str, float | str]:
        """Counted half-steps and their measured lengths."""
        lengths = ", ".join(f"{length:.3f}" for length in self._lengths)
        heading = self._walker.heading() if self._walker is not None else 0.0
        return {"half_steps": len(self._lengths), "lengths [m]": lengths, "heading [rad]": heading}

    def _start(self, inputs: CompositionInputs) -> None:
        """The reference begins at the measured state, at rest."""
        config, robot = self._config, self._robot
        q = robot.configuration(inputs.odometry, inputs.joints.position)
        feet = {side: self._measured_foot(side, q) for side in SIDES}
        self._ik = DifferentialIk(robot, config.ik, q)
        com = self._ik.com[:2]
        self._walker = Walker(config.walker, config.footsteps, self._sequence, feet, com)
        self._pendulum = ReferencePendulum(com, config.dcm_convergence)
        self._momentum: Array = np.zeros(2)
        self._pelvis = PelvisHeight(config.pelvis, float(q[2]))

    def _catch(self, walker: Walker, dcm_plan: Array, omega: float, measured: Point | None) -> None:
        """A DCM that the ZMP cannot bring back moves the landing place, and the reference with it."""
        config = self._config.capture
        if not config.enabled or measured is None or not walker.catching or walker.landing is None:
            return
        landing = walker.landing
        weight = footprint_weight(*walker.landing_times(), omega)
        present = shifted(landing, walker.shift).xy - landing.xy
        error = measured.xyz[:2] - (dcm_plan - weight * present) + omega * self._momentum
        shift = landing_shift(error, landing, weight, config)
        walker.catch(shift, config.hurry)
        if np.any(shift != 0.0):
            self._pendulum.take_over(measured.xyz[:2])

    def _measured_foot(self, side: Side, q: Array) -> FootPose:
        pin.forwardKinematics(self._robot.pin_model, self._data, q)
        frame = self._robot.frame_id(f"{side.prefix}_sole")
        sole = pin.updateFramePlacement(self._robot.pin_model, self._data, frame)
        yaw = math.atan2(sole.rotation[1, 0], sole.rotation[0, 0])
        return FootPose(side, float(sole.translation[0]), float(sole.translation[1]), yaw)

    def _anchor(self, walker: Walker, landed: Side, inputs: CompositionInputs) -> None:
        q = self._robot.configuration(inputs.odometry, inputs.joints.position)
        foot = self._measured_foot(landed, q)
        walker.anchor(landed, foot)
        if walker.taken[-1][1]:
            self._lengths.append(half_step_length(foot, walker.feet[landed.other]))

    def _advance_body(self, walker: Walker, com: Array, com_velocity: Array) -> None:
        """Differential IK from the channels to the joints."""
        ik, dt, config = self._ik, self._period, self._config
        tasks = {side: _foot_task(walker, side) for side in SIDES}
        body = BodyTask(
            com=com, com_velocity=com_velocity,
            pelvis_height=self._pelvis.height, pelvis_height_velocity=self._pelvis.velocity,
            pelvis_rotation=_about_z(walker.heading()), pelvis_angular_velocity=_yaw_rate(walker),
        )  # fmt: skip
        given = np.zeros(len(self._robot.joint_names))
        for side, index in self._toes.items():
            goal, speed = _toe(walker, side)
            given[index] = speed + config.toe_gain * (goal - ik.q[BASE_DOF + 1 + index])
        ik.advance(tasks, body, given, dt)

    def _advance_pelvis(self, walker: Walker, plan: Plan, omega: float) -> None:
        """The pelvis goes in good time to where both legs reach the ground: now, at touchdown, at lift-off."""
        state = self._pendulum.state

        def shift_after(pieces: int) -> Array:
            com = com_after(
                walker.zmp.position, state.com, state.dcm, plan.zmp[:pieces], plan.zmp[pieces:], omega,
                self._config.walker.preview,
            )  # fmt: skip
            return com - state.com

        reaches = [self._reach(self._ik.sole(side).translation, side, np.zeros(2)) for side in SIDES]
        if plan.footsteps:
            shift, landing = shift_after(plan.landing), plan.footsteps[0]
            for foot in (landing, walker.feet[landing.side.other]):
                reaches.append(self._planned_reach(foot, shift))
        if plan.lifting is not None:
            reaches.append(self._planned_reach(plan.lifting, shift_after(plan.lift_off)))
        self._pelvis.advance(self._pelvis.admissible(reaches), self._period)

    def _planned_reach(self, foot: FootPose, shift: Array) -> Reach:
        """The reach to a foot that will land or lift off, with something to spare."""
        reach = self._reach(np.array([foot.x, foot.y, foot.z]), foot.side, shift)
        return Reach(reach.ankle_height, reach.horizontal + self._config.pelvis.spare)

    def _reach(self, sole: Array, side: Side, shift: Array) -> Reach:
        """From the hip of the reference, moved over the ground by `shift`, to the ankle above a sole."""
        q = self._ik.q
        rotation = pin.Quaternion(q[3:7]).toRotationMatrix()
        hip = q[:2] + rotation[:2, 1] * side.sign * self._hip_offset + shift
        return Reach(float(sole[2]) + self._ankle_height, math.hypot(sole[0] - hip[0], sole[1] - hip[1]))

    def _changed_footsteps(self, walker: Walker, coming: tuple[FootPose, ...]) -> Footsteps | None:
        """The steps when one was taken or planned anew, at most ten a second while targets move."""
        state = (len(walker.taken), round(coming[0].x + coming[0].y + coming[0].yaw, 3) if coming else None)
        if state == self._footsteps_sent:
            return None
        self._footsteps_sent = state
        taken = [_footstep(foot, True, counted) for foot, counted in walker.taken[-8:]]
        return Footsteps((*taken, *(_footstep(foot, False, True) for foot in coming)))


def _footstep(foot: FootPose, taken: bool, counted: bool) -> Footstep:
    return Footstep(foot.side, np.array([foot.x, foot.y, foot.z]), foot.yaw, taken, counted)


def _about_z(yaw: float) -> Array:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _foot_task(walker: Walker, side: Side) -> FootTask:
    """Sole motion: still on the ground, or as the channels of the swing foot say."""
    if walker.swinging is not side or walker.half_step is None:
        foot = walker.feet[side]
        return FootTask(np.array([foot.x, foot.y, foot.z]), _about_z(foot.yaw), np.zeros(3), np.zeros(3))
    swing = walker.half_step.swing
    yaw, pitch = swing.attitude.position
    yaw_rate, pitch_rate = swing.attitude.velocity
    c, s = math.cos(pitch), math.sin(pitch)
    tilt = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    heading = _about_z(float(yaw))
    return FootTask(
        position=np.concatenate((swing.place.position, swing.height.position)),
        rotation=heading @ tilt,
        linear_velocity=np.concatenate((swing.place.velocity, swing.height.velocity)),
        angular_velocity=np.array([0.0, 0.0, yaw_rate]) + pitch_rate * heading[:, 1],
    )


def _yaw_rate(walker: Walker) -> Array:
    """The pelvis turns with the mean of the feet: half the swing foot's rate."""
    if walker.swinging is None or walker.half_step is None:
        return np.zeros(3)
    return np.array([0.0, 0.0, 0.5 * float(walker.half_step.swing.attitude.velocity[0])])


def _toe(walker: Walker, side: Side) -> tuple[float, float]:
    """Toe joint angle and speed of a foot: flat on the ground, or as the swing foot's channel says."""
    if walker.swinging is not side or walker.half_step is None:
        return 0.0, 0.0
    toe = walker.half_step.swing.toe
    return float(toe.position[0]), float(toe.velocity[0])
