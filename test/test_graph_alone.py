"""Two robots under the same names: the second one is refused, and the first one does not notice."""

import pytest
from graph_bench import PATIENCE, beside, bringup, environment, node

OPTIONS = ("--composed", "--leader", "none", "--bag")


def test_a_second_robot_under_the_same_names_is_refused_and_starts_nothing(tmp_path):
    with bringup(tmp_path, *OPTIONS, "none") as first:
        first.wait_until_it_runs()
        with bringup(tmp_path, *OPTIONS, "second", "--duration", "0.1", env=first.environment) as second:
            assert second.wait() == 2
            assert "another robot runs in ROS domain" in second.complained
            assert "--namespace" in second.complained
            assert len(second.complained.splitlines()) == 1
        assert not (tmp_path / "second").exists()
        assert first.process.poll() is None
        first.end()
        assert first.process.returncode == 0, first.complained
        assert first.complained == ""


def test_of_two_robots_that_are_started_together_one_is_refused(tmp_path):
    more, both = ("none", "--duration", "0.1"), environment()
    args = (tmp_path, *OPTIONS, *more)
    with bringup(*args, env=both) as first, bringup(*args, env=both) as second:
        assert sorted([first.wait(), second.wait()]) == [0, 2], first.complained + second.complained
    assert "another robot runs in ROS domain" in first.complained + second.complained


@pytest.mark.parametrize("name", ["zmp_balance", "recorder"])
def test_a_name_that_a_node_started_by_hand_has_is_taken(tmp_path, name):
    with bringup(tmp_path, *OPTIONS, "bag") as first:
        first.wait_until_it_runs()
        with beside(node(name, first.environment)) as by_hand:
            assert by_hand.wait(PATIENCE) == 2
        assert first.process.poll() is None, first.complained


def test_a_second_robot_under_a_namespace_of_its_own_is_welcome(tmp_path):
    with bringup(tmp_path, *OPTIONS, "none") as first:
        first.wait_until_it_runs()
        more = ("none", "--namespace", "other", "--duration", "0.1")
        with bringup(tmp_path, *OPTIONS, *more, env=first.environment) as second:
            assert second.wait() == 0, second.complained
        assert first.process.poll() is None, first.complained
