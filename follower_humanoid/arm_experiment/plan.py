"""From the command line of `arm_experiment` to what each node is told; nothing is started here."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace

from follower_humanoid.arm_experiment.checks import check_experiment
from follower_humanoid.arm_experiment.experiments import EXPERIMENTS, Experiment, experiment
from follower_humanoid.command_line import Parser, positive, split_ros_args
from follower_humanoid.graph.graph_config import LEADER, RECORDER
from follower_humanoid.graph.wiring import ARM_TASK, NODES
from follower_humanoid.ros.bringup_options import NONE, parse
from follower_humanoid.ros.run_plan import RunPlan, make_plan

PROGRAM = "arm_experiment"


def _parser() -> Parser:
    parser = Parser(
        prog=PROGRAM,
        description="One arm on a fixed trunk: writes on an elastic board, or goes to a target and lets "
        "itself be led on the way. The run is recorded.",
        epilog="Exit status: 0 the run ended, 2 bad usage, 1 anything else. "
        "What follows --ros-args goes to every node.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("experiment", metavar="|".join(EXPERIMENTS), help="which experiment")
    seconds = "simulated seconds (default: what the experiment takes)"
    add("--duration", type=positive, metavar="S", help=seconds)
    add("--bag", metavar="DIR|none", help="folder of the recorded run (default: bags/<date-time>)")
    add("--realtime", action="store_true", help="not faster than real time")
    add("--params", action="append", default=[], metavar="FILE", help="ROS 2 parameter file; repeatable")
    return parser


def make_arm_plan(args: Sequence[str]) -> RunPlan:
    """Reads the command line and checks everything.

    Raises:
        ConfigurationError: An option, a parameter or the task itself cannot be used.
    """
    own, ros_args = split_ros_args(args)
    given = _parser().parse_args(own)
    chosen = experiment(given.experiment)
    words = ["--leader", str(chosen.programme_file or NONE), "--params", str(chosen.parameter_file)]
    words += ["--duration", repr(chosen.duration if given.duration is None else given.duration)]
    words += ["--bag", given.bag] if given.bag is not None else []
    words += ["--realtime"] if given.realtime else []
    words += [word for path in given.params for word in ("--params", path)]
    words += [word for name in NODES if name not in (*chosen.nodes, LEADER) for word in ("--without", name)]
    plan = make_plan(parse([*words, *(("--ros-args", *ros_args) if ros_args else ())]))
    check_experiment(plan.parameters, plan.parameters["simulator"].get("urdf", ""))
    return _with_task(plan, chosen, shlex.join([PROGRAM, *args]))


def _with_task(plan: RunPlan, chosen: Experiment, command: str) -> RunPlan:
    """Adds the node that says where the hand shall go."""
    nodes = (*plan.nodes, ARM_TASK.name)
    recorder = (RECORDER,) if plan.options.bag else ()
    present = ",".join((*nodes, *recorder))
    parameters = {node: dict(values) for node, values in plan.parameters.items()}
    for node in (*nodes, *recorder):
        parameters[node].update(nodes=present, autostart=False)
    about = {**plan.about, "command": command, "experiment": chosen.name}
    return replace(plan, nodes=nodes, parameters=parameters, about=about)
