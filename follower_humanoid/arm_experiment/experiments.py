"""The experiments by name: nodes, parameters, programme, and how long they take."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from follower_humanoid.arm_experiment.tasks import BOARD, COMPLIANCE
from follower_humanoid.errors import UnknownNameError
from follower_humanoid.resources import share_path

_ALWAYS = ("simulator", "wrench_sensing", "arm_controller", "arm_task")


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    Attributes:
        name: What the user calls it.
        nodes: Which nodes run.
        programme: Force programme of the leader; empty: nobody pushes.
        duration: Simulated time by default [s].
    """

    name: str
    nodes: tuple[str, ...]
    programme: str
    duration: float

    @property
    def parameter_file(self) -> Path:
        """What is laid over `config/follower.yaml`."""
        return share_path(f"config/arm_experiments/{self.name}.yaml")

    @property
    def programme_file(self) -> Path | None:
        """The force programme's file."""
        return share_path(f"config/programmes/{self.programme}.yaml") if self.programme else None


EXPERIMENTS = {
    BOARD: Experiment(BOARD, _ALWAYS, "", 20.0),
    COMPLIANCE: Experiment(COMPLIANCE, ("leader", *_ALWAYS), "compliance", 12.0),
}


def experiment(name: str) -> Experiment:
    """An experiment by its name.

    Raises:
        UnknownNameError: There is none of that name.
    """
    if name not in EXPERIMENTS:
        raise UnknownNameError("arm experiment", name, EXPERIMENTS)
    return EXPERIMENTS[name]
