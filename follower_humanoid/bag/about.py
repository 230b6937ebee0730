"""What a bag carries besides messages: the robot, what the run was made of, versions of everything."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

from follower_humanoid.bag.qos import plain_yaml
from follower_humanoid.bag.writer import About
from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.robot.model import RobotModel

VERSIONS = "versions.yaml"
_DISTRIBUTIONS = ("follower_humanoid", "ros-jazzy-rclpy", "pybullet", "pin", "numpy", "scipy", "mcap")


def about_run(urdf: str, texts: Mapping[str, str], tick: float) -> About:
    """What the recorder puts into the bag.

    Args:
        urdf: URDF file; empty: the package's own.
        texts: Name → text, from whoever started the run.
        tick: Control tick [s].

    Raises:
        ConfigurationError: The URDF cannot be used.
    """
    robot = RobotModel(urdf)
    return About(robot.urdf, {VERSIONS: plain_yaml(versions()), **texts}, {"tick": repr(tick)})


def texts_in(path: str) -> dict[str, str]:
    """The entries of an `about` file: name → text; anything but a text is carried as YAML.

    Args:
        path: YAML file; empty: no entries.

    Raises:
        ConfigurationError: The file cannot be used.
    """
    values = read_yaml(path) if path else {}
    if not isinstance(values, dict):
        raise ConfigurationError(f"{path}: needs a mapping of names to texts")
    return {str(name): text if isinstance(text, str) else plain_yaml(text) for name, text in values.items()}


def versions() -> dict[str, str]:
    """Versions that may change the last bit of a result."""
    found = {"python": platform.python_version(), "machine": platform.machine(), "system": platform.system()}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed by pip"
    return found
