"""The command `ros2` without a graph: help everywhere, one line for what it cannot do."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from follower_humanoid.ros2_front.handover import is_ours, real_ros2
from follower_humanoid.ros2_front.main import COMMANDS, front

MAIN = [sys.executable, "-m", "follower_humanoid.ros2_front.main"]
VERBS = [
    (command, verb.name)
    for command in COMMANDS
    if command != "run"
    for verb in importlib.import_module(f"follower_humanoid.ros2_front.{command}").VERBS
]


def script(folder: Path, text: str, name: str = "ros2") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)
    return path


def path_of(*folders: Path) -> str:
    return os.pathsep.join([*(str(folder) for folder in folders), "/usr/bin", "/bin"])


@pytest.mark.parametrize("words", [[], ["--help"], ["run", "--help"], *([c] for c in COMMANDS if c != "run")])
def test_every_command_explains_itself(words, capsys):
    assert front(words) == 0
    assert capsys.readouterr().out.startswith("usage: ros2")


@pytest.mark.parametrize(("command", "verb"), VERBS)
def test_every_verb_explains_itself(command, verb, capsys):
    with pytest.raises(SystemExit) as ended:
        front([command, verb, "--help"])
    assert ended.value.code == 0
    assert f"usage: ros2 {command} {verb}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["launch", "a", "b.py"], "ros2 launch: needs a ROS 2 installation; without one there are: run"),
        (["topic", "bw", "/zmp"], "ros2 topic bw: needs a ROS 2 installation"),
        (["topic", "pub", "/zmp"], "the following arguments are required: message_type"),
        (["topic", "list", "--wrong"], "no such argument: --wrong; valid: -h, --help"),
        (["topic", "pub", "/a", "std_msgs/msg/String", "{data: 1", "--once"], "values are no YAML"),
        (["topic", "pub", "/a", "std_msgs/msg/String", "-r", "0"], "needs a number greater than 0"),
        (["bag", "record"], "which topics?"),
        (["bag", "info"], "needs a bag"),
        (["bag", "info", "/no/such/bag"], "bag /no/such/bag does not exist"),
        (["run", "follower_humanoid"], "needs a package and an executable"),
        (["run", "--wrong"], "no such argument: --wrong"),
    ],
)
def test_bad_usage_is_told_in_one_line(words, told, capsys):
    assert front(words) == 2
    streams = capsys.readouterr()
    assert told in streams.err
    assert streams.err.count("\n") == 1
    assert streams.out == ""


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["run", "follower_humanoid", "nothing"], "no executable 'nothing' in package follower_humanoid"),
        (["run", "no_such_package", "nothing"], "no package 'no_such_package'"),
        (["topic", "pub", "/a", "no_such_msgs/msg/A"], "package no_such_msgs is not installed"),
    ],
)
def test_what_does_not_exist_is_told_in_one_line(words, told, capsys):
    assert front(words) == 1
    errors = capsys.readouterr().err
    assert told in errors
    assert errors.count("\n") == 1


def run(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*MAIN, *words], env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )


def test_run_becomes_the_executable_with_its_arguments(tmp_path):
    script(tmp_path / "lib" / "some_package", '#!/bin/sh\necho "$@"; exit 7\n', "some_node")
    path = path_of()
    prefixes = str(tmp_path)
    done = run("run", "some_package", "some_node", "--help", "a b", PATH=path, AMENT_PREFIX_PATH=prefixes)
    assert (done.returncode, done.stdout) == (7, "--help a b\n")
    words = ("run", "--prefix", "env X=1", "some_package", "some_node", "c")
    done = run(*words, PATH=path, AMENT_PREFIX_PATH=prefixes)
    assert (done.returncode, done.stdout) == (7, "c\n")


def test_run_finds_our_own_executables():
    done = run("run", "follower_humanoid", "bringup", "--leader", "no_such", PATH=path_of())
    assert done.returncode == 2
    assert "no_such" in done.stderr


def test_a_real_ros2_goes_first(tmp_path):
    script(tmp_path, '#!/bin/sh\necho "real: $@"; exit 3\n')
    done = run("launch", "some thing", PATH=path_of(tmp_path))
    assert (done.returncode, done.stdout, done.stderr) == (3, "real: launch some thing\n", "")


@pytest.mark.parametrize(
    "text",
    [
        "#!/usr/bin/python3\nfrom follower_humanoid.ros2_front.main import main\n",
        "#!/usr/bin/python3\n# EASY-INSTALL-ENTRY-SCRIPT: 'follower-humanoid','console_scripts','ros2'\n",
    ],
)
def test_copies_of_the_front_do_not_hand_over_to_each_other(tmp_path, text):
    ours = script(tmp_path / "first", text)
    assert is_ours(ours)
    assert real_ros2([str(tmp_path / "first"), str(tmp_path / "none")]) is None
    # Its interpreter may lie in a folder that is called like this package.
    shebang = "#!/home/me/follower_humanoid/.venv/bin/python3"
    other = script(tmp_path / "second", f"{shebang}\nfrom ros2cli.cli import main\n")
    assert real_ros2([str(tmp_path / "first"), str(tmp_path / "second")]) == other


def test_what_cannot_be_run_is_no_ros2(tmp_path):
    script(tmp_path / "file", "text").chmod(0o644)
    (tmp_path / "folder" / "ros2").mkdir(parents=True)
    assert real_ros2([str(tmp_path / "file"), str(tmp_path / "folder"), ""]) is None
