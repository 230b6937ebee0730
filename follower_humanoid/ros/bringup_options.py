"""The command line of bringup, checked before anything starts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from follower_humanoid.command_line import Parser, check_room, positive, split_ros_args
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.graph_config import RECORDER, VIEWER
from follower_humanoid.graph.wiring import NODES

NONE = "none"
DEFAULT_LEADER = "fig4"
_NAMESPACE = re.compile(r"(/?[A-Za-z_][A-Za-z0-9_]*)(/[A-Za-z_][A-Za-z0-9_]*)*/?")


@dataclass(frozen=True)
class Options:
    """What the user asked for.

    Attributes:
        leader: Built-in programme, YAML file or `none`.
        duration: Simulated seconds, None where it was not given.
        bag: Folder of the bag, None for no bag.
        composed: All nodes in one process.
        without: Nodes left out.
        realtime: Not faster than real time.
        namespace: Namespace without a leading slash, empty for none.
        params: Parameter files, later ones win.
        open: Other machines can reach the graph.
        view: The browser viewer beside it.
        ros_args: What followed `--ros-args`, for every node.
        given: Which of `leader` and `bag` were said; a default gives way to the user's parameters.
    """

    leader: str
    duration: float | None
    bag: Path | None
    composed: bool
    without: tuple[str, ...]
    realtime: bool
    namespace: str
    params: tuple[Path, ...]
    view: bool
    ros_args: tuple[str, ...]
    given: frozenset[str] = frozenset()
    open: bool = False


def _parser() -> Parser:
    parser = Parser(
        prog="bringup",
        description="Starts the graph: the follower walks behind the leader's hand, the run is recorded.",
        epilog="Exit status: 0 ended upright, 2 bad usage, 3 the robot fell, 1 anything else. "
        "What follows --ros-args goes to every node.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--leader", metavar="NAME|FILE|none", help="force programme (default: fig4)")
    add("--duration", type=positive, metavar="S", help="simulated seconds (default: until it stands again)")
    add("--bag", metavar="DIR|none", help="folder of the recorded run (default: bags/<date-time>)")
    add("--composed", action="store_true", help="all nodes in one process")
    add("--without", action="append", default=[], metavar="NODE", help="leave a node out; repeatable")
    add("--realtime", action="store_true", help="not faster than real time")
    add("--namespace", default="", metavar="NS", help="put the robot under a namespace")
    add("--params", action="append", default=[], metavar="FILE", help="ROS 2 parameter file; repeatable")
    add("--open", action="store_true", help="let other machines reach the graph, see docs/network.md")
    add("--view", action="store_true", help="the browser viewer beside it")
    return parser


def parse(args: Sequence[str]) -> Options:
    """Reads the command line.

    Raises:
        ConfigurationError: An option is unknown or unusable; one line that says which values are valid.
    """
    own, ros_args = split_ros_args(args)
    given = _parser().parse_args(own)
    for name in given.without:
        if name not in NODES:
            raise UnknownNameError("node", name, NODES, "--without", _meant(name))
    if given.namespace and not _NAMESPACE.fullmatch(given.namespace):
        raise ConfigurationError(
            f"--namespace '{given.namespace}': valid: letters, digits and _, not beginning with a digit, "
            "parts joined by /"
        )
    return Options(
        leader=DEFAULT_LEADER if given.leader is None else given.leader,
        duration=given.duration,
        bag=bag_folder(given.bag),
        composed=given.composed,
        without=tuple(dict.fromkeys(given.without)),
        realtime=given.realtime,
        namespace=given.namespace.strip("/"),
        params=tuple(Path(path) for path in given.params),
        view=given.view,
        open=given.open,
        ros_args=tuple(ros_args),
        given=frozenset(name for name in ("leader", "bag") if getattr(given, name) is not None),
    )


def _meant(name: str) -> str:
    """What a name that cannot be left out may be meant to say."""
    parts = [part.strip() for part in name.split(",") if part.strip()]
    if len(parts) > 1:
        return f"one at a time: {' '.join(f'--without {part}' for part in parts)}"
    return {RECORDER: "--bag none leaves it out", VIEWER: "it runs with --view only"}.get(name, "")


def bag_folder(given: str | None, where: str = "--bag") -> Path | None:
    """The folder of the bag, checked; None for `none`.

    Raises:
        ConfigurationError: It exists already or cannot be made.
    """
    if given == NONE:
        return None
    if given == "":
        raise ConfigurationError(f"{where} '': needs a folder or 'none'")
    folder = Path(given) if given else Path("bags", datetime.now().strftime("%Y-%m-%d-%H-%M-%S"))
    try:
        folder = folder.expanduser().absolute()
        taken = folder.exists() or folder.is_symlink()
    except (OSError, RuntimeError) as error:  # too long a name; a home that does not exist
        reason = error.strerror if isinstance(error, OSError) else error
        raise ConfigurationError(f"{where} {folder}: no folder can have that name: {reason}") from None
    if taken:
        raise ConfigurationError(f"{where} {folder}: exists already, is not overwritten; name a new folder")
    check_room(folder, where)
    return folder
