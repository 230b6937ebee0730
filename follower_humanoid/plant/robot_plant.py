"""One robot in the world: PyBullet's body, driven by the implicit step of motors, soles and stops.

Per physics step h, with M, n at the current state and A, D of the motors:

    (M + A + hD + Σ Jᵀ c J) q̈ = τ_u − n − D q̇ + τ_ext + Σ Jᵀ f

gives the accelerations that the contact forces and motor torques of this very step must fit.
PyBullet then gets the contact forces at their points and the torques τ_u − A q̈ − D (q̇ + h q̈).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from follower_humanoid.core.samples import Array
from follower_humanoid.errors import PhysicsError
from follower_humanoid.plant.bullet_robot import BulletRobot
from follower_humanoid.plant.motors import MotorConfig, Motors
from follower_humanoid.plant.plant_urdf import BodyErrorConfig, bullet_body, plant_body
from follower_humanoid.plant.pulls import HeldPoint, Pull, add_pull, held_point
from follower_humanoid.plant.soles import SoleConfig, Soles
from follower_humanoid.plant.standing import StandingConfig, standing
from follower_humanoid.plant.stops import StopConfig, Stops
from follower_humanoid.plant.world import World
from follower_humanoid.robot.model import BASE_DOF, GRAVITY, Indices, RobotModel
from follower_humanoid.robot.pose_table import pose_table

# Solving again when points change between sticking, slipping and lifting; then forces are clipped.
MAX_PASSES = 4


# Inertia of what a fixed trunk holds: arms move it by nothing that a double could show.
_IMMOVABLE = 1e12


def _held_rows(robot: RobotModel) -> Indices:
    """Rows of v that a fixed trunk holds: the base and every joint but the arms'."""
    moving = BASE_DOF + robot.groups.arms
    return np.setdiff1d(np.arange(BASE_DOF + len(robot.joint_names)), moving)


