"""Executable: `viewer` shows the running robot in the browser, `viewer --bag BAG` a recorded run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from follower_humanoid.command_line import Parser, split_ros_args
from follower_humanoid.core.config import build
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError


def main(args: list[str] | None = None) -> int:
    """Runs the viewer; returns the exit status."""
    own, ros_args = split_ros_args(sys.argv[1:] if args is None else args)
    try:
        given = _parser().parse_args(own)
        told = [(name, getattr(given, name)) for name in ("host", "port") if getattr(given, name) is not None]
        if given.bag is not None:
            if ros_args:
                raise ConfigurationError("--ros-args goes with the running robot; with --bag: --host, --port")
            from follower_humanoid.viewer.bag_page import show_bag
            from follower_humanoid.viewer.config import ViewerConfig

            return show_bag(given.bag, given.namespace, build(ViewerConfig, dict(told), "viewer"))
        if given.namespace is not None:
            namespace = given.namespace.strip("/")
            raise ConfigurationError(f"--namespace needs --bag; valid: --ros-args -r __ns:=/{namespace}")
        from follower_humanoid.ros.spin import run
        from follower_humanoid.ros.viewer_node import ViewerNode

        # Options come after files and assignments, and win.
        words = [word for name, value in told for word in ("-p", f"{name}:={value}")]
        return int(run([ViewerNode], ["--ros-args", *ros_args, *words]))
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="viewer",
        description="Shows the robot in the browser and lets people take its hand; its address is printed.",
        epilog="Exit status: 0 stopped, 2 bad usage or an unusable bag.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--bag", metavar="BAG", type=Path, help="a recorded run in place of the running robot")
    add("--namespace", metavar="NS", help="which robot, where the bag holds several")
    add("--host", help="address on which the page is offered (default: 127.0.0.1)")
    add("--port", type=int, help="first port to try, 0: any free one (default: 8080)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
