"""Entry of the command `ros2`: finds the verb and runs it."""

from __future__ import annotations

import importlib
import os
import sys
import textwrap
from collections.abc import Sequence

from follower_humanoid.command_line import Parser, UsageError
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError
from follower_humanoid.ros2_front.handover import hand_over
from follower_humanoid.ros2_front.verbs import CommandError, Verb

FAILED = 1

# Command → module and summary; a module is imported when its command is used.
COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("run", "Run an executable of a package"),
    "topic": ("topic", "List, watch and publish topics"),
    "node": ("node", "List nodes and what they offer"),
    "param": ("param", "Read and set parameters of nodes"),
    "service": ("service", "List and call services"),
    "lifecycle": ("lifecycle", "Read and change the state of lifecycle nodes"),
    "bag": ("bag", "Record, play and inspect bags"),
}
_NEEDS_ROS = "needs a ROS 2 installation"


def main(args: Sequence[str] | None = None) -> int:
    """Runs the real `ros2` where there is one, else this front; returns the exit status."""
    words = list(sys.argv[1:] if args is None else args)
    hand_over(words)
    return front(words)


def front(words: Sequence[str]) -> int:
    """Runs one command of the front; returns the exit status."""
    try:
        status = _dispatch(words)
        sys.stdout.flush()
    except ConfigurationError as error:
        return _complain(error, BAD_CONFIGURATION)
    except CommandError as error:
        return _complain(error, FAILED)
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:  # `ros2 topic echo ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return status


def _complain(error: Exception, status: int) -> int:
    sys.stdout.flush()
    print(" ".join(str(error).split()), file=sys.stderr)
    return status


def _dispatch(words: Sequence[str]) -> int:
    if not words or words[0] in ("-h", "--help"):
        print(_help())
        return 0
    command = words[0]
    if command not in COMMANDS:
        raise UsageError(f"ros2 {command}: {_NEEDS_ROS}; without one there are: {', '.join(COMMANDS)}")
    module = importlib.import_module(f"follower_humanoid.ros2_front.{COMMANDS[command][0]}")
    if command == "run":
        return int(module.run(words[1:]))
    verbs: dict[str, Verb] = {verb.name: verb for verb in module.VERBS}
    if len(words) < 2 or words[1] in ("-h", "--help"):
        print(_command_help(command, verbs))
        return 0
    if words[1] not in verbs:
        known = ", ".join(verbs)
        raise UsageError(f"ros2 {command} {words[1]}: {_NEEDS_ROS}; without one there are: {known}")
    verb = verbs[words[1]]
    parser = Parser(prog=f"ros2 {command} {verb.name}", description=verb.summary)
    verb.arguments(parser)
    return verb.run(parser.parse_args(words[2:]))


def _help() -> str:
    listed = "\n".join(f"  {name:10} {summary}" for name, (_, summary) in COMMANDS.items())
    return (
        "usage: ros2 [-h] COMMAND ...\n\n"
        + textwrap.fill(
            "A small stand-in where ROS 2 is not installed, with the arguments of the real command. "
            "A real `ros2` on the PATH is used instead of it.",
            100,
        )
        + f"\n\ncommands:\n{listed}\n\n`ros2 COMMAND --help` says more; every other command {_NEEDS_ROS}."
    )


def _command_help(command: str, verbs: dict[str, Verb]) -> str:
    listed = "\n".join(f"  {verb.name:10} {verb.summary}" for verb in verbs.values())
    return (
        f"usage: ros2 {command} [-h] VERB ...\n\n{COMMANDS[command][1]}.\n\nverbs:\n{listed}\n\n"
        f"`ros2 {command} VERB --help` says more; every other verb {_NEEDS_ROS}."
    )


if __name__ == "__main__":
    sys.exit(main())
