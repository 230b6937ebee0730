"""The leader of a force programme: publishes what it does to the hands, whatever the robot does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from follower_humanoid.core.config import parameter
from follower_humanoid.core.samples import Array, Wrench
from follower_humanoid.leader.programme import Forces, load_programme
from follower_humanoid.robot.model import RobotModel


@dataclass(frozen=True)
class LeaderConfig:
    """Parameters of the leader."""

    programme: str = parameter(
        "fig4", "force programme: fig4, fig5, or the path of a YAML file", path=True
    )


@dataclass(frozen=True)
class LeaderInputs:
    """A programme needs no measurement."""


class LeaderOutputs(NamedTuple):
    """Wrenches on the robot, axes of world; forces at `l_gripper`, `r_gripper`, `base_link`."""

    leader_left: Wrench
    leader_right: Wrench
    push: Wrench


class Leader:
    """Component: time in, wrenches on hands and base out.

    Attributes:
        duration: Length of the programme [s].
    """

    Config = LeaderConfig
    Inputs = LeaderInputs
    Outputs = LeaderOutputs

    def __init__(self, config: LeaderConfig, robot: RobotModel, period: float) -> None:
        """Loads the programme.

        Raises:
            ConfigurationError: The programme is unusable.
        """
        self._programme = load_programme(config.programme)
        self.duration = self._programme.duration
        self._forces: Forces | None = None
        self._outputs: LeaderOutputs

    def step(self, inputs: LeaderInputs, time: float) -> LeaderOutputs:
        """The wrenches at `time` [s]."""
        forces = self._programme.at(time)
        if forces is not self._forces:
            self._forces, self._outputs = forces, _outputs(forces)
        return self._outputs


def _outputs(forces: Forces) -> LeaderOutputs:
    return LeaderOutputs(
        leader_left=_pure_force(forces.left),
        leader_right=_pure_force(forces.right),
        push=_pure_force(forces.base),
    )


def _pure_force(force: Array) -> Wrench:
    return Wrench(force, np.zeros(3), frame="world")
