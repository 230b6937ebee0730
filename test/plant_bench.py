"""Help for the plant's tests: quick plants, driven by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

from follower_humanoid.core.config import build
from follower_humanoid.core.samples import Array, Joints, Wrench
from follower_humanoid.plant.simulator import Simulator, SimulatorConfig, SimulatorOutputs
from follower_humanoid.robot.model import GRAVITY, RobotModel

GRAVITY_VECTOR = np.array([0.0, 0.0, -GRAVITY])
HIGH_UP = 50.0

# Rotors so heavy that no joint moves: the robot is one rigid body on its soles.
RIGID = {"motors.rotor_inertia": 1000.0, "motors.gear": 1e3, "motors.toe_gear": 1e3, "motors.inductance": 0.0}
# Joints that nothing drives or brakes.
PASSIVE = {
    "motors.torque_constant": 1e-6, "motors.back_emf_constant": 0.0, "motors.viscous_loss": 0.0,
    "motors.rotor_inertia": 0.0, "motors.inductance": 0.0, "stops.stiffness": 0.0, "stops.damping": 0.0,
}  # fmt: skip


@cache
def robot() -> RobotModel:
    return RobotModel()


def plant(period: float = 0.002, **values: Any) -> Simulator:
    """A simulator; parameter names with two underscores for a dot."""
    return plant_from({name.replace("__", "."): value for name, value in values.items()}, period)


def plant_from(values: dict[str, Any], period: float = 0.002) -> Simulator:
    config: SimulatorConfig = build(SimulatorConfig, values, "simulator")
    return Simulator(config, robot(), period)


class Holding:
    """Voltages that hold the posture of time 0: what stands in for controllers in these tests."""

    def __init__(self, simulator: Simulator, stiffness: float = 1000.0, damping: float = 10.0) -> None:
        self._position = simulator.observe().joints.position
        self._voltage = simulator.plant.motors.voltage.copy()
        self._stiffness, self._damping = stiffness, damping

    def voltage(self, state: SimulatorOutputs) -> Array:
        error = self._position - state.joints.position
        return np.asarray(self._voltage + self._stiffness * error - self._damping * state.joints.velocity)

    def inputs(self, state: SimulatorOutputs, **wrenches: Wrench) -> Simulator.Inputs:
        return commands(self.voltage(state), self._position, **wrenches)


def commands(
    voltage: Array, position: Array | None = None, velocity: Array | None = None, **wrenches: Wrench
) -> Simulator.Inputs:
    """Inputs from 45 voltages."""
    position = np.zeros(45) if position is None else position
    velocity = np.zeros(45) if velocity is None else velocity
    groups = robot().groups
    legs, arms = (
        Joints(position[group], velocity[group], voltage[group]) for group in (groups.legs, groups.arms)
    )
    return Simulator.Inputs(legs=legs, arms=arms, **wrenches)


def lift(simulator: Simulator, velocity: Array | None = None, height: float = HIGH_UP) -> None:
    """Puts the robot, as it is, far above the ground, without motor currents."""
    q = simulator.plant.q.copy()
    q[2] = height
    simulator.plant.bullet.place(q, np.zeros(51) if velocity is None else velocity)
    simulator.plant.motors.hold(np.zeros(45))


def center_of_mass(simulator: Simulator) -> tuple[Array, Array]:
    """Position and velocity in world, by Pinocchio."""
    data = simulator.plant.model.createData()
    pin.centerOfMass(simulator.plant.model, data, simulator.plant.q, simulator.plant.v)
    return data.com[0].copy(), data.vcom[0].copy()


def plant_mass(simulator: Simulator) -> float:
    return float(sum(inertia.mass for inertia in simulator.plant.model.inertias))


def in_world(simulator: Simulator, frame: str, vector: Array) -> Array:
    """A vector in the axes of a frame, turned into world."""
    return np.asarray(simulator.plant.frame_rotation(robot().frame_id(frame)) @ vector)


def without(values: dict[str, Any], **changes: Any) -> dict[str, Any]:
    return {**values, **{name.replace("__", "."): value for name, value in changes.items()}}


def scaled(wrench: Wrench, factor: float) -> Wrench:
    return replace(wrench, force=factor * wrench.force, torque=factor * wrench.torque)
