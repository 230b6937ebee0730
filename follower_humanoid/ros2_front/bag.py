"""`ros2 bag ...`: the verbs and their arguments, as ros2cli has them."""

from __future__ import annotations

import argparse
import sys
from datetime import datetime, timezone
from pathlib import Path

from follower_humanoid.command_line import UsageError, positive
from follower_humanoid.replay.index import BagIndex, index_bag
from follower_humanoid.replay.player import CLOCK_RATE, PlayOptions
from follower_humanoid.ros2_front import bag_record
from follower_humanoid.ros2_front.graph import stay_on_this_machine
from follower_humanoid.ros2_front.verbs import Verb

_UNITS = ("B", "KiB", "MiB", "GiB", "TiB")


def _bag_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("bag_path", nargs="?", type=Path, help="bag folder or .mcap file")
    parser.add_argument("-i", "--input", type=Path, metavar="BAG", help="the same")
    parser.add_argument("-s", "--storage", metavar="ID", help="accepted; found out anyway")


def _bag(args: argparse.Namespace) -> Path:
    bag: Path | None = args.bag_path or args.input
    if bag is None:
        raise UsageError("needs a bag folder or .mcap file")
    return bag


def _info_arguments(parser: argparse.ArgumentParser) -> None:
    _bag_argument(parser)
    parser.add_argument("-t", "--topic-name", action="store_true", help="only the names of the topics")
    parser.add_argument("-v", "--verbose", action="store_true", help="accepted; nothing more is known")


def _info(args: argparse.Namespace) -> int:
    index = index_bag(_bag(args))
    if args.topic_name:
        print("\n".join(sorted(index.topics)))
    else:
        print(information(index))
    for note in index.notes:
        print(f"note: {note}", file=sys.stderr)
    return 0


def information(index: BagIndex) -> str:
    """A bag in the words of `ros2 bag info`."""
    size = float(sum(file.stat().st_size for file in index.files))
    unit = 0
    while size >= 1024.0 and unit < len(_UNITS) - 1:
        size, unit = size / 1024.0, unit + 1
    lines = [
        f"Files:             {', '.join(file.name for file in index.files)}",
        f"Bag size:          {size:.1f} {_UNITS[unit]}",
        f"Storage id:        {'sqlite3' if index.files[0].suffix == '.db3' else 'mcap'}",
        f"Duration:          {index.duration:.9f}s",
        f"Start:             {_moment(index.begin)}",
        f"End:               {_moment(index.end)}",
        f"Messages:          {index.count}",
    ]
    title = "Topic information:"
    for name, topic in sorted(index.topics.items()):
        entry = f"Topic: {name} | Type: {topic.type_name} | Count: {topic.count} | Serialization Format: cdr"
        lines.append(f"{title:18} {entry}")
        title = ""
    return "\n".join(lines)


def _moment(time: int) -> str:
    seconds, nanoseconds = divmod(time, 1_000_000_000)
    local = datetime.fromtimestamp(seconds, timezone.utc).astimezone()
    return f"{local:%b %e %Y %H:%M:%S}.{nanoseconds:09d} ({seconds}.{nanoseconds:09d})"


def _play_arguments(parser: argparse.ArgumentParser) -> None:
    _bag_argument(parser)
    add = parser.add_argument
    add("-r", "--rate", type=positive, default=1.0, metavar="R", help="recorded seconds a second")
    add("--topics", nargs="+", default=[], metavar="TOPIC", help="only these (default: all)")
    add("--exclude-topics", nargs="+", default=[], metavar="TOPIC", help="all but these")
    add("-l", "--loop", action="store_true", help="again and again")
    add("--start-offset", type=float, default=0.0, metavar="S", help="leave out the first seconds")
    add("--playback-duration", type=positive, metavar="S", help="end after that much recorded time")
    add("-p", "--start-paused", action="store_true", help="begin with a pause; the space bar goes on")
    add("--clock", nargs="?", type=positive, const=CLOCK_RATE, default=0.0, metavar="HZ",
        help=f"publish /clock where the bag has none (default: {CLOCK_RATE:g} Hz)")  # fmt: skip
    add("-m", "--remap", nargs="+", default=[], metavar="OLD:=NEW", help="other names of topics")


def _play(args: argparse.Namespace) -> int:
    from follower_humanoid.ros.replay_node import play

    if not 0.0 <= args.start_offset < float("inf"):
        raise UsageError(f"--start-offset {args.start_offset}: needs a number from 0 on")
    stay_on_this_machine()
    options = PlayOptions(
        bag=_bag(args),
        rate=args.rate,
        loop=args.loop,
        topics=tuple(args.topics),
        without=tuple(args.exclude_topics),
        start=args.start_offset,
        start_option="--start-offset",
        duration=args.playback_duration,
        paused=args.start_paused,
        clock=args.clock,
        clock_always=False,
    )
    remaps = [word for rule in args.remap for word in ("-r", rule)]
    return play(options, remaps, "rosbag2_player")


VERBS = (
    Verb("info", "What a bag holds", _info, _info_arguments),
    Verb("play", "Publish what a bag holds", _play, _play_arguments),
    Verb("record", "Record topics into a bag", bag_record.run, bag_record.arguments),
)
