"""The command line of bringup: defaults, meanings, and one clear line for whatever cannot be."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import yaml
from graph_bench import run

from follower_humanoid.command_line import split_ros_args
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph.wiring import NODES
from follower_humanoid.nodes.bringup import main
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.bringup_options import _parser, parse
from follower_humanoid.ros.launch_options import SWITCHES, WORDS, bringup_command
from follower_humanoid.ros.run_plan import make_plan


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def plan(*args):
    return make_plan(parse(args))


def test_defaults(tmp_path):
    options = parse([])
    assert (options.leader, options.duration) == ("fig4", None)
    assert not options.composed
    assert not options.realtime
    assert options.bag is not None
    assert options.bag.parent == tmp_path / "bags"
    assert not options.bag.parent.exists()


def test_default_run_is_the_programme_and_then_a_stand():
    parameters = plan().parameters
    assert parameters["leader"]["programme"] == "fig4"
    assert parameters["simulator"]["duration"] > 10.0
    assert parameters["simulator"]["settle"] == 10.0
    assert parameters["simulator"]["nodes"] == ",".join((*NODES, "recorder"))


def test_a_given_duration_cuts():
    parameters = plan("--duration", "2.5").parameters
    assert (parameters["simulator"]["duration"], parameters["simulator"]["settle"]) == (2.5, 0.0)


def test_without_a_leader_a_run_has_no_end():
    chosen = plan("--leader", "none", "--bag", "none")
    assert "leader" not in chosen.nodes
    assert chosen.parameters["simulator"]["duration"] == 0.0
    assert chosen.parameters["arm_controller"]["nodes"] == ",".join(n for n in NODES if n != "leader")


def test_nodes_can_be_left_out():
    chosen = plan("--without", "arm_controller", "--without", "gait_mapping")
    assert set(NODES) - set(chosen.nodes) == {"arm_controller", "gait_mapping"}


def test_parameter_files_are_laid_over_one_another(tmp_path):
    first = tmp_path / "first.yaml"
    first.write_text("simulator:\n  ros__parameters:\n    ground.friction: 0.7\n    body.mass_scale: 1.1\n")
    second = tmp_path / "second.yaml"
    second.write_text("/**:\n  ros__parameters:\n    ground: {friction: 0.6}\n")
    chosen = plan("--params", str(first), "--params", str(second))
    assert chosen.parameters["simulator"]["ground.friction"] == 0.6
    assert chosen.parameters["simulator"]["body.mass_scale"] == 1.1
    assert "body.mass_scale: 1.1" in chosen.about["parameters.yaml"]


def test_an_option_wins_over_a_file_and_a_file_over_defaults(tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text(
        "leader: {ros__parameters: {programme: fig5}}\n"
        "simulator: {ros__parameters: {duration: 4.0, realtime: true}}\n"
        "recorder: {ros__parameters: {bag: mine}}\n"
    )
    chosen = plan("--params", str(own))
    assert chosen.parameters["leader"]["programme"] == "fig5"
    assert chosen.about["programme.yaml"] == plan("--leader", "fig5").about["programme.yaml"]
    simulator = chosen.parameters["simulator"]
    assert (simulator["duration"], simulator["settle"], simulator["realtime"]) == (4.0, 0.0, True)
    assert chosen.options.bag == tmp_path / "mine"
    assert chosen.parameters["recorder"]["bag"] == str(tmp_path / "mine")
    words = ("--leader", "fig4", "--duration", "2", "--bag", "other")
    chosen = plan("--params", str(own), *words)
    assert chosen.parameters["leader"]["programme"] == "fig4"
    assert chosen.parameters["simulator"]["duration"] == 2.0
    assert chosen.parameters["recorder"]["bag"] == str(tmp_path / "other")
    assert plan("--ros-args", "-p", "duration:=7").parameters["simulator"]["duration"] == 7.0


@pytest.mark.parametrize("text", ["5e-1", "0.5", ".5", "+5.0e-1"])
def test_numbers_as_ros_writes_them(text):
    chosen = plan("--ros-args", "-p", f"zmp_balance:dcm.proportional:={text}")
    assert chosen.parameters["zmp_balance"]["dcm.proportional"] == 0.5


def test_ros_arguments_reach_every_node_and_parameters_are_checked_among_them():
    words = ("-p", "simulator:body.mass_scale:=1.2", "-r", "imu:=pelvis", "--log-level", "warn")
    chosen = plan("--ros-args", *words)
    assert chosen.ros_args == ("-r", "imu:=pelvis", "--log-level", "warn")
    assert chosen.parameters["simulator"]["body.mass_scale"] == 1.2
    with pytest.raises(ConfigurationError, match="mass_scale"):
        plan("--ros-args", "-p", "body.mass_scale:=nan")


def test_the_command_of_a_run_says_all_its_switches():
    command = plan("--bag", "none", "--open", "--composed", "--view", "--realtime").about["command"]
    assert set(command.split()) >= {"--open", "--composed", "--view", "--realtime"}


def test_remapped_topics_are_heard_by_name():
    assert plan("--bag", "none").parameters["zmp_balance"].get("by_topic") == ""
    rules = ("-r", "zmp_balance:odom:=filtered", "--remap", "/robot/imu:=other", "-r", "__ns:=/robot")
    told = plan("--bag", "none", "--ros-args", *rules)
    assert {values["by_topic"] for n, values in told.parameters.items() if n in NODES} == {"odom,imu"}


def test_ros_arguments_end_at_a_double_dash():
    words = ["--bag", "none", "--ros-args", "-r", "a:=b", "--", "--composed"]
    assert split_ros_args(words) == (["--bag", "none", "--composed"], ["-r", "a:=b"])


def test_parameter_file_names_nodes_in_their_namespace():
    chosen = plan("--namespace", "/robots/one", "--bag", "none")
    content = yaml.safe_load(chosen.parameter_file("robots/one"))
    assert set(content) >= {f"/robots/one/{name}" for name in NODES}


def write(text):
    Path("file.yaml").write_text(text)
    return "file.yaml"


def write_urdf_without(*frames):
    """A robot whose frames of these names have another one."""
    text = RobotModel().urdf
    for name in frames:
        text = text.replace(f'"{name}"', f'"former_{name}"')
    Path("robot.urdf").write_text(text)
    return write("/**: {ros__parameters: {urdf: robot.urdf}}")


TOO_LONG = "a" * 300  # for a file's name
PROGRAMMES = "; valid: fig4, fig5, none, or a YAML file"

BAD = {
    "option": (lambda: ["--colour", "red"], "no such argument: --colour", "--duration"),
    "abbreviation": (lambda: ["--dur", "3"], "no such argument: --dur", "--duration"),
    "word": (lambda: ["fig4"], "no such argument: fig4", "--leader"),
    "duration text": (lambda: ["--duration", "long"], "--duration", "greater than 0"),
    "duration zero": (lambda: ["--duration", "0"], "'0'", "greater than 0"),
    "duration nan": (lambda: ["--duration", "nan"], "'nan'", "greater than 0"),
    "duration beyond": (lambda: ["--duration", "1e8"], "duration = 100000000.0", "10000000.0 s"),
    "duration missing": (lambda: ["--duration"], "--duration", "expected one argument"),
    "leader": (lambda: ["--leader", "fig6"], "fig6", PROGRAMMES),
    "leader in capitals": (lambda: ["--leader", "NONE"], "no force programme 'NONE'", PROGRAMMES),
    "leader left out": (lambda: ["--leader", "fig6", "--without", "leader"], "fig6", PROGRAMMES),
    "leader too long": (lambda: ["--leader", TOO_LONG], "no force programme", PROGRAMMES),
    "leader by parameter": (lambda: ["--ros-args", "-p", "programme:=fig6"], "'fig6'", PROGRAMMES),
    "leader file": (lambda: ["--leader", write("- {until: 1, up: [1, 2, 3]}")], "up", "left"),
    "leader not yaml": (lambda: ["--leader", write("- {until: ")], "file.yaml", "YAML"),
    "switch with a value": (lambda: ["--open=yes"], "argument --open: takes no value", "'yes'"),
    "node": (lambda: ["--without", "legs"], "--without: no node 'legs'; valid: ", "gait_mapping"),
    "viewer": (lambda: ["--without", "viewer"], "'viewer' (it runs with --view only); valid: ", "leader"),
    "recorder": (lambda: ["--without", "recorder"], "'recorder' (--bag none leaves it out)", "valid: arm"),
    "nodes": (
        lambda: ["--without", "leader, gate"],
        "no node 'leader, gate' (one at a time: --without leader --without gate)",
        "valid: arm_controller, ",
    ),
    "namespace": (lambda: ["--namespace", "2 robots"], "2 robots", "letters"),
    "params missing": (lambda: ["--params", "gone.yaml"], "gone.yaml", "no such file"),
    "params node": (lambda: ["--params", write("gate: {ros__parameters: {a: 1}}")], "gate", "gait_mapping"),
    "params name": (
        lambda: ["--params", write("simulator: {ros__parameters: {gravity: 1}}")],
        "file.yaml: simulator: no parameter 'gravity'; valid: ",
        "tick",
    ),
    "params tick": (
        lambda: [
            "--params",
            write("/**/simulator: {ros__parameters: {physics_step: 0.0007}}"),
            "--ros-args",
            "-p",
            "tick:=0.0025",
        ],
        "file.yaml, --ros-args -p: simulator: physics_step = 0.0007 s: the control tick of 0.0025 s must be",
        "such as 0.000625 s",
    ),
    "params tick alone": (
        lambda: ["--ros-args", "-p", "tick:=0.0025"],
        "--ros-args -p: simulator: physics_step = 0.001 s",
        "such as 0.0008333333333333334 s",
    ),
    "params ticks": (
        lambda: ["--params", write("simulator: {ros__parameters: {tick: 0.004}}")],
        "file.yaml: simulator: tick = 0.004 s",
        "valid: one for all nodes, as the 0.002 s of the others",
    ),
    "params range": (
        lambda: ["--params", write("simulator: {ros__parameters: {ground.friction: -1}}")],
        "ground.friction = -1",
        "0.0 to 2.0",
    ),
    "params nan": (
        lambda: ["--params", write("simulator: {ros__parameters: {ground.friction: .nan}}")],
        "ground.friction = nan",
        "finite",
    ),
    "urdf": (
        lambda: ["--params", write("/**: {ros__parameters: {urdf: file.yaml}}")],
        "URDF file.yaml",
        "malformed",
    ),
    "urdf frames": (
        lambda: ["--params", write_urdf_without("l_sole", "gaze")],
        "robot.urdf has no frame gaze, l_sole",
        "base_link",
    ),
    "sequence missing": (lambda: ["--ros-args", "-p", "sequence:=gone.yaml"], "gone.yaml", "no such file"),
    "sequence": (
        lambda: ["--ros-args", "-p", f"sequence:={write('name: mine')}"], "sequence file.yaml", "phases",
    ),
    "ros integer": (lambda: ["--ros-args", "-p", f"sensors.seed:={'9' * 30}"], "sensors.seed", "±92233"),
    "ros float": (lambda: ["--ros-args", "-p", f"duration:={'9' * 400}"], "duration", "±92233"),
    "ros digits": (lambda: ["--ros-args", "-p", f"duration:={'9' * 5000}"], "duration", "digits"),
    "bag in a file": (
        lambda: ["--params", write("recorder: {ros__parameters: {bag: file.yaml}}")],
        "recorder: bag",
        "exists already",
    ),
    "ros parameter": (lambda: ["--ros-args", "-p", "gravity:=1"], "-p: no parameter 'gravity'", "tick"),
    "ros parameter of a node": (
        lambda: ["--ros-args", "-p", "leader:speed:=1"], "-p: leader: no parameter 'speed'", "programme",
    ),
    "ros node": (lambda: ["--ros-args", "-p", "gate:a:=1"], "--ros-args -p: no node 'gate'", "leader"),
    "ros parameter form": (lambda: ["--ros-args", "-p", "tick"], "tick", "NAME:=VALUE"),
    "ros remap": (lambda: ["--ros-args", "-r", "nonsense"], "nonsense", "--ros-args"),
    "bag taken": (lambda: ["--bag", str(Path("file.yaml").parent)], "exists already", "new folder"),
    "bag too long": (lambda: ["--bag", TOO_LONG], TOO_LONG, "too long"),
    "bag of nobody": (lambda: ["--bag", "~no_such_user/bag"], "~no_such_user", "home"),
    "params too long": (lambda: ["--params", TOO_LONG], TOO_LONG, "too long"),
    "bag under a file": (lambda: ["--bag", f"{write('')}/bag"], "file.yaml", "not a folder"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_usage_ends_with_status_2_and_one_line(case, capfd):
    arguments, what, valid = BAD[case]
    words = arguments()
    files = sorted(os.listdir())
    assert main(words) == 2
    said = capfd.readouterr().err
    assert said.count("\n") == 1, said
    assert what in said
    assert valid in said
    assert sorted(os.listdir()) == files  # nothing was written


def test_a_taken_bag_folder_is_left_alone(tmp_path, capfd):
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "precious").write_text("data")
    assert main(["--bag", "taken"]) == 2
    assert os.listdir("taken") == ["precious"]
    assert "taken" in capfd.readouterr().err


def test_bad_parameters_are_one_line_of_the_whole_process_too(tmp_path):
    ended = run(tmp_path, "--params", write("simulator: {ros__parameters: {ground.friction: 3}}"))
    assert ended.process.returncode == 2
    assert ended.complained.count("\n") == 1
    assert ended.said == ""
    assert "ground.friction = 3: valid: 0.0 to 2.0" in ended.complained
    assert not (tmp_path / "bags").exists()


def test_launch_arguments_are_the_options():
    words = bringup_command({"leader": "fig5", "without": "leader,imu", "composed": "true", "bag": ""})[2:]
    assert words == ["--leader", "fig5", "--without", "leader", "--without", "imu", "--composed"]
    valid = {word.lstrip("-") for word in _parser()._option_string_actions}
    assert set(WORDS) | set(SWITCHES) == valid - {"h", "help"}
