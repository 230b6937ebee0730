"""Files that nodes read when they are configured, looked at before anything is started."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.ros.quiet import quiet_stderr

_EITHER_SIDE = (
    "wrist", "gripper", "ankle", "sole", "toe", *(f"contact_{number}" for number in range(1, 7)),
)  # fmt: skip
FRAMES = ("base_link", "torso", "gaze", *(f"{side}_{name}" for side in "lr" for name in _EITHER_SIDE))
"""Frames that the robot description must have."""


def check_files(parameters: Mapping[str, Mapping[str, Any]]) -> None:
    """Robot description and sequence of primitives.

    Raises:
        ConfigurationError: A file cannot be used.
    """
    for path in sorted({values["urdf"] for values in parameters.values() if values.get("urdf")}):
        _check_urdf(path)
    sequence = parameters.get("motion_composition", {}).get("sequence")
    if sequence:
        from follower_humanoid.gait.sequence import load_sequence

        load_sequence(sequence)


def _check_urdf(path: str) -> None:
    from follower_humanoid.robot.model import RobotModel

    with quiet_stderr():  # the parser has its own, longer words for it
        model = RobotModel(path)
    missing = [name for name in FRAMES if not model.pin_model.existFrame(name)]
    if missing:
        raise ConfigurationError(f"URDF {path} has no frame {', '.join(missing)}; needs {', '.join(FRAMES)}")
