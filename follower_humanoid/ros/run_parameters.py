"""The parameters of a run: the package's file, the user's files over it, then single assignments."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from follower_humanoid.core.topics import TOPICS
from follower_humanoid.core.yaml_file import read_value, read_yaml
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.graph_config import RECORDER, VIEWER
from follower_humanoid.graph.wiring import ARM_TASK, NODES
from follower_humanoid.resources import share_path

KEY = "ros__parameters"
Parameters = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class RunParameters:
    """What the nodes are told.

    Attributes:
        all: Node → dotted name → value.
        own: The same, only what the user has set.
    """

    all: Parameters
    own: Parameters

    def set(self, node: str, **values: Any) -> None:
        """Sets values for a node."""
        self.all.setdefault(node, {}).update(values)


def run_parameters(
    files: Sequence[Path], assignments: Sequence[tuple[str, str, str]], namespace: str
) -> RunParameters:
    """Lays files and assignments (node or nothing, name, text) over the package's file.

    Raises:
        ConfigurationError: A file, name or value cannot be used.
    """
    base = share_path("config/follower.yaml")
    if not files and not assignments and (unchecked := _unchecked(base)) is not None:
        return RunParameters(unchecked, {})
    # Imports every component for its configuration: only where there is something to check.
    from follower_humanoid.graph.config_file import load_parameters
    from follower_humanoid.graph.node_configs import node_names, node_parameters

    merged, own = load_parameters([base, *files], namespace), load_parameters(files, namespace)
    for target, name, text in assignments:
        known = {n: node_parameters(n) for n in ([target] if target else node_names())}
        having = {n: infos[name] for n, infos in known.items() if name in infos}
        if not having:
            where = f"--ros-args -p: {target}" if target else "--ros-args -p"
            raise UnknownNameError("parameter", name, {v for infos in known.values() for v in infos}, where)
        value = read_value(text, f"--ros-args -p {name}")
        for n, info in having.items():
            checked = info.checked(value, "--ros-args -p")
            for layer in (merged, own):
                layer.setdefault(n, {})[name] = checked
    return RunParameters(_plain(merged), _plain(own))


def _plain(parameters: Parameters) -> Parameters:
    """Lists in place of tuples, which YAML does not have."""
    return {
        node: {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}
        for node, values in parameters.items()
    }


def _unchecked(path: Path) -> Parameters | None:
    """The package's own file, which a test holds equal to the dataclasses; None if it looks otherwise."""
    content = read_yaml(path)
    try:
        common = content["/**"][KEY]
        return {node: {**common, **content.get(node, {}).get(KEY, {})} for node in (*NODES, RECORDER, VIEWER)}
    except (AttributeError, KeyError, TypeError):
        return None


def split_parameters(
    ros_args: Iterable[str],
) -> tuple[tuple[str, ...], list[Path], list[tuple[str, str, str]]]:
    """Takes parameter files and assignments out of ROS arguments.

    They are laid over the files here, since ROS 2 lets a value for one node win over one for all
    nodes that was given later.
    """
    rest: list[str] = []
    files: list[Path] = []
    assignments: list[tuple[str, str, str]] = []
    words = iter(ros_args)
    for word in words:
        if word not in ("-p", "--param", "--params-file"):
            rest.append(word)
            continue
        value = next(words, None)
        if value is None:
            raise ConfigurationError(f"--ros-args {word}: needs a value")
        if word == "--params-file":
            files.append(Path(value))
            continue
        name, sign, text = value.partition(":=")
        if not sign:
            raise ConfigurationError(f"--ros-args {word} {value}: needs NAME:=VALUE")
        node, _, own = name.rpartition(":")
        if node and node not in (*NODES, ARM_TASK.name, RECORDER, VIEWER):
            raise UnknownNameError("node", node, (*NODES, RECORDER, VIEWER), f"--ros-args {word}")
        assignments.append((node, own, text))
    return tuple(rest), files, assignments


def remapped_topics(ros_args: Sequence[str]) -> tuple[str, ...]:
    """Topics of the tick that ROS arguments give another name, for all nodes or for one."""
    rules = [value for word, value in pairwise(ros_args) if word in ("-r", "--remap")]
    names = [rule.partition(":=")[0].rpartition(":")[2] for rule in rules]
    return tuple(t for t in TOPICS if any(name == t or name.endswith(f"/{t}") for name in names))
