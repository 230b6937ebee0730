"""From the options of bringup to what each node is told; everything is checked here, nothing started."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from follower_humanoid.core.config import build
from follower_humanoid.graph.graph_config import LEADER, RECORDER, VIEWER, RunConfig
from follower_humanoid.graph.wiring import NODES, SIMULATOR
from follower_humanoid.resources import share_path
from follower_humanoid.ros.bringup_options import NONE, Options, bag_folder
from follower_humanoid.ros.run_files import check_files
from follower_humanoid.ros.run_parameters import (
    KEY,
    Parameters,
    RunParameters,
    remapped_topics,
    run_parameters,
    split_parameters,
)
from follower_humanoid.ros.run_ticks import check_ticks

LONGEST_SETTLING = 10.0


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
        return _yaml({f"{above}/{node}": {KEY: values} for node, values in self.parameters.items()})


def make_plan(options: Options) -> RunPlan:
    """Checks everything and lays defaults, files and options over one another.

    Raises:
        ConfigurationError: Programme, parameter file or value cannot be used.
    """
    ros_args, files, assignments = split_parameters(options.ros_args)
    parameters = run_parameters((*options.params, *files), assignments, options.namespace)
    options = _with_own_values(options, parameters)
    nodes = tuple(
        name
        for name in NODES
        if name not in options.without and not (name == LEADER and options.leader == NONE)
    )
    about = {"command": shlex.join(["bringup", *_spoken(options)])}
    duration, settle = options.duration or 0.0, 0.0
    programme, text = _programme(options.leader) if options.leader != NONE else (("", 0.0), "")
    if LEADER in nodes:
        about["programme.yaml"] = text
        parameters.set(LEADER, programme=programme[0])
        if options.duration is None:
            duration, settle = programme[1], LONGEST_SETTLING
    if options.duration is None:  # an option wins over a file, a file over what follows from the programme
        own = parameters.own.get(SIMULATOR, {})
        if "duration" in own:
            duration, settle = own["duration"], 0.0
        settle = own.get("settle", settle)
    build(RunConfig, {"duration": duration, "settle": settle}, SIMULATOR)  # within their ranges?
    told = (*nodes, *((RECORDER,) if options.bag else ()))
    set_by = [*map(str, (*options.params, *files)), *(["--ros-args -p"] if assignments else [])]
    check_ticks(parameters.all, told, ", ".join(set_by) or "config/follower.yaml")
    present = ",".join(told)
    for name in told:
        parameters.set(name, nodes=present, autostart=False)
        if remapped := remapped_topics(ros_args):  # a filter may have come between: nodes go by the names
            parameters.set(name, by_topic=",".join(remapped))
    if options.view:  # an observer: nobody waits for it, it starts itself
        parameters.set(VIEWER, nodes=present)
    parameters.set(SIMULATOR, duration=duration, settle=settle)
    if options.realtime:
        parameters.set(SIMULATOR, realtime=True)
    if options.bag:
        parameters.set(RECORDER, bag=str(options.bag))
    check_files(parameters.all)
    sequence = parameters.all.get("motion_composition", {}).get("sequence")
    if sequence:  # a repetition does not follow paths
        about["sequence.yaml"] = Path(sequence).read_text(encoding="utf-8")
    about["parameters.yaml"] = _yaml({node: {KEY: values} for node, values in parameters.all.items()})
    return RunPlan(options, nodes, parameters.all, ros_args, about)


def _with_own_values(options: Options, parameters: RunParameters) -> Options:
    """The options; where one was left out, what the user's parameters say in its place."""
    programme = parameters.own.get(LEADER, {}).get("programme")
    if programme and "leader" not in options.given:
        options = replace(options, leader=programme)
    bag = parameters.own.get(RECORDER, {}).get("bag")
    if bag and "bag" not in options.given:
        options = replace(options, bag=bag_folder(bag, "recorder: bag"))
    return options


def _programme(name: str) -> tuple[tuple[str, float], str]:
    """Name or absolute path with the duration [s], and the text."""
    from follower_humanoid.leader.programme import BUILT_IN, load_programme

    duration = load_programme(name, NONE).duration  # which is no word for the leader itself
    path = share_path(f"config/programmes/{name}.yaml") if name in BUILT_IN else Path(name).absolute()
    return (name if name in BUILT_IN else str(path), duration), path.read_text(encoding="utf-8")


def _spoken(options: Options) -> list[str]:
    """The options as words, without the bag: a repetition writes another one."""
    words = ["--leader", options.leader]
    if options.duration is not None:
        words += ["--duration", repr(options.duration)]
    words += [word for name in options.without for word in ("--without", name)]
    words += [f"--{word}" for word in ("composed", "realtime", "open", "view") if getattr(options, word)]
    words += [word for path in options.params for word in ("--params", str(path))]
    if options.namespace:
        words += ["--namespace", options.namespace]
    return [*words, *(("--ros-args", *options.ros_args) if options.ros_args else ())]


def _yaml(content: Any) -> str:
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=1000)