class RobotPlant:
    """State and forces of one robot.

    Attributes:
        model: Pinocchio model of the plant's own body (its masses, not the controllers').
        data: Dynamics of the state at which `renew_dynamics` was called last: at the latest where the last
            step began.
        joint_poses, world_jacobian: Views of them: a `pose_table`, shape (n, 4, 3), and shape (6, 51).
        bullet: The body in PyBullet; its `q` (52,) and `v` (51,) are the state, as in `RobotModel`.
        joint_position, joint_velocity: Views of the state, shape (45,) [rad, rad/s].
        soles, motors, stops: What acts between robot and world, and in its joints.
        acceleration: Solution of the last step, shape (51,).
        effort: Eq. (13)'s torque of the last step, shape (45,) [N·m]; a new array in every step.
        time: Simulated time [s].
        passes: Solutions that the last step needed.
        settled: False if contact states still changed after the last of them.
    """

    def __init__(
        self, world: World, robot: RobotModel, motors: MotorConfig, soles: SoleConfig, stops: StopConfig,
        posture: StandingConfig, errors: BodyErrorConfig, fixed_trunk: bool = False,
    ) -> None:  # fmt: skip
        """Puts the robot into the world, standing; with a fixed trunk only its arms move."""
        self.world, self.robot = world, robot
        self._step = world.step_length
        urdf = plant_body(robot.urdf, errors)
        self.model: pin.Model = pin.buildModelFromXML(urdf, pin.JointModelFreeFlyer())
        self.motors = Motors(motors, robot, self._step)
        armature = np.concatenate(
            (np.zeros(BASE_DOF), self.motors.inertia + self._step * self.motors.damping)
        )
        self._held = _held_rows(robot) if fixed_trunk else np.zeros(0, dtype=np.intp)
        armature[self._held] = _IMMOVABLE
        self.model.armature = armature
        self.data = self.model.createData()
        # Views of Pinocchio's memory: they follow its algorithms.
        self._mass_matrix: Array = self.data.M
        self.world_jacobian: Array = self.data.J
        self.joint_poses = pose_table(self.data.oMi)
        self._forces_at_rest: Array = self.data.nle
        self._renewed_at = -1
        self._held_points: dict[int, HeldPoint] = {}
        self._posture, self._stiffness = posture, soles.stiffness
        self.soles = Soles(soles, robot, self.joint_poses, world.ground, self._step)
        self.stops = Stops(stops, robot.lower, robot.upper, self._step)
        self.bullet = self._body(urdf, fixed_trunk)
        self._sole_links = np.array([self.bullet.link(joint) for joint in self.soles.joints], dtype=np.int32)
        self.q, self.v = self.bullet.q, self.bullet.v
        self.joint_position, self.joint_velocity = self.q[7:], self.v[BASE_DOF:]
        self.acceleration = np.zeros(self.model.nv)
        self.effort = np.zeros(len(robot.joint_names))
        self.time = 0.0
        self.passes, self.settled = 0, True
        self.stand()

    @property
    def rotation(self) -> Array:
        """Base to world, shape (3, 3)."""
        return self.bullet.rotation

    def _body(self, urdf: str, fixed_trunk: bool) -> BulletRobot:
        names = self.robot.joint_names
        if not fixed_trunk:
            return BulletRobot(self.world, bullet_body(urdf), names)
        state = standing(self.robot, self.model, self._posture, self._stiffness)
        held = {names[n]: float(state.configuration[7 + n]) for n in self._held[BASE_DOF:] - BASE_DOF}
        return BulletRobot(self.world, bullet_body(urdf, held), names, self.robot.groups.arms)

    def stand(self) -> None:
        """Puts the robot into static equilibrium at the world's origin; a slope pulls from then on."""
        self.model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
        state = standing(self.robot, self.model, self._posture, self._stiffness)
        self.model.gravity.linear = self.world.ground.gravity
        self.bullet.place(state.configuration, np.zeros(self.model.nv))
        self.renew_dynamics()
        if not self._held.size:  # a fixed trunk needs no ground
            self.soles.settle(state.point_forces)
        self.motors.hold(state.torque)
        self.effort = state.torque.copy()
        self.acceleration = np.zeros(self.model.nv)

    def renew_dynamics(self) -> None:
        """Joint poses, world Jacobian, mass matrix, n and the f that it is made of: of the state of now."""
        if self._renewed_at == self.bullet.reads:
            return
        # In world axes, so that it leaves the Jacobian behind too. The armature is rotor inertia and
        # implicit damping.
        pin.crba(self.model, self.data, self.q, pin.Convention.WORLD)
        pin.nonLinearEffects(self.model, self.data, self.q, self.v)
        self._renewed_at = self.bullet.reads

    def frame_rotation(self, frame: int) -> Array:
        """Rotation from a Pinocchio frame to world at the current state, shape (3, 3)."""
        self.renew_dynamics()
        info = self.model.frames[frame]
        rotation: Array = self.data.oMi[info.parentJoint].rotation @ info.placement.rotation
        return rotation

    def step(self, voltage: Array, pulls: tuple[Pull, ...] = ()) -> None:
        """One physics step.

        Args:
            voltage: Of the motors, shape (45,) [V].
            pulls: What people do to the robot during the step.

        Raises:
            PhysicsError: The state left the finite numbers.
        """
        model, data, q, rate = self.model, self.data, self.q, self.joint_velocity
        self.renew_dynamics()
        free = -self._forces_at_rest
        self.motors.begin(voltage, rate, free[BASE_DOF:])
        places = [self._add_pull(pull, free) for pull in pulls]
        on_ground = not self._held.size and self.soles.begin(self.world_jacobian, self.v)
        on_stop = self.stops.begin(self.joint_position, rate)
        for passes in range(1, MAX_PASSES + 1):
            if passes > 1:  # the contact of the pass before is in the mass matrix
                pin.crba(model, data, q, pin.Convention.WORLD)
            right_side = free.copy()
            if on_ground:
                self.soles.add_to(self._mass_matrix, right_side)
            if on_stop:
                self.stops.add_to(self._mass_matrix, right_side)
            # Contact adds only entries between a link and its ancestors: the tree's sparsity stays.
            pin.cholesky.decompose(model, data)
            qdd: Array = pin.cholesky.solve(model, data, right_side)
            settled = not on_ground or self.soles.finish(qdd)
            if on_stop:
                settled = self.stops.finish(qdd[BASE_DOF:]) and settled
            self.passes = passes
            if settled:
                break
        self.settled = settled
        if self._held.size:
            qdd[self._held] = 0.0
        self.effort = self.motors.finish(qdd[BASE_DOF:], rate)
        self.acceleration = qdd
        if on_ground:
            self.soles.commit(settled)
        self._apply(pulls, places)
        self.world.step()
        self.time += self._step
        self.bullet.read()
        if not self.bullet.finite:
            self._complain(free)

    def held_point(self, frame: int) -> HeldPoint:
        """What the model says about a frame; looked up once."""
        if frame not in self._held_points:
            self._held_points[frame] = held_point(self.model, frame)
        return self._held_points[frame]

    def _add_pull(self, pull: Pull, forces: Array) -> Array:
        """Adds a wrench to the generalised forces, shape (51,); returns where it acts in world."""
        point, place = self.held_point(pull.frame), np.empty(3)
        add_pull(
            self.joint_poses[point.joint], point.offset, pull.force, pull.torque, self.world_jacobian,
            point.columns, place, forces,
        )  # fmt: skip
        return place

    def _apply(self, pulls: tuple[Pull, ...], places: list[Array]) -> None:
        torque = self.effort + self.stops.torque if self.stops.active else self.effort
        self.bullet.drive(torque)
        if self.soles.touching:
            self.bullet.support(self._sole_links, self.soles.force, self.soles.points)
        for pull, place in zip(pulls, places, strict=True):
            link = self.bullet.link(self.held_point(pull.frame).joint)
            self.bullet.pull(link, pull.force, pull.torque, place)

    def _complain(self, forces: Array) -> None:
        # What comes out of a step has reached every joint: what went into it tells where it began.
        origin = self.v if np.isfinite(forces).all() else forces
        names = [f"base_link {axis}" for axis in ("x", "y", "z", "roll", "pitch", "yaw")]
        names += self.robot.joint_names
        bad = [name for name, rate in zip(names, origin, strict=True) if not np.isfinite(rate)]
        raise PhysicsError(
            f"physics left the finite numbers at {self.time:.3f} s, first in: {', '.join(bad[:5])}"
        )
