"""How every program of the package reads its command line, and complains: one line, exit status 2."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from follower_humanoid.errors import ConfigurationError


class UsageError(ConfigurationError):
    """The command line cannot be used."""


class Parser(argparse.ArgumentParser):
    """Complains in one line, with the valid options where one is unknown."""

    _GIVEN = "ignored explicit argument "  # argparse says so, and does not go on

    def error(self, message: str) -> NoReturn:
        """Raises instead of printing the whole usage."""
        if message.startswith("unrecognized arguments"):
            valid = ", ".join(name for action in self._actions for name in action.option_strings)
            message = f"{message.replace('unrecognized arguments', 'no such argument')}; valid: {valid}"
        if self._GIVEN in message:
            option, _, value = message.partition(self._GIVEN)
            message = f"{option}takes no value (given: {value})"
        raise UsageError(f"{self.prog}: {message}")


def positive(text: str) -> float:
    """A number greater than 0, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}': needs a number greater than 0")
    return value


def count(text: str) -> int:
    """A whole number from 0 on, for argparse."""
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"'{text}': needs a whole number from 0 on")
    return int(text)


def check_room(path: Path, where: str) -> None:
    """Whether a folder that need not be there yet can be made, or written to.

    Args:
        path: The folder.
        where: The option that names it.

    Raises:
        ConfigurationError: What is there of its path is no folder, or one that cannot be written to.
    """
    there = next(place for place in (path, *path.absolute().parents) if os.path.exists(place))
    if not os.path.isdir(there) or not os.access(there, os.W_OK | os.X_OK):
        raise ConfigurationError(f"{where} {path}: {there} is not a folder that can be written to")


def split_ros_args(args: Sequence[str]) -> tuple[list[str], list[str]]:
    """Own arguments, and those between `--ros-args` and `--` or the end."""
    own: list[str] = []
    ros: list[str] = []
    inside = False
    for arg in args:
        if arg == "--ros-args":
            inside = True
        elif arg == "--" and inside:
            inside = False
        else:
            (ros if inside else own).append(arg)
    return own, ros
