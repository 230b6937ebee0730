"""From channels, pendulum and plan to the reference configuration of the whole body."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import SIDES, Array, Joints, Odometry, Side
from follower_humanoid.gait.differential_ik import BodyTask, DifferentialIk, FootTask, IkConfig
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.pelvis_height import PelvisConfig, PelvisHeight, Reach
from follower_humanoid.gait.pendulum import PendulumState
from follower_humanoid.gait.preview import com_after
from follower_humanoid.gait.walk_plan import Plan
from follower_humanoid.gait.walker import Walker
from follower_humanoid.robot.model import BASE_DOF, RobotModel


@dataclass(frozen=True)
class BodyConfig:
    """Parameters of the reference body."""

    toe_gain: float = parameter(20.0, "position feedback of the toe reference", "1/s", 0, 100)
    ik: IkConfig = field(default_factory=IkConfig)
    pelvis: PelvisConfig = field(default_factory=PelvisConfig)


class ReferenceBody:
    """The body as it should move: feet on their channels, CoM on the pendulum, pelvis upright.

    Attributes:
        ik: Holds reference configuration and velocity.
        toes: Reference angle of either toe joint [rad].
    """

    def __init__(self, config: BodyConfig, robot: RobotModel, q: Array) -> None:
        """Starts at rest in the configuration q, shape (52,)."""
        model = robot.pin_model
        self._config = config
        self._toe_joints = {side: robot.joint_index(f"{side.prefix}_toe_pitch") for side in SIDES}
        hip_offset = float(model.jointPlacements[model.getJointId("l_hip_yaw")].translation[1])
        self._hip_offsets = {side: side.sign * hip_offset for side in SIDES}
        self._ankle_height = -float(model.frames[robot.frame_id("l_sole")].placement.translation[2])
        self._hips = dict.fromkeys(SIDES, (0.0, 0.0))
        self._given = np.zeros(len(robot.joint_names))  # of the joints outside the IK only the toes move
        self._no_effort = np.zeros(len(robot.joint_names))
        self._pelvis = PelvisHeight(config.pelvis, float(q[2]))
        self.ik = DifferentialIk(robot, config.ik, q)
        self.toes = self._toe_angles()

    def samples(self) -> tuple[Joints, Odometry]:
        """Joints and base of the reference."""
        q, v = self.ik.q, self.ik.v
        # The IK makes new arrays at every tick: their parts may be given away.
        return Joints(q[7:], v[6:], self._no_effort), Odometry(q[:3], q[3:7], v[:3], v[3:6])

    def advance(
        self, walker: Walker, plan: Plan, pendulum: PendulumState, omega: float, horizon: float, dt: float
    ) -> None:
        """One tick of pelvis height and differential IK.

        Args:
            walker: Feet and channels.
            plan: What is to come.
            pendulum: Reference CoM.
            omega: Natural frequency [1/s].
            horizon: Of the preview [s].
            dt: Tick [s].
        """
        reaches = self._reaches(walker, plan, pendulum, omega, horizon)
        self._pelvis.advance(self._pelvis.admissible(reaches), dt)
        body = BodyTask(
            com=pendulum.com, com_velocity=pendulum.com_velocity,
            pelvis_height=self._pelvis.height, pelvis_height_velocity=self._pelvis.velocity,
            pelvis_rotation=_about_z(walker.heading()), pelvis_angular_velocity=_yaw_rate(walker),
        )  # fmt: skip
        for side, angle in self.toes.items():
            goal, speed = _toe(walker, side)
            self._given[self._toe_joints[side]] = speed + self._config.toe_gain * (goal - angle)
        self.ik.advance({side: _foot_task(walker, side) for side in SIDES}, body, self._given, dt)
        self.toes = self._toe_angles()

    def _toe_angles(self) -> dict[Side, float]:
        return {side: self.ik.q.item(BASE_DOF + 1 + joint) for side, joint in self._toe_joints.items()}

    def _reaches(
        self, walker: Walker, plan: Plan, pendulum: PendulumState, omega: float, horizon: float
    ) -> list[Reach]:
        """How far the legs must reach: now, at the next touchdown, at the next lift-off."""

        def shift_after(pieces: int) -> Array:
            ahead, later = plan.zmp[:pieces], plan.zmp[pieces:]
            com = com_after(walker.zmp.position, pendulum.com, pendulum.dcm, ahead, later, omega, horizon)
            return com - pendulum.com

        self._locate_hips()
        reaches = []
        for side, sole in self.ik.soles.items():
            x, y, z = sole[3].tolist()
            reaches.append(self._reach(x, y, z, side))
        if plan.footsteps:
            shift, landing = shift_after(plan.landing), plan.footsteps[0]
            reaches.append(self._planned_reach(landing, shift))
            reaches.append(self._planned_reach(walker.feet[landing.side.other], shift))
        if plan.lifting is not None:
            reaches.append(self._planned_reach(plan.lifting, shift_after(plan.lift_off)))
        return reaches

    def _planned_reach(self, foot: FootPose, shift: Array) -> Reach:
        """The reach to a foot that will land or lift off, with something to spare."""
        x, y = shift.tolist()
        return self._reach(foot.x - x, foot.y - y, foot.z, foot.side, self._config.pelvis.spare)

    def _reach(self, x: float, y: float, z: float, side: Side, spare: float = 0.0) -> Reach:
        """From the hip of the reference to the ankle above a sole at x, y, z in world [m]."""
        hip_x, hip_y = self._hips[side]
        return Reach(z + self._ankle_height, math.hypot(x - hip_x, y - hip_y) + spare)

    def _locate_hips(self) -> None:
        """Where the hips of the reference are over the ground [m]."""
        _, left, _, (x, y, _) = self.ik.base.tolist()
        for side, aside in self._hip_offsets.items():
            self._hips[side] = (x + aside * left[0], y + aside * left[1])


_NO_RATE = np.zeros(3)


def _about_z(yaw: float) -> Array:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array((c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)).reshape(3, 3)


@lru_cache(maxsize=4)
def _standing(foot: FootPose) -> FootTask:
    """A foot that stays where it is."""
    return FootTask(np.array([foot.x, foot.y, foot.z]), _about_z(foot.yaw), np.zeros(3), np.zeros(3))


def _foot_task(walker: Walker, side: Side) -> FootTask:
    """Sole motion: still on the ground, or as the channels of the swing foot say."""
    if walker.swinging is not side or walker.half_step is None:
        return _standing(walker.feet[side])
    swing = walker.half_step.swing
    yaw, pitch = swing.attitude.position.tolist()
    yaw_rate, pitch_rate = swing.attitude.velocity.tolist()
    c, s = math.cos(yaw), math.sin(yaw)
    level, down = math.cos(pitch), math.sin(pitch)
    task = np.array((
        *swing.place.position.tolist(), *swing.height.position.tolist(),
        # About z by the yaw, then about the foot's own y by the pitch.
        c * level, -s, c * down, s * level, c, s * down, -down, 0.0, level,
        *swing.place.velocity.tolist(), *swing.height.velocity.tolist(),
        -s * pitch_rate, c * pitch_rate, yaw_rate,
    ))  # fmt: skip
    return FootTask(task[:3], task[3:12].reshape(3, 3), task[12:15], task[15:])


def _yaw_rate(walker: Walker) -> Array:
    """The pelvis turns with the mean of the feet: half the swing foot's rate."""
    if walker.swinging is None or walker.half_step is None:
        return _NO_RATE
    return np.array((0.0, 0.0, 0.5 * walker.half_step.swing.attitude.velocity.item(0)))


def _toe(walker: Walker, side: Side) -> tuple[float, float]:
    """Toe joint angle and speed of a foot: flat on the ground, or as the swing foot's channel says."""
    if walker.swinging is not side or walker.half_step is None:
        return 0.0, 0.0
    toe = walker.half_step.swing.toe
    return toe.position.item(), toe.velocity.item()
