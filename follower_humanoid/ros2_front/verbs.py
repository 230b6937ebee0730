"""What a verb is, how its arguments are read, and how it says that something is wrong."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

from follower_humanoid.errors import ConfigurationError, FollowerError


class UsageError(ConfigurationError):
    """The command line cannot be used: one line, exit status 2."""


class CommandError(FollowerError):
    """The command line is fine, the graph has no such thing: one line, exit status 1."""


class Parser(argparse.ArgumentParser):
    """Complains in one line."""

    def error(self, message: str) -> NoReturn:
        """Raises instead of printing the whole usage."""
        if message.startswith("unrecognized arguments"):
            valid = ", ".join(name for action in self._actions for name in action.option_strings)
            message = f"{message.replace('unrecognized arguments', 'no such argument')}; valid: {valid}"
        raise UsageError(f"{self.prog}: {message}")


def _no_arguments(parser: argparse.ArgumentParser) -> None:
    """For verbs without arguments."""


@dataclass(frozen=True)
class Verb:
    """One verb of a command, `list` of `ros2 topic list`.

    Attributes:
        name: The word.
        summary: One line for `--help`.
        run: Does it; returns the exit status.
        arguments: Adds its arguments to a parser.
    """

    name: str
    summary: str
    run: Callable[[argparse.Namespace], int]
    arguments: Callable[[argparse.ArgumentParser], None] = _no_arguments


def positive(text: str) -> float:
    """A number greater than 0, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}': needs a number greater than 0")
    return value


def count(text: str) -> int:
    """A whole number from 0 on, for argparse."""
    if not text.isdigit():
        raise argparse.ArgumentTypeError(f"'{text}': needs a whole number from 0 on")
    return int(text)
