"""Executable: `replay BAG` plays a recorded run, `replay BAG --simulate` runs it again."""

from __future__ import annotations

import argparse
import math
import signal
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from follower_humanoid.command_line import Parser, positive, split_ros_args
from follower_humanoid.early_stop import stop_at_a_signal
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError

if TYPE_CHECKING:
    from follower_humanoid.graph.resimulate import Keep

_RATE = "recorded seconds a second, by the recording's wall clock (default: 1)"
_START = "leave out the first seconds, by the recording's wall clock"
_FOR_PLAYING = ("rate", "loop", "topics", "start", "paused")
_FOR_SIMULATING = {
    "bag_out": "--bag needs --simulate: what is only played is in a bag already",
    "namespace": "--namespace needs --simulate: what is played keeps its names",
}


def main(args: list[str] | None = None) -> int:
    """Plays or simulates; returns the exit status."""
    if args is None:  # a program of its own
        stop_at_a_signal()
    try:
        own, ros_args = split_ros_args(sys.argv[1:] if args is None else args)
        parser = _parser()
        given = parser.parse_args(own)
        given.simulate = given.simulate or given.verify
        _refuse_unused(given, parser)
        return _run(given, ros_args)
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION


def _refuse_unused(given: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    """An option that makes no difference is a misunderstanding."""
    if given.simulate:
        for name in _FOR_PLAYING:
            if getattr(given, name) != parser.get_default(name):
                raise ConfigurationError(f"--{name} has no use with --simulate or --verify")
        return
    for name, complaint in _FOR_SIMULATING.items():
        if getattr(given, name) is not None:
            raise ConfigurationError(complaint)


def _run(given: argparse.Namespace, ros_args: list[str]) -> int:
    if given.simulate:
        from follower_humanoid.replay.again import simulate_again

        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.default_int_handler)
        return simulate_again(given.bag, given.namespace, given.verify, _keep(given))
    from follower_humanoid.replay.player import PlayOptions
    from follower_humanoid.ros.replay_node import play

    options = PlayOptions(
        bag=given.bag, rate=given.rate, loop=given.loop, topics=tuple(given.topics or ()),
        start=given.start, paused=given.paused,
    )  # fmt: skip
    return play(options, ros_args)


def _keep(given: argparse.Namespace) -> Keep | None:
    """Where the new run goes."""
    if given.bag_out is None:
        return None
    from follower_humanoid.ros.simulated_bag import SimulatedBag

    return partial(SimulatedBag, given.bag_out, given.namespace)


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="replay",
        description="Publishes a recorded run with its clock. The space bar pauses it, and so do the "
        "services ~/pause, ~/resume and ~/toggle_paused.",
        epilog="Exit status: 0 played to its end or stopped, or simulated to its end, with --verify "
        "identical; 1 the simulation was stopped, its physics broke or its bag finds no room; 2 bad usage or "
        "an unusable bag; 4 it differs from the bag (the first tick, joint and difference are named).",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("bag", metavar="BAG", type=Path, help="bag folder or .mcap file, of any ROS 2 recorder")
    add("--rate", type=positive, default=1.0, metavar="R", help=_RATE)
    add("--loop", action="store_true", help="again and again")
    add("--topics", nargs="+", metavar="TOPIC", help="only these, and the clock (default: all)")
    add("--start", type=_from_zero, default=0.0, metavar="S", help=_START)
    add("--simulate", action="store_true", help="run the simulation again from the bag's parameters")
    add("--verify", action="store_true", help="and compare joint positions bit for bit (with --simulate)")
    add("--bag", dest="bag_out", type=Path, metavar="DIR", help="record the new run (with --simulate)")
    add("--namespace", metavar="NS", help="which robot to simulate, where the bag holds several")
    add("--paused", action="store_true", help="begin with a pause")
    return parser


def _from_zero(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or value < 0.0:
        raise argparse.ArgumentTypeError(f"'{text}': needs a number from 0 on")
    return value


if __name__ == "__main__":
    sys.exit(main())
