"""The simulator as the graph sees it: world, robot and sensors behind control ticks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Inertial, Joints, Odometry, Wrench
from follower_humanoid.plant.board import Board, BoardConfig
from follower_humanoid.plant.drives import Drives, HoldConfig
from follower_humanoid.plant.falls import Fall, FallWatch
from follower_humanoid.plant.held_place import WORLD_NAMES, HeldPlace
from follower_humanoid.plant.motors import MotorConfig
from follower_humanoid.plant.physics_steps import physics_steps
from follower_humanoid.plant.plant_urdf import BodyErrorConfig
from follower_humanoid.plant.pull_limits import PullLimiter, PullLimits
from follower_humanoid.plant.robot_plant import RobotPlant
from follower_humanoid.plant.sensor_errors import SensorConfig
from follower_humanoid.plant.sensors import Sensors
from follower_humanoid.plant.soles import SoleConfig
from follower_humanoid.plant.standing import StandingConfig
from follower_humanoid.plant.stops import StopConfig
from follower_humanoid.plant.world import Ground, GroundConfig, World
from follower_humanoid.robot.model import RobotModel

# Where the wrenches of `leader_left`, `leader_right` and `push` act.
PULLED = ("l_gripper", "r_gripper", "base_link")


@dataclass(frozen=True)
class SimulatorConfig:
    """Everything that only the plant knows."""

    physics_step: float = parameter(0.001, "physics step; control ticks are whole multiples", "s", 1e-5, 0.01)
    fixed_trunk: bool = parameter(False, "fix all but the arms to the world: no ground, no falls")
    board: BoardConfig = field(default_factory=BoardConfig)
    ground: GroundConfig = field(default_factory=GroundConfig)
    soles: SoleConfig = field(default_factory=SoleConfig)
    motors: MotorConfig = field(default_factory=MotorConfig)
    stops: StopConfig = field(default_factory=StopConfig)
    standing: StandingConfig = field(default_factory=StandingConfig)
    body: BodyErrorConfig = field(default_factory=BodyErrorConfig)
    sensors: SensorConfig = field(default_factory=SensorConfig)
    hold: HoldConfig = field(default_factory=HoldConfig)
    pull: PullLimits = field(default_factory=PullLimits)


class SimulatorInputs(NamedTuple):
    """Commands of the current tick and wrenches that people apply; None: nothing came.

    Attributes:
        legs, arms: effort = motor voltages [V]; position, velocity = references the drives hold.
        leader_left, leader_right: At the gripper frame's origin.
        push: At the base_link origin. Axes of all three: `frame`, empty = world.
    """

    legs: Joints | None = None
    arms: Joints | None = None
    leader_left: Wrench | None = None
    leader_right: Wrench | None = None
    push: Wrench | None = None


class SimulatorOutputs(NamedTuple):
    """State of the current tick; wrenches are means over the tick that just ended.

    Attributes:
        joints: All 45; effort = torque of corrected eq. (13) [N·m].
        odometry, imu: At base_link.
        left_foot, right_foot: Ground on foot, at and in the sole frame.
        left_wrist, right_wrist: Hand on forearm, at and in the wrist frame.
        left_applied, right_applied, base_applied: What people applied, axes of world.
        left_contact, right_contact: Board on gripper, axes of world; None without a board.
    """

    joints: Joints
    odometry: Odometry
    imu: Inertial
    left_foot: Wrench
    right_foot: Wrench
    left_wrist: Wrench
    right_wrist: Wrench
    left_applied: Wrench
    right_applied: Wrench
    base_applied: Wrench
    left_contact: Wrench | None
    right_contact: Wrench | None


class Simulator:
    """One follower in its world, stepped by control ticks.

    Attributes:
        tick: Control tick of the current state.
        time: Its simulated time [s].
        fall: The first fall, None while there was none.
        plant: The robot's physics, for tests and for those who may know the truth.
    """

    Config = SimulatorConfig
    Inputs = SimulatorInputs
    Outputs = SimulatorOutputs

    def __init__(self, config: SimulatorConfig, robot: RobotModel, period: float) -> None:
        """The robot standing at time 0.

        Args:
            config: The plant's parameters.
            robot: The model that all nodes share.
            period: Control tick [s].

        Raises:
            ConfigurationError: The tick is no whole number of physics steps, or no posture exists.
        """
        self._steps = physics_steps(period, config.physics_step)
        self._robot, self._period = robot, period
        self.world = World(config.physics_step, Ground(config.ground))
        try:
            self.plant = RobotPlant(
                self.world, robot, config.motors, config.soles, config.stops, config.standing, config.body,
                config.fixed_trunk,
            )  # fmt: skip
        except Exception:
            self.world.close()  # a physics server does not end by itself
            raise
        self._board = Board(config.board, self.plant) if config.board.stiffness > 0.0 else None
        self._sensors = Sensors(config.sensors, self.plant)
        groups = (robot.groups.legs, robot.groups.arms)
        self._drives = [Drives(config.hold, config.motors, robot, group) for group in groups]
        # A fixed trunk is held whether or not its joints are driven.
        self._commanded = 1 if config.fixed_trunk else 0
        self._falls = FallWatch(float(self.plant.q[2]))
        self._voltage = np.zeros(len(robot.joint_names))
        self._limiter = PullLimiter(config.pull)
        self._places = [
            HeldPlace(place, robot.frame_id(frame), self._limiter, self.plant)
            for place, frame in zip(self._limiter.cut, PULLED, strict=True)
        ]
        self.tick = 0
        self.time = 0.0
        self.fall: Fall | None = None
        self._rest()

    def _rest(self) -> None:
        for drives in self._drives:
            drives.start(self.plant.joint_position, self.plant.motors.voltage)
        for place in self._places:
            place.let_go()
        if self._board is not None:
            self._board.clear()
        self._sensors.at_rest()
        self._outputs = self._read()

    def reset(self) -> None:
        """Takes the place of a control tick: at the next one the robot is back on its feet."""
        self.plant.stand()
        self.fall = None
        self._count_tick()
        self._rest()

    def knows_frame(self, name: str) -> bool:
        """True for a name that a wrench's `frame` may have."""
        return name in WORLD_NAMES or bool(self._robot.pin_model.existFrame(name))

    def observe(self) -> SimulatorOutputs:
        """The state of the current tick."""
        return self._outputs

    def advance(self, inputs: SimulatorInputs) -> None:
        """One control tick: voltages are held, wrenches act.

        Raises:
            UnknownNameError: A wrench names a frame that does not exist.
            PhysicsError: The state left the finite numbers.
        """
        plant, sensors = self.plant, self._sensors
        if self.fall is not None:
            for drives in self._drives:
                drives.slacken()
        for group, (drives, command) in enumerate(zip(self._drives, (inputs.legs, inputs.arms), strict=True)):
            if group >= self._commanded:
                drives.receive(command)
            drives.write(plant.joint_position, plant.joint_velocity, self._voltage)
        given = (inputs.leader_left, inputs.leader_right, inputs.push)
        # Turned into world once: what is noted as applied is then exactly what acts in every step.
        taken = [place.take(wrench) for place, wrench in zip(self._places, given, strict=True)]
        held = tuple(pull for pull in taken if pull is not None)
        sensors.clear()
        if self._board is not None:
            self._board.clear()
        for step in range(self._steps):
            for drives in self._drives:
                if step > 0 and drives.holding:
                    drives.write(plant.joint_position, plant.joint_velocity, self._voltage)
            pulls = held if self._board is None else (*held, *self._board.pulls())
            sensors.before_step()
            plant.step(self._voltage, pulls)
            sensors.after_step(pulls)
        self._count_tick()
        if self.fall is None:
            self.fall = self._falls.look(plant)
        self._outputs = self._read()

    def _count_tick(self) -> None:
        self.tick += 1
        self.time = self.tick * self._period
        self.plant.time = self.time

    def diagnostics(self) -> dict[str, float | int | str]:
        """Ticks without a usable command and with a limited one, and with more force than people have."""
        legs, arms = self._drives
        values: dict[str, float | int | str] = {
            "legs_held_ticks": legs.missed,
            "arms_held_ticks": arms.missed,
            "limited_references": legs.limited + arms.limited,
            **{f"limited_wrenches_{place}": count for place, count in self._limiter.cut.items()},
        }
        holding = [
            name for name, drives in (("legs", legs), ("arms", arms)) if drives.missed and drives.holding
        ]
        if holding:
            values["warning"] = f"no commands: the drives of {' and '.join(holding)} hold"
        return values

    def close(self) -> None:
        """Ends the physics server."""
        self.world.close()

    def _read(self) -> SimulatorOutputs:
        readings = self._sensors.read()
        left, right, base = self._places
        contacts: list[Wrench | None] = [None, None]
        if self._board is not None:
            contacts = [Wrench(force, np.zeros(3)) for force in self._board.mean_force()]
        return SimulatorOutputs(
            *readings, left.applied, right.applied, base.applied, contacts[0], contacts[1]
        )
