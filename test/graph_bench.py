"""Runs bringup as a user does, and looks at what it leaves behind."""

from __future__ import annotations

import os
import random
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from follower_humanoid.resources import node_command

PATIENCE = 120.0  # wall time for anything that takes seconds on a free machine [s]
# What bringup's own watchdog takes for a node that hangs is often one that a busy machine holds up.
_PATIENT = ("--ros-args", "-p", f"watchdog:={PATIENCE / 2}", "--")
ENDLESS = 3600.0  # longer than any test may last: what should come at once and does not is found [s]


def free_domain() -> int:
    """A ROS domain in which nobody is: others may run beside us, and so may another test run."""
    domains = random.sample(range(1, 101), 100)
    return next((domain for domain in domains if all(map(_is_free, _ports(domain)))), domains[0])


def _ports(domain: int) -> range:
    """Where the first participants of a domain listen (DDSI-RTPS, default port numbers)."""
    return range(7400 + 250 * domain + 10, 7400 + 250 * domain + 50)


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True


def environment() -> dict[str, str]:
    """A ROS domain of its own for each run."""
    return {**os.environ, "ROS_DOMAIN_ID": str(free_domain())}


def wait_until(condition, patience: float = PATIENCE) -> bool:
    end = time.monotonic() + patience
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


def processes_of(pid: int) -> list[tuple[int, str]]:
    """Process ids and command lines of everything that a bringup with this id has started."""
    found = []
    mark = f"follower_humanoid_{pid}_"  # the folder with their parameters
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:  # gone meanwhile
            continue
        if mark in words:
            found.append((int(entry.name), words))
    return found


@dataclass
class Bringup:
    """A running bringup."""

    process: subprocess.Popen[str]
    out: Path
    err: Path
    environment: dict[str, str]

    @property
    def said(self) -> str:
        return self.out.read_text()

    @property
    def complained(self) -> str:
        return self.err.read_text()

    def children(self) -> list[tuple[int, str]]:
        return processes_of(self.process.pid)

    def child(self, name: str) -> int:
        """Process id of the node of that name."""
        return next(pid for pid, words in self.children() if f"/{name} " in words)

    def wait_for(self, text: str) -> None:
        """Until the status line contains the text."""
        assert wait_until(lambda: text in self.said or self.process.poll() is not None), self.complained
        assert text in self.said, self.complained

    def wait_until_it_runs(self) -> None:
        """Until simulated time goes on."""
        self.wait_until_time(1e-3)

    @property
    def time(self) -> float:
        """Simulated time, as last told [s]."""
        times = [line.split()[2] for line in self.said.splitlines(True) if re.match(r"t = .*\n", line)]
        return float(times[-1]) if times else 0.0

    def wait_until_time(self, wanted: float) -> None:
        """Until the run has come so far [s]."""
        assert wait_until(lambda: self.time >= wanted or self.process.poll() is not None)
        assert self.process.poll() is None, self.complained

    def end(self, number: int = signal.SIGTERM) -> None:
        """Sends a signal and waits for the end."""
        self.process.send_signal(number)
        self.process.wait(PATIENCE)

    def wait(self) -> int:
        return self.process.wait(PATIENCE)


@contextmanager
def bringup(folder: Path, *args: str, env: dict[str, str] | None = None) -> Iterator[Bringup]:
    """A bringup with these arguments; at the end nothing of it is left."""
    number = random.randint(0, 10**9)
    out, err = folder / f"out{number}.txt", folder / f"err{number}.txt"
    own = env or environment()
    with out.open("w") as o, err.open("w") as e:
        process = subprocess.Popen(
            [*node_command("bringup"), *_PATIENT, *args], cwd=folder, env=own, stdout=o, stderr=e, text=True
        )
    try:
        yield Bringup(process, out, err, own)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
        left = processes_of(process.pid)
        if not wait_until(lambda: not processes_of(process.pid)):
            for pid, _ in processes_of(process.pid):
                os.kill(pid, signal.SIGKILL)
            raise AssertionError(f"left behind: {left}")


def run(folder: Path, *args: str) -> Bringup:
    """A bringup from beginning to end."""
    with bringup(folder, *args) as running:
        running.wait()
    return running


def node(name: str, env: dict[str, str], args: Sequence[str] = ()) -> subprocess.Popen[bytes]:
    """One node started by hand."""
    return subprocess.Popen([*node_command(name), *args], env=env, stdout=subprocess.DEVNULL)


def script(text: str, env: dict[str, str]) -> subprocess.Popen[bytes]:
    """A user's own little program."""
    return subprocess.Popen([sys.executable, "-c", text], env=env)


@contextmanager
def beside(process: subprocess.Popen[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """Something that runs beside a bringup, and is ended in any case."""
    with process:
        try:
            yield process
        finally:
            process.kill()


def run_script(text: str, env: dict[str, str]) -> None:
    """A user's own little program from beginning to end."""
    with beside(script(text, env)) as process:
        assert process.wait(PATIENCE) == 0


RESET = """
import rclpy
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("operator")
client = node.create_client(Trigger, "reset")
client.wait_for_service()
asked = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, asked)
assert asked.result().success
"""

_CHANGE = """
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
rclpy.init()
node = rclpy.create_node("operator")
client = node.create_client(ChangeState, "{name}/change_state")
client.wait_for_service()
for verb in {verbs}:
    request = ChangeState.Request()
    request.transition.id = getattr(Transition, "TRANSITION_" + verb.upper())
    asked = client.call_async(request)
    rclpy.spin_until_future_complete(node, asked)
    assert asked.result().success
"""


def change_state(name: str, env: dict[str, str], *verbs: str) -> None:
    """Takes a node through transitions of its lifecycle, such as `deactivate`."""
    run_script(_CHANGE.format(name=name, verbs=verbs), env)
