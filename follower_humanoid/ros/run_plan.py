"""From the options of bringup to what each node is told; everything is checked here, nothing started."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.wiring import ARM_TASK, NODES, SIMULATOR
from follower_humanoid.resources import share_path
from follower_humanoid.ros.bringup_options import NONE, Options
from follower_humanoid.ros.graph_config import LEADER, RECORDER
from follower_humanoid.ros.quiet import quiet_stderr

LONGEST_SETTLING = 10.0
_KEY = "ros__parameters"
Parameters = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class RunPlan:
    """What bringup is about to start.

    Attributes:
        options: What the user asked for.
        nodes: Nodes of the wiring table that run.
        parameters: Node → dotted name → value, for the recorder too.
        ros_args: Arguments for every node, without parameters.
        about: Name → text, what a repetition of the run needs.
    """

    options: Options
    nodes: tuple[str, ...]
    parameters: Parameters
    ros_args: tuple[str, ...]
    about: dict[str, str]

    def parameter_file(self, namespace: str) -> str:
        """The parameters as one ROS 2 file, a block per node."""
        above = f"/{namespace}" if namespace else ""
        return _yaml({f"{above}/{node}": {_KEY: values} for node, values in self.parameters.items()})


def make_plan(options: Options) -> RunPlan:
    """Checks everything and lays defaults, files and options over one another.

    Raises:
        ConfigurationError: Programme, parameter file or value cannot be used.
    """
    ros_args, files, assignments = _split_parameters(options.ros_args)
    nodes = tuple(
        name
        for name in NODES
        if name not in options.without and not (name == LEADER and options.leader == NONE)
    )
    parameters = _parameters((*options.params, *files), assignments, options.namespace)
    about = {"command": shlex.join(["bringup", *_spoken(options)])}
    duration, settle = options.duration or 0.0, 0.0
    if LEADER in nodes:
        programme, text = _programme(options.leader)
        about["programme.yaml"] = text
        _set(parameters, LEADER, programme=programme[0])
        if options.duration is None:
            duration, settle = programme[1], LONGEST_SETTLING
    present = ",".join((*nodes, *((RECORDER,) if options.bag else ())))
    for name in (*nodes, *((RECORDER,) if options.bag else ())):
        _set(parameters, name, nodes=present, autostart=False)
    _set(parameters, SIMULATOR, duration=duration, settle=settle)
    if options.realtime:
        _set(parameters, SIMULATOR, realtime=True)
    if options.bag:
        _set(parameters, RECORDER, bag=str(options.bag))
    _check_urdf(parameters)
    about["parameters.yaml"] = _yaml({node: {_KEY: values} for node, values in parameters.items()})
    return RunPlan(options, nodes, parameters, ros_args, about)


def _set(parameters: Parameters, node: str, **values: Any) -> None:
    parameters.setdefault(node, {}).update(values)


def _programme(name: str) -> tuple[tuple[str, float], str]:
    """Name or absolute path with the duration [s], and the text."""
    from follower_humanoid.leader.programme import BUILT_IN, load_programme

    duration = load_programme(name).duration
    path = share_path(f"config/programmes/{name}.yaml") if name in BUILT_IN else Path(name).absolute()
    return (name if name in BUILT_IN else str(path), duration), path.read_text(encoding="utf-8")


def _parameters(
    files: Sequence[Path], assignments: Sequence[tuple[str, str, str]], namespace: str
) -> Parameters:
    """The package's file, the user's files over it, then single assignments."""
    base = share_path("config/follower.yaml")
    if not files and not assignments and (unchecked := _unchecked(base)) is not None:
        return unchecked
    # Imports every component for its configuration: only where there is something to check.
    from follower_humanoid.graph.config_file import load_parameters
    from follower_humanoid.graph.node_configs import node_names, node_parameters

    with quiet_stderr():  # a physics engine introduces itself when it is imported
        for node in NODES.values():
            node.component_class()
    parameters = load_parameters([base, *files], namespace)
    for target, name, text in assignments:
        known = {n: node_parameters(n) for n in ([target] if target else node_names())}
        having = {n: infos[name] for n, infos in known.items() if name in infos}
        if not having:
            raise UnknownNameError("parameter", name, {v for infos in known.values() for v in infos})
        value = _value(text)
        for n, info in having.items():
            _set(parameters, n, **{name: info.checked(value, "--ros-args -p")})
    return {node: {name: _plain(v) for name, v in values.items()} for node, values in parameters.items()}


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _unchecked(path: Path) -> Parameters | None:
    """The package's own file, which a test holds equal to the dataclasses; None if it looks otherwise."""
    content = read_yaml(path)
    try:
        common = content["/**"][_KEY]
        return {node: {**common, **content.get(node, {}).get(_KEY, {})} for node in (*NODES, RECORDER)}
    except (AttributeError, KeyError, TypeError):
        return None


def _split_parameters(
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
        if node and node not in (*NODES, ARM_TASK.name, RECORDER):
            raise UnknownNameError("node in --ros-args", node, (*NODES, RECORDER))
        assignments.append((node, own, text))
    return tuple(rest), files, assignments


def _value(text: str) -> Any:
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        return text


def _check_urdf(parameters: Parameters) -> None:
    for path in sorted({values["urdf"] for values in parameters.values() if values.get("urdf")}):
        from follower_humanoid.robot.model import RobotModel

        with quiet_stderr():  # the parser has its own, longer words for it
            RobotModel(path)


def _spoken(options: Options) -> list[str]:
    """The options as words, without the bag: a repetition writes another one."""
    words = ["--leader", options.leader]
    if options.duration is not None:
        words += ["--duration", repr(options.duration)]
    words += [word for name in options.without for word in ("--without", name)]
    words += ["--composed"] * options.composed + ["--realtime"] * options.realtime
    words += [word for path in options.params for word in ("--params", str(path))]
    if options.namespace:
        words += ["--namespace", options.namespace]
    return [*words, *(("--ros-args", *options.ros_args) if options.ros_args else ())]


def _yaml(content: Any) -> str:
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=1000)
