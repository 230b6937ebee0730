"""A run in which parameters were changed, simulated again: the same bits, from the tick of the change on."""

from __future__ import annotations

import dataclasses

import pytest
import yaml
from graph_bench import bringup, run_script

from follower_humanoid.bag.reader import read_run
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.record import Adjusted, Run
from follower_humanoid.graph.repeatable import repeatable
from follower_humanoid.graph.simulate import Chain
from follower_humanoid.replay.again import repeat, simulate_again

TICKS, CHANGED, BACK = 120, 40, 90
ABOUT = {"parameters.yaml": yaml.safe_dump({"arm_controller": {"ros__parameters": {"payload": 2.0}}})}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    programme = tmp_path_factory.mktemp("programme") / "pull.yaml"
    programme.write_text("- {until: 1, left: [0.0, 0.0, 8.0]}\n")
    parameters = {"leader": {"programme": str(programme)}, "arm_controller": {"payload": 2.0}}
    chain = Chain(parameters)
    try:
        for tick in range(TICKS):
            if tick == CHANGED:
                chain.adjust("arm_controller", {"mode": "gravity_compensation", "payload": 0.5})
            if tick == BACK:
                chain.adjust("arm_controller", {"mode": "impedance"})
            chain.advance()
        return dataclasses.replace(chain.finish(), about=ABOUT)
    finally:
        chain.close()


def test_it_is_identical_bit_for_bit(run):
    outcome = repeat(repeatable(run), verify=True)
    assert outcome.difference is None
    assert outcome.compared == TICKS


@pytest.mark.parametrize("shift", [None, 1])
def test_without_the_change_or_a_tick_later_it_is_another_run(run, shift):
    later = () if shift is None else (dataclasses.replace(run.adjusted[0], tick=CHANGED + shift),)
    outcome = repeat(repeatable(dataclasses.replace(run, adjusted=later)), verify=True)
    assert outcome.difference is not None
    assert outcome.difference.tick == CHANGED + 1


def test_what_was_changed_is_told(run):
    notes = repeatable(run).notes
    assert "arm_controller: mode = gravity_compensation, payload = 0.5 from 0.080 s on" in notes
    assert "arm_controller: mode = impedance from 0.180 s on" in notes


def test_a_change_that_this_version_does_not_know_is_refused(run):
    def with_change(node: str, **values: object) -> Run:
        return dataclasses.replace(run, adjusted=(Adjusted(5, node, values),))

    with pytest.raises(UnknownNameError, match="arm_controller: no adjustable parameter 'colour'; valid: "):
        repeatable(with_change("arm_controller", colour="red"))
    with pytest.raises(UnknownNameError, match="'stiffness'"):
        repeatable(with_change("arm_controller", stiffness=(1.0, 1.0, 1.0)))
    with pytest.raises(ConfigurationError, match="auto_released"):
        repeatable(with_change("arm_controller", auto_pulled=0.5))
    assert repeatable(with_change("somebody", colour="red")).adjusted == ()


SET = """
import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
rclpy.init()
node = rclpy.create_node("operator")
client = node.create_client(SetParameters, "arm_controller/set_parameters")
client.wait_for_service()
for mode in ("gravity_compensation", "auto"):
    wanted = [Parameter("mode", value=mode).to_parameter_msg()]
    asked = client.call_async(SetParameters.Request(parameters=wanted))
    rclpy.spin_until_future_complete(node, asked)
    assert asked.result().results[0].successful
    # Each change has a tick of its own. Who subscribes now hears of no tick before the change.
    heard = []
    clock = node.create_subscription(Clock, "/clock", lambda now: heard.append(now.clock), 10)
    while len(heard) < 3:
        rclpy.spin_once(node)
    node.destroy_subscription(clock)
"""


@pytest.mark.parametrize("placement", [[], ["--composed"]])
def test_parameters_set_on_the_running_graph_are_in_its_bag(tmp_path, placement, capsys):
    (tmp_path / "pull.yaml").write_text("- {until: 60, left: [0.0, 0.0, 8.0]}\n")
    bag = tmp_path / "bag"
    # Not faster than real time, and as long as it takes until somebody has found it and set them.
    options = ("--leader", "pull.yaml", "--realtime", "--bag", str(bag))
    with bringup(tmp_path, *options, *placement) as running:
        running.wait_until_it_runs()
        run_script(SET, running.environment)
        running.end()
        assert running.process.returncode == 0, running.complained
    run = read_run(bag)
    adjusted, last = run.adjusted, run["joint_states"].ticks[-1]
    assert [change.values for change in adjusted] == [{"mode": "gravity_compensation"}, {"mode": "auto"}]
    assert 0 < adjusted[0].tick < adjusted[1].tick < last
    assert simulate_again(bag, None, verify=True) == 0
    assert f"identical to the bag: joint positions of {last + 1} ticks" in capsys.readouterr().out
