"""Faults tried on a running graph: each line of the table must hold, and the harness must see what fails."""

from __future__ import annotations

import pytest

from follower_humanoid.bench.__main__ import main
from follower_humanoid.faults.case import Effort
from follower_humanoid.faults.cycles import cycles
from follower_humanoid.faults.falling import in_a_graph
from follower_humanoid.faults.floods import hostile_neighbour
from follower_humanoid.faults.graph_run import graph_run
from follower_humanoid.faults.network import is_local, network
from follower_humanoid.faults.nodes import lost_nodes
from follower_humanoid.ros.transport import choose_network


def test_the_graph_is_bound_to_this_machine_and_its_participants_match():
    lines = list(network(Effort(brief=True)))
    assert [f"{line.what}: {line.measured}" for line in lines if not line.passed] == []
    assert "9 processes" in lines[0].measured or "8 processes" in lines[0].measured


@pytest.mark.parametrize("tried", [hostile_neighbour, lost_nodes, cycles])
def test_every_line_holds(tried):
    lines = list(tried(Effort(brief=True)))
    assert lines
    assert [f"{line.what}: {line.measured}" for line in lines if not line.passed] == []


def test_a_fall_and_broken_physics_end_a_graph_in_words():
    lines = list(in_a_graph())
    assert [f"{line.what}: {line.measured}" for line in lines if not line.passed] == []


def test_a_controller_is_taken_out_and_brought_back_while_the_robot_stands():
    with graph_run("--leader", "none", "--composed") as run:
        assert run.reaches(0.2), run.said
        cycle = ("deactivate", "0.2", "cleanup", "configure", "activate", "0.2")
        for name in ("leg_controller", "motion_composition"):
            done = run.operate(name, *cycle)
            assert done.returncode == 0, done.stdout + done.stderr
        assert run.operate("leg_controller", "configure").returncode == 1  # not possible while active
        assert not run.over, run.said
        run.end()
        assert run.status() == 0, run.said
        recorded = run.recorded()
    assert recorded is not None
    assert recorded.notes == ()
    assert recorded["odom"].position[-1, 2] > 0.8


@pytest.mark.parametrize(
    ("address", "local"),
    [
        ("127.0.0.1", True),
        ("239.255.0.1", True),
        ("0.0.0.0", False),
        ("192.168.1.2", False),
        ("IPv6 00", False),
    ],
)
def test_what_counts_as_reachable_from_outside(address, local):
    assert is_local(address) == local


@pytest.mark.parametrize(("open_to_others", "wanted"), [(False, None), (True, "SUBNET")])
def test_opening_is_one_explicit_choice(monkeypatch, open_to_others, wanted):
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    monkeypatch.setattr("follower_humanoid.ros.transport.os.environ", environment)
    choose_network(open_to_others)
    assert environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == wanted
    name = "open.xml" if open_to_others else "loopback.xml"
    assert environment["FASTRTPS_DEFAULT_PROFILES_FILE"].endswith(name)


def test_a_profile_of_the_users_own_stays(monkeypatch):
    environment = {"FASTDDS_DEFAULT_PROFILES_FILE": "mine.xml"}
    monkeypatch.setattr("follower_humanoid.ros.transport.os.environ", environment)
    choose_network(False)
    assert environment == {"FASTDDS_DEFAULT_PROFILES_FILE": "mine.xml"}


def test_the_table_of_faults_is_told_by_its_names(capsys):
    assert main(["--faults", "--brief", "--only", "earthquake"]) == 2
    told = capsys.readouterr().err
    assert all(
        name in told for name in ("messages", "nodes", "lifecycle", "limits", "network", "files", "soak")
    )
