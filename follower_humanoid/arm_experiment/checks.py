"""What is checked of an experiment's parameters before anything starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from follower_humanoid.arm_experiment.tasks import BOARD, ArmTaskConfig
from follower_humanoid.arm_experiment.workspace import Reach, check_reach
from follower_humanoid.control.arm_config import ArmControllerConfig
from follower_humanoid.core.config import build, parameters_of
from follower_humanoid.core.samples import Array
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.plant.simulator import SimulatorConfig
from follower_humanoid.plant.standing import standing
from follower_humanoid.robot.model import RobotModel


def check_experiment(parameters: Mapping[str, Mapping[str, Any]], urdf: str = "") -> None:
    """Refuses what cannot be done.

    Args:
        parameters: Node → dotted name → value; may hold what the nodes share as well.
        urdf: Robot description; empty: the package's own.

    Raises:
        ConfigurationError: A stiffness is not positive, the target or a part of the square is out of reach,
            or the board is not there or not where the task looks for it.
    """
    build(ArmControllerConfig, _own(ArmControllerConfig, parameters, "arm_controller"), "arm_controller")
    plant = build(SimulatorConfig, _own(SimulatorConfig, parameters, "simulator"), "simulator")
    task = build(ArmTaskConfig, _own(ArmTaskConfig, parameters, "arm_task"), "arm_task")
    if not plant.fixed_trunk:
        raise ConfigurationError("simulator: fixed_trunk = false: an arm experiment needs true")
    if task.task == BOARD and plant.board.stiffness <= 0.0:
        raise ConfigurationError(
            f"simulator: board.stiffness = {plant.board.stiffness} N/m: there is no board to write on; "
            "valid: above 0 N/m"
        )
    if task.task == BOARD and abs(task.board.distance - plant.board.distance) > task.board.standoff:
        raise ConfigurationError(
            f"arm_task: board.distance = {task.board.distance} m: valid: within board.standoff = "
            f"{task.board.standoff} m of the simulator's board.distance = {plant.board.distance} m"
        )
    robot = RobotModel(urdf)
    first = _first_posture(robot, plant)
    points = task.points(Reach(robot, first).place())
    names = ["target"]
    if task.task == BOARD:
        corners = [f"corner {n} of the square" for n in (1, 2, 3, 4, 1)]
        names = ["approach to the square", *corners, "approach to the square", "first place"]
    check_reach(robot, first, points, names)


def _own(config: type, parameters: Mapping[str, Mapping[str, Any]], node: str) -> dict[str, Any]:
    known = {info.name for info in parameters_of(config)}
    return {name: value for name, value in parameters.get(node, {}).items() if name in known}


def _first_posture(robot: RobotModel, plant: SimulatorConfig) -> Array:
    state = standing(robot, robot.pin_model, plant.standing, plant.soles.stiffness)
    return np.array(state.configuration[7:])
