"""How cost grows with robots and with time: `benchmark --growth`."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from follower_humanoid.bench.check import Check, at_most
from follower_humanoid.bench.placement import cpu_of_children, memory_of_children
from follower_humanoid.errors import FollowerError
from follower_humanoid.resources import node_command

FOLLOWERS = (1, 2, 4)
MINUTES = (1, 10, 60)
_LOOK = 1.0  # wall time between two looks [s]
_LAST_LINES = 12  # of what a follower said, where it did not end well
_SETTLED = 60.0  # simulated time after which memory stays [s]
_FLAT, _LINEAR, _MEMORY = 1.1, 1.15, 1.03
_LINE = re.compile(r"t = ([0-9.]+) s")


@dataclass
class Course:
    """How one robot's run went on.

    Attributes:
        wall: Wall time [s] of each look.
        cpu: Processor time that its processes have used by then [s].
        simulated: Simulated time then [s].
        memory: All its processes' data then [bytes]; libraries left out.
    """

    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    simulated: list[float] = field(default_factory=list)
    memory: list[int] = field(default_factory=list)

    def pace(self, clock: list[float], begin: float, end: float) -> float:
        """Time of a clock, `wall` or `cpu`, per simulated time between two shares of the run, 0…1."""
        last = self.simulated[-1]
        inside = [
            (t, s)
            for t, s in zip(clock, self.simulated, strict=True)
            if begin * last <= s <= end * last and s > 0.0
        ]
        if len(inside) < 2 or inside[-1][1] == inside[0][1]:
            raise FollowerError(f"a run of {last:g} s is too short to see how it goes on")
        return (inside[-1][0] - inside[0][0]) / (inside[-1][1] - inside[0][1])

    def slower_at_the_end(self) -> float:
        """Processor time per tick in the last fifth of the run over that near its beginning.

        Wall time would tell as much about what else the machine does.
        """
        return self.pace(self.cpu, 0.8, 1.0) / self.pace(self.cpu, 0.1, 0.3)

    def memory_since(self, simulated: float) -> float:
        """Memory at the end over that at a simulated time [s]."""
        then = next(m for s, m in zip(self.simulated, self.memory, strict=True) if s >= simulated)
        return median(self.memory[-5:]) / then


def run(followers: int, seconds: float) -> list[Course]:
    """Runs followers side by side, each in its namespace, standing and walking by turns.

    Raises:
        FollowerError: One of them did not end well.
    """
    with tempfile.TemporaryDirectory() as folder:
        programme = Path(folder) / "walk.yaml"
        programme.write_text(_walk(seconds), encoding="utf-8")
        options = ["--leader", str(programme), "--duration", f"{seconds:g}", "--bag", "none", "--composed"]
        paths = [Path(folder) / f"out{n}" for n in range(followers)]
        files = [path.open("w") for path in paths]
        processes = [
            subprocess.Popen(
                [*node_command("bringup"), *options, "--namespace", f"follower_{n}"],
                stdout=file,
                stderr=subprocess.STDOUT,
                env=os.environ,
            )
            for n, file in enumerate(files)
        ]
        courses = [Course() for _ in processes]
        try:
            while any(process.poll() is None for process in processes):
                time.sleep(_LOOK)
                for process, path, course in zip(processes, paths, courses, strict=True):
                    _look(process.pid, path.read_text(encoding="utf-8"), course)
        finally:
            for process, file in zip(processes, files, strict=True):
                if process.poll() is None:
                    process.terminate()
                    process.wait()
                file.close()
        for process, path in zip(processes, paths, strict=True):
            if process.returncode:
                said = path.read_text(encoding="utf-8").splitlines()[-_LAST_LINES:]
                raise FollowerError(
                    f"one of {followers} followers ended with status {process.returncode}: {' | '.join(said)}"
                )
    return courses


def _walk(seconds: float) -> str:
    """Twenty seconds of pull, ten of rest, and so on."""
    lines = []
    at = 0.0
    while at < seconds:
        lines.append(f"- {{until: {at + 20:g}, left: [4, 0, 0]}}\n- {{until: {at + 30:g}}}\n")
        at += 30.0
    return "".join(lines)


def _look(pid: int, said: str, course: Course) -> None:
    memory, cpu = sum(memory_of_children(pid, "Pss_Anon").values()), cpu_of_children(pid)
    times = _LINE.findall(said)
    if times and memory and (not course.simulated or float(times[-1]) > course.simulated[-1]):
        course.wall.append(time.monotonic())
        course.cpu.append(cpu)
        course.simulated.append(float(times[-1]))
        course.memory.append(memory)


def measure(brief: bool, say: Callable[[str], None]) -> tuple[list[str], list[Check]]:
    """Lines of the table, and required against measured."""
    followers = FOLLOWERS[:2] if brief else FOLLOWERS
    titles = ("followers", "minutes", "wall s per s", "CPU s per s", "end / begin", "memory MB")
    lines = ["".join(f"{title:>14}" for title in titles)]
    checks: list[Check] = []
    pace_of: dict[int, float] = {}
    plan = [(n, 0.5 if brief else float(MINUTES[0])) for n in followers]
    plan += [] if brief else [(1, float(minutes)) for minutes in MINUTES[1:]]
    for count, minutes in plan:
        say(f"{count} for {minutes:g} min")
        courses = run(count, minutes * 60.0)
        pace = median(course.pace(course.wall, 0.1, 1.0) for course in courses)
        used = median(course.pace(course.cpu, 0.1, 1.0) for course in courses)
        growth = median(course.slower_at_the_end() for course in courses)
        memory = sum(course.memory[-1] for course in courses) / 1e6
        lines.append(f"{count:>14}{minutes:>14g}{pace:>14.2f}{used:>14.2f}{growth:>14.2f}{memory:>14.0f}")
        pace_of.setdefault(count, pace)
        if minutes * 60.0 > 2.0 * _SETTLED:
            what = f"{minutes:g} min: processor time per tick, end over beginning"
            checks.append(at_most(what, growth, _FLAT))
            kept = max(course.memory_since(_SETTLED) for course in courses)
            checks.append(at_most(f"{minutes:g} min: memory, end over first minute", kept, _MEMORY))
    cores = len(os.sched_getaffinity(0))
    for count in followers[1:]:
        ratio = pace_of[count] / pace_of[1] / max(1.0, count / cores)
        what = f"{count} followers on {cores} cores: time per tick, one = 1"
        checks.append(at_most(what, ratio, _LINEAR))
    return lines, checks
