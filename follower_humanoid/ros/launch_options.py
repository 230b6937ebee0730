"""Bringup's options as arguments of a launch file."""

from __future__ import annotations

from collections.abc import Mapping

from follower_humanoid.resources import node_command

WORDS = {
    "leader": "force programme: fig4, fig5, a YAML file, or none",
    "duration": "simulated seconds; empty: until the robot stands again",
    "bag": "folder of the recorded run, or none; empty: bags/<date-time>",
    "without": "nodes to leave out, comma-separated",
    "namespace": "namespace of the robot",
    "params": "ROS 2 parameter files, comma-separated",
}
SWITCHES = {
    "composed": "all nodes in one process",
    "realtime": "not faster than real time",
    "open": "let other machines reach the graph",
    "view": "the browser viewer beside it",
}
_LISTS = ("without", "params")


def bringup_command(values: Mapping[str, str]) -> list[str]:
    """The command line of bringup for launch arguments by name; empty ones are left out."""
    words = node_command("bringup")
    for name in WORDS:
        given = values.get(name, "")
        parts = given.split(",") if name in _LISTS else [given]
        words += [word for part in parts if part for word in (f"--{name}", part)]
    return words + [f"--{name}" for name in SWITCHES if values.get(name, "").lower() == "true"]


def displays_command(namespace: str) -> list[str]:
    """The command line of a viewer that offers no page, only what RViz and Foxglove show."""
    remap = ["-r", f"__ns:=/{namespace}"] if namespace else []
    return [*node_command("viewer"), "--ros-args", "-p", "page:=false", *remap]
