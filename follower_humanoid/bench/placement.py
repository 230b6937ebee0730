"""One run of the graph through bringup, and what its nodes and processes say of its cost."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from follower_humanoid.errors import FollowerError
from follower_humanoid.resources import node_command

TIMEOUT = 1800.0
_ATTEMPTS = 3  # a listener that is matched late misses a short run
_SAMPLE_EVERY = 0.5  # wall time between two looks at the memory [s]


@dataclass(frozen=True)
class Placed:
    """What one run came to.

    Attributes:
        wall: Per tick [s].
        cpu: Process → CPU per tick [s]; with one process per node its name is the node's.
        start_up: From the start of bringup to the first tick [s].
        memory: Process → proportional share of memory at the end [bytes].
        values: Node → key → text, its last diagnostics.
    """

    wall: float
    cpu: dict[str, float]
    start_up: float
    memory: dict[str, int]
    values: dict[str, dict[str, str]] = field(repr=False)

    @property
    def total_cpu(self) -> float:
        """Of all processes per tick [s]."""
        return sum(self.cpu.values())

    def simulator(self, key: str) -> float:
        """A number that the simulator reported."""
        return float(self.values["simulator"][key])


class Listener:
    """Hears the diagnostics of one run after the other."""

    def __init__(self) -> None:
        """Starts ROS in this process, with what bringup uses."""
        os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        from follower_humanoid.ros.director import Director
        from follower_humanoid.ros.spin import start_ros

        start_ros(["--ros-args"])
        self._director = Director()

    def run(self, tick: float, *options: str, recorded: bool = False) -> Placed:
        """Runs bringup with these options to its end; again where the last diagnostics were not heard.

        Args:
            tick: Control tick [s].
            options: Of bringup, all but `--bag`.
            recorded: Whether a bag is written, which nobody keeps.

        Raises:
            FollowerError: It did not end well.
        """
        for _ in range(_ATTEMPTS):
            with tempfile.TemporaryDirectory() as folder:  # a bag is never written over another one
                bag = str(Path(folder) / "bag") if recorded else "none"
                placed = self._run(tick, *options, "--bag", bag)
            if placed is not None:
                return placed
        raise FollowerError(f"bringup {' '.join(options)}: the simulator's last diagnostics were not heard")

    def _run(self, tick: float, *options: str) -> Placed | None:
        from follower_humanoid.ros.outcome import ENDED

        director = self._director
        director.values.clear()
        memory: dict[str, int] = {}
        with tempfile.TemporaryFile("w+") as words:
            started = time.time()
            process = subprocess.Popen(
                [*node_command("bringup"), *options], stdout=subprocess.DEVNULL, stderr=words
            )
            until = time.monotonic() + TIMEOUT
            while process.poll() is None:
                director.spin(_SAMPLE_EVERY)
                memory.update(memory_of_children(process.pid))
                if time.monotonic() > until:
                    process.terminate()
            director.spin(0.1)
            if process.returncode != 0:
                words.seek(0)
                raise FollowerError(
                    f"bringup {' '.join(options)} ended with {process.returncode}: {words.read()}"
                )
        values = dict(director.values)
        simulator = values.get("simulator", {})
        if ENDED not in simulator or "began_at [s]" not in simulator:
            return None
        return Placed(
            wall=tick / float(simulator["mean_real_time_factor"]),
            cpu=dict(_cpu(values, "--composed" in options)),
            start_up=float(simulator["began_at [s]"]) - started,
            memory=memory,
            values=values,
        )

    def close(self) -> None:
        """Ends ROS in this process."""
        from rclpy.utilities import try_shutdown

        self._director.close()
        try_shutdown()


def _cpu(values: Mapping[str, Mapping[str, str]], composed: bool) -> Iterator[tuple[str, float]]:
    for node, own in values.items():
        if "process_cpu_per_tick [s]" in own and (not composed or node == "simulator"):
            yield "composed" if composed else node, float(own["process_cpu_per_tick [s]"])


def memory_of_children(parent: int, what: str = "Pss") -> dict[str, int]:
    """Name of each process that a process has started → its proportional share of memory [bytes].

    `what`: `Pss`, or `Pss_Anon` for its own data alone: of libraries on disk everybody who happens to use
    them has a share.
    """
    found: dict[str, int] = {}
    for entry in children_of(parent):
        try:
            words: Any = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode().split()
            rollup = (entry / "smaps_rollup").read_text()
            kilobytes = int(rollup.partition(f"\n{what}:")[2].split()[0])
        except (OSError, IndexError, ValueError):  # gone meanwhile
            continue
        if len(words) > 1:
            found[Path(words[1]).name] = kilobytes * 1024
    return found


def cpu_of_children(parent: int) -> float:
    """Processor time that the processes which a process has started have used [s]."""
    used = 0
    for entry in children_of(parent):
        with suppress(OSError, IndexError, ValueError):  # gone meanwhile
            used += sum(map(int, _stat(entry)[11:13]))
    return used / os.sysconf("SC_CLK_TCK")


def children_of(parent: int) -> Iterator[Path]:
    """Folders in `/proc` of the processes that a process has started."""
    for entry in Path("/proc").iterdir():
        with suppress(OSError, IndexError, ValueError):  # gone meanwhile
            if entry.name.isdigit() and int(_stat(entry)[1]) == parent:
                yield entry


def _stat(entry: Path) -> list[str]:
    """What `/proc/PID/stat` says after the process's name: state, parent, ..."""
    return (entry / "stat").read_text().rpartition(")")[2].split()
