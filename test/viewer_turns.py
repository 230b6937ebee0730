"""Whether a graph is slower while a page is open: `python test/viewer_turns.py [SECONDS] [PAGES] [OPTIONS]`.

OPTIONS are bringup's. One run of fig. 4 with `--view`, in which pages are opened and closed every five
reports: so open and closed meet the same load of the machine, whose speed differs more from run to run than
by what is looked for. Prints the wall time per tick with and without pages, the median of what the simulator
reported, and their ratio.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from statistics import median

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from viewer_cost import Visit, free_port

from follower_humanoid.command_line import count, positive
from follower_humanoid.resources import node_command

REPORTS = 5  # of the simulator, one a second, between opening and closing


def ticks(options: Sequence[str], port: int) -> Iterator[tuple[float, int]]:
    """Wall time and tick of every report of a run."""
    heard: list[tuple[float, int]] = []

    def hear(message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            if status.name.endswith("simulator") and int(values.get("tick", 0)) > 0:
                heard.append((time.monotonic(), int(values["tick"])))

    rclpy.init()
    node = rclpy.create_node("onlooker")
    node.create_subscription(DiagnosticArray, "/diagnostics", hear, 10)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "viewer.yaml"
        file.write_text(f"viewer: {{ros__parameters: {{port: {port}}}}}\n")
        words = [*node_command("bringup"), *options, "--view", "--params", str(file)]
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
        try:
            while process.poll() is None:
                rclpy.spin_once(node, timeout_sec=0.1)
                yield from heard
                heard.clear()
        finally:
            process.terminate()
            process.wait()
    rclpy.shutdown()


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Whether an open page makes a graph slower: pages open and close in turn in one run."
    )
    add = parser.add_argument
    add("seconds", nargs="?", type=positive, default=60.0, metavar="SECONDS", help="simulated (default: 60)")
    add("pages", nargs="?", type=count, default=1, metavar="PAGES", help="opened at a time (default: 1)")
    add("options", nargs=argparse.REMAINDER, metavar="OPTIONS", help="of bringup, e.g. --composed")
    return parser.parse_args()


def main() -> int:
    given = arguments()
    options = ["--leader", "fig4", "--bag", "none", "--duration", f"{given.seconds:g}", *given.options]
    port = free_port()
    times: dict[bool, list[float]] = {False: [], True: []}
    is_open, reports = False, 0
    with ExitStack() as stack:
        for (before, first), (after, last) in pairwise(ticks(options, port)):
            reports += 1
            if reports > 1 and last > first:  # the first one has seen both
                times[is_open].append((after - before) / (last - first))
            if reports > REPORTS:
                is_open, reports = not is_open, 0
                stack.pop_all().close()
                for _ in range(given.pages if is_open else 0):
                    stack.callback(Visit(port, True).close)
    if not (times[False] and times[True]):
        print(f"too short: pages open and close every {REPORTS} s of the wall's clock", file=sys.stderr)
        return 1
    for state, name in ((False, "closed"), (True, "open")):
        print(f"{name}: {median(times[state]) * 1e6:.0f} µs a tick, {len(times[state])} reports")
    print(f"ratio {median(times[True]) / median(times[False]):.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
