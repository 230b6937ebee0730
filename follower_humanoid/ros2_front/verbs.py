"""What a verb is, and how it says that the graph has no such thing."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

from follower_humanoid.errors import FollowerError


class CommandError(FollowerError):
    """The command line is fine, the graph has no such thing: one line, exit status 1."""


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
