"""Who can reach the graph: this machine by default, others when asked to."""

from __future__ import annotations

import os
import shutil
import socket
import struct
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived
from follower_humanoid.faults.graph_run import GraphRun, graph_run
from follower_humanoid.resources import node_command

_HOSTS = ("follower_a", "follower_b")


def addresses(pids: Iterable[int]) -> set[str]:
    """Local addresses of every internet socket of some processes."""
    found: set[str] = set()
    for pid in pids:
        try:
            links = [os.readlink(link) for link in Path(f"/proc/{pid}/fd").iterdir()]
        except OSError:  # gone meanwhile
            continue
        inodes = {link[len("socket:[") : -1] for link in links if link.startswith("socket:[")}
        for kind in ("udp", "tcp", "udp6", "tcp6"):
            table = Path(f"/proc/{pid}/net/{kind}")
            lines = table.read_text().splitlines()[1:] if table.exists() else []
            words = [line.split() for line in lines]
            found |= {_address(word[1]) for word in words if word[9] in inodes}
    return found


def _address(text: str) -> str:
    number = text.partition(":")[0]
    if len(number) == 8:
        return socket.inet_ntoa(struct.pack("<I", int(number, 16)))
    return f"IPv6 {number}"


def is_local(address: str) -> bool:
    """Loopback, or the multicast group as which nobody can be addressed from elsewhere."""
    return address.startswith("127.") or address.startswith("239.")


def network(effort: Effort) -> Iterator[Check]:
    """Sockets of a running graph, closed and opened; in the long form two hosts walk a follower."""
    with graph_run("--leader", "none") as run:
        good = run.reaches(0.0)
        found = addresses([run.process.pid, *run.children()])
        outside = sorted(address for address in found if not is_local(address))
        observed = f"{len(run.children())} processes, bound to {', '.join(outside) or 'loopback only'}"
        yield survived("sockets by default", "loopback only", observed, good and not outside)
        done = run.operate("gait_mapping")
        words = "found its services" if done.returncode == 0 else done.stdout + done.stderr
        required = "finds the graph's services"
        yield survived("a plain participant of this machine", required, words.strip(), done.returncode == 0)
    if effort.brief:
        return
    with graph_run("--leader", "none", "--open") as run:
        good = run.reaches(0.0)
        found = addresses([run.process.pid, *run.children()])
        opened = any(not is_local(address) for address in found)
        yield survived(
            "sockets with --open", "reachable", ", ".join(sorted(found)), good and opened
        )  # fmt: skip
    yield _two_hosts()


def _two_hosts() -> Check:
    what, required = "gait_mapping on another host", "walks, status 0"
    if shutil.which("ip") is None or os.geteuid() != 0:
        return survived(what, required, "not tried: needs root and the command ip", False)
    try:
        with _hosts():
            inside = ["ip", "netns", "exec"]
            with graph_run(
                "--leader", "fig4", "--duration", "6", "--open", "--without", "gait_mapping",
                prefix=(*inside, _HOSTS[0]),
            ) as run:  # fmt: skip
                environment = {**run.environment, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
                command = [*inside, _HOSTS[1], *node_command("gait_mapping")]
                other = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
                try:
                    status, steps = run.status(), _half_steps(run)
                finally:
                    other.terminate()
                    other.wait(20)
    except subprocess.CalledProcessError as error:
        return survived(what, required, f"not tried: {error}", False)
    return survived(what, required, f"status {status}, {steps} half-steps", status == 0 and steps > 0)


def _half_steps(run: GraphRun) -> int:
    line = next((line for line in run.said.splitlines() if "half-steps:" in line), "half-steps: 0")
    return int(line.rpartition(":")[2])


@contextmanager
def _hosts() -> Iterator[None]:
    """Two network namespaces joined by a cable."""

    def ip(*words: str) -> None:
        subprocess.run(["ip", *words], check=True, capture_output=True)

    try:
        for host in _HOSTS:
            ip("netns", "add", host)
        first, second = _HOSTS
        ip("link", "add", "fha", "netns", first, "type", "veth", "peer", "name", "fhb", "netns", second)
        for host, device, number in ((first, "fha", 1), (second, "fhb", 2)):
            ip("-n", host, "addr", "add", f"10.250.7.{number}/24", "dev", device)
            for link in (device, "lo"):
                ip("-n", host, "link", "set", link, "up")
            ip("-n", host, "route", "add", "239.0.0.0/8", "dev", device)
        yield
    finally:
        for host in _HOSTS:
            subprocess.run(["ip", "netns", "del", host], check=False, capture_output=True)
