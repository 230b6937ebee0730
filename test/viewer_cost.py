"""What the viewer costs, and whether anybody notices it: `python test/viewer_cost.py [ROUNDS] [SECONDS]`.

Runs of fig. 4 without viewer, with its page closed, open once, open three times, and open where nobody reads
what is sent, in turn, so that all meet the same load of the machine. The pages take part like a browser's,
but draw nothing: what drawing costs depends on the graphics card. Prints, per kind of run: CPU of the graph's
process per tick and its wall time, both with that round's run without viewer = 1; share of a core that the
viewer takes; whether joint positions are the same bit for bit.
"""

from __future__ import annotations

import argparse
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import msgspec.msgpack
import viser
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from follower_humanoid.bench.placement import Listener, Placed
from follower_humanoid.command_line import count, positive

TICK = 0.002
# Pages that read and pages that do not; None: no viewer.
KINDS = {
    "no viewer": None,
    "page closed": (0, 0),
    "one page": (1, 0),
    "three pages": (3, 0),
    "nobody reads": (0, 1),
}
_CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (2.0, -2.3, 1.4), "fov": 0.7,
    "near": 0.1, "far": 100.0, "image_height": 800, "image_width": 1200, "look_at": (0.0, 0.0, 0.8),
    "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip


class Visit:
    """A page that is open as long as there is a viewer.

    Attributes:
        heard: What has come [bytes].
    """

    def __init__(self, port: int, reads: bool) -> None:
        self.heard = 0
        self._port, self._reads = port, reads
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._stay)
        self._thread.start()

    def _stay(self) -> None:
        while not self._over.is_set():
            try:
                with self._connection() as line:
                    line.send(msgspec.msgpack.encode(_CAMERA))
                    while not self._over.is_set():
                        if self._reads:
                            self.heard += len(line.recv(1.0))
                        else:
                            time.sleep(0.2)
            except (OSError, TimeoutError, WebSocketException):
                time.sleep(0.1)

    def _connection(self) -> ClientConnection:
        return connect(
            f"ws://127.0.0.1:{self._port}",
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=None,
            max_queue=1,
            ping_interval=None,
            close_timeout=0.1,
        )

    def close(self) -> None:
        self._over.set()
        self._thread.join()


class ProcessClock:
    """Share of a core that the viewer's process takes while the graph runs."""

    def __init__(self, mark: str) -> None:
        self._mark, self._samples = mark, list[tuple[float, float]]()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()

    def _watch(self) -> None:
        while not self._over.wait(0.25):
            for entry in Path("/proc").iterdir():
                try:
                    if entry.name.isdigit() and self._mark in (entry / "cmdline").read_text():
                        fields = (entry / "stat").read_text().rpartition(")")[2].split()
                        ticks = int(fields[11]) + int(fields[12])
                        self._samples.append((time.monotonic(), ticks / 100.0))
                except OSError:
                    continue

    def share(self, since: float) -> float:
        """From so many seconds before its end on: starting is no drawing."""
        self._over.set()
        self._thread.join()
        late = [sample for sample in self._samples if sample[0] > self._samples[-1][0] - since]
        (begin, first), (end, last) = late[0], late[-1]
        return (last - first) / max(end - begin, 0.1)


@dataclass
class Run:
    """One run: cost and result of the graph, share of a core of the viewer, bytes that pages were sent."""

    placed: Placed
    share: float
    heard: int


@contextmanager
def visits(port: int, reading: int, deaf: int) -> Iterator[list[Visit]]:
    with ExitStack() as stack:
        pages = [Visit(port, reads) for reads in [True] * reading + [False] * deaf]
        for page in pages:
            stack.callback(page.close)
        yield pages


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def run(listener: Listener, pages: tuple[int, int] | None, seconds: float) -> Run:
    options = ["--composed", "--leader", "fig4", "--duration", f"{seconds:g}"]
    if pages is None:
        return Run(listener.run(TICK, *options), 0.0, 0)
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "viewer.yaml"
        file.write_text(f"viewer: {{ros__parameters: {{port: {port}}}}}\n")
        with visits(port, *pages) as open_pages:
            clock = ProcessClock("exe/viewer ")
            placed = listener.run(TICK, *options, "--view", "--params", str(file))
            wall = seconds / placed.simulator("mean_real_time_factor")
            return Run(placed, clock.share(0.8 * wall), sum(page.heard for page in open_pages))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="What the viewer costs, and whether anybody notices it: runs with and without it in turn."
    )
    add = parser.add_argument
    kinds = f"of the {len(KINDS)} kinds of run"
    add("rounds", nargs="?", type=count, default=3, metavar="ROUNDS", help=f"{kinds}, from 1 on (default: 3)")
    add("seconds", nargs="?", type=positive, default=6.0, metavar="SECONDS", help="simulated (default: 6)")
    given = parser.parse_args()
    if not given.rounds:
        parser.error("argument ROUNDS: '0': needs a whole number from 1 on")
    return given


def main() -> int:
    given = arguments()
    rounds, seconds = given.rounds, given.seconds
    listener = Listener()
    runs: dict[str, list[Run]] = {kind: [] for kind in KINDS}
    try:
        for number in range(rounds):
            kinds = list(KINDS)
            for kind in kinds[number % len(kinds) :] + kinds[: number % len(kinds)]:
                runs[kind].append(run(listener, KINDS[kind], seconds))
    finally:
        listener.close()
    bare = runs["no viewer"]
    hashes = {r.placed.values["simulator"]["joint_hash"] for every in runs.values() for r in every}
    print("| | graph's CPU | graph's wall time | viewer, share of a core | sent to pages [MB/s] |")
    print("|---|---|---|---|---|")
    for kind, every in runs.items():
        cpu = [r.placed.total_cpu / b.placed.total_cpu for r, b in zip(every, bare, strict=True)]
        wall = [r.placed.wall / b.placed.wall for r, b in zip(every, bare, strict=True)]
        sent = [r.heard / 1e6 / (r.placed.wall * seconds / TICK) for r in every]
        share = [r.share for r in every]
        spread = [f"{median(v):.3f} ({min(v):.2f} to {max(v):.2f})" for v in (cpu, wall)]
        print(f"| {kind} | {spread[0]} | {spread[1]} | {median(share):.1%} | {median(sent):.2f} |")
    print(f"joint positions of {sum(map(len, runs.values()))} runs: {len(hashes)} different")
    return 0 if len(hashes) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
