"""The chain without ROS: who reads what, which tick's message is used when, the same bits every time."""

from __future__ import annotations

import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from follower_humanoid.core.topics import READERS, TOPICS
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.record import RunRecorder
from follower_humanoid.graph.simulate import TICK, Chain, simulate
from follower_humanoid.graph.wiring import NODES, PRODUCER, SIMULATOR, WIRING, node_wiring, used_tick

every_node = pytest.mark.parametrize("node", WIRING, ids=lambda node: node.name)
SLOW = {"leader/left_hand/wrench": 5, "gait": 5}
SHORT = 0.12


@every_node
def test_no_node_reads_what_the_contract_forbids(node: Any) -> None:
    for topic in node.inputs.values():
        allowed = READERS.get(topic)
        assert allowed is None or node.name in allowed, f"{node.name} must not read {topic}"


def test_what_only_the_plant_knows_is_read_by_nobody_of_the_chain() -> None:
    private = {"left_hand/applied", "right_hand/applied", "base/applied"}
    assert private.isdisjoint(topic for node in WIRING for topic in node.inputs.values())
    led = {"leader/left_hand/wrench", "leader/right_hand/wrench", "base/push"}
    assert {node.name for node in WIRING if led & set(node.inputs.values())} == {SIMULATOR}


def test_whoever_may_read_is_a_node() -> None:
    assert {reader for readers in READERS.values() for reader in readers} <= set(NODES)
    assert set(READERS) <= set(TOPICS)


@every_node
def test_inputs_and_outputs_are_those_of_the_component(node: Any) -> None:
    component = node.component_class()
    assert set(node.inputs) <= set(component.Inputs.__match_args__)
    # What this graph does not wire must have a default.
    component.Inputs(**dict.fromkeys(node.inputs))
    assert set(component.Outputs.__match_args__) == set(node.outputs)
    assert set(node.inputs.values()) | set(node.outputs.values()) <= set(TOPICS)


def test_no_topic_has_two_producers() -> None:
    produced = [topic for node in WIRING for topic in node.outputs.values()]
    assert len(produced) == len(set(produced))
    assert set(produced) <= set(TOPICS)
    read = {topic for node in WIRING for topic in node.inputs.values()}
    assert read <= set(produced)


@pytest.mark.parametrize(
    "topic", ["joint_states", "odom", "left_foot/wrench", "legs/command", "arms/command"]
)
def test_state_and_commands_are_used_at_their_own_tick(topic: str) -> None:
    assert [used_tick(tick, topic) for tick in (0, 1, 7)] == [0, 1, 7]


@pytest.mark.parametrize(
    "topic", ["left_hand/wrench", "motion/reference", "balance/reference", "zmp_reference"]
)
def test_what_is_computed_at_a_tick_is_used_from_the_next(topic: str) -> None:
    assert [used_tick(tick, topic) for tick in (0, 1, 7)] == [-1, 0, 6]


@pytest.mark.parametrize("topic", SLOW)
def test_slow_nodes_are_used_from_their_next_period(topic: str) -> None:
    period = SLOW[topic]
    assert PRODUCER[topic].period == period
    for tick in range(40):
        used = used_tick(tick, topic)
        assert used % period == 0
        assert period <= tick - used < 2 * period
        assert (used < 0) == (tick < period)


def test_unknown_names_are_refused_with_the_valid_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"no topic 'gate'; valid: .*gait"):
        used_tick(3, "gate")
    with pytest.raises(UnknownNameError, match=r"no node 'legs'; valid: .*leg_controller"):
        node_wiring("legs")


class Watch:
    """Notes for each node what it was given and when."""

    def __init__(self, chain: Chain) -> None:
        self.seen: dict[str, list[tuple[int, Any]]] = {node.name: [] for node in chain.nodes}
        for node in chain.nodes:
            if node.name != SIMULATOR:
                self._wrap(chain, node.name)

    def _wrap(self, chain: Chain, name: str) -> None:
        component = chain.components[name]
        original = component.step

        def step(inputs: Any, time: float) -> Any:
            assert time == chain.tick * chain.tick_length
            self.seen[name].append((chain.tick, inputs))
            return original(inputs, time)

        component.step = step


@pytest.fixture(scope="module")
def watched() -> Any:
    chain = Chain({"leader": {"programme": "fig4"}})
    watch = Watch(chain)
    for _ in range(round(SHORT / chain.tick_length)):
        chain.advance()
    run = chain.finish()
    chain.close()
    return watch, run


def test_each_node_is_stepped_in_its_period_with_the_samples_of_the_rule(watched: Any) -> None:
    watch, run = watched
    for node in WIRING:
        if node.name == SIMULATOR:
            continue
        ticks = [tick for tick, _ in watch.seen[node.name]]
        assert ticks == list(range(0, round(SHORT / run.tick), node.period))
        for tick, inputs in watch.seen[node.name]:
            for field, topic in node.inputs.items():
                given = getattr(inputs, field)
                used = used_tick(tick, topic)
                series = run[topic]
                if given is None:
                    assert used < 0 or used not in series.ticks
                elif series.fields:
                    row = int(np.flatnonzero(series.ticks == used)[0])
                    for name, values in series.fields.items():
                        np.testing.assert_array_equal(values[row], getattr(given, name))


def test_the_same_run_twice_has_the_same_bits(watched: Any) -> None:
    _, run = watched
    again = simulate("fig4", SHORT)
    assert again.joint_hash() == run.joint_hash()
    for topic in run:
        for name, values in run[topic].fields.items():
            np.testing.assert_array_equal(again[topic].fields[name], values, err_msg=f"{topic} {name}")


def test_interference_flows_on_in_place_of_the_sample() -> None:
    hashes = []
    for change in (False, True):

        def meddle(topic: str, tick: int, sample: Any, change: bool = change) -> Any:
            return None if change and topic == "balance/reference" else sample

        run = simulate("none", 0.04, interference=meddle)
        assert ("balance/reference" in run) == (not change)
        hashes.append(run.joint_hash())
    assert hashes[0] != hashes[1]


def test_a_node_left_out_leaves_its_topics_empty() -> None:
    chain = Chain(without=("leader", "gait_mapping"))
    for _ in range(10):
        chain.advance()
    run = chain.finish()
    chain.close()
    assert "gait" not in run
    assert "leader/left_hand/wrench" not in run
    assert len(run["joint_states"]) == 10
    np.testing.assert_array_equal(run["left_hand/applied"].force, np.zeros((10, 3)))


def test_bad_parameters_are_refused_before_anything_runs() -> None:
    with pytest.raises(UnknownNameError, match="zmp_balance"):
        simulate("none", 0.01, {"zmp_balance": {"dcm.gain": 3.0}})
    with pytest.raises(ConfigurationError, match=r"zmp_balance: dcm\.proportional = -1.*valid: 0"):
        simulate("none", 0.01, {"zmp_balance": {"dcm.proportional": -1.0}})
    with pytest.raises(ConfigurationError):
        simulate("no_such_programme", 0.01)


BAD = {
    "node": ({"parameters": {"zmp_balanc": {}}}, r"no node 'zmp_balanc'; valid: arm_.*zmp_balance"),
    "node of an experiment": ({"parameters": {"arm_task": {}}}, "no node 'arm_task'; valid: arm_controller"),
    "dotted": ({"parameters": {"zmp_balance.law": "paper"}}, r"no node 'zmp_balance\.law'; valid: "),
    "no mapping": (
        {"parameters": {"zmp_balance": "paper"}},
        "parameters: zmp_balance = 'paper': needs a mapping of parameter names to values",
    ),
    "no name": (
        {"parameters": {"zmp_balance": {3: "paper"}}},
        "zmp_balance: no parameter '3'; valid: .*law",
    ),
    "no mapping at all": ({"parameters": ["zmp_balance"]}, "parameters = .*: needs a mapping of nodes to"),
    "last node": ({"parameters": {"arm_controller": {"mode": "soft"}}}, "arm_controller: mode = 'soft'"),
    "leader": ({"leader": None}, "leader = None: valid: the name of a force programme, none, or"),
    "leader empty": ({"leader": ""}, "not a file"),
    "leader that is none": ({"leader": "fig6"}, "no force programme 'fig6'; valid: fig4, fig5, or"),
    "duration negative": ({"duration": -1.0}, r"duration = -1\.0: valid: .*0\.002 to 1e\+07 s"),
    "duration zero": ({"duration": 0}, r"duration = 0: valid: 0\.002 to"),
    "duration below a tick": ({"duration": 0.0009}, r"duration = 0\.0009: valid: 0\.002 to"),
    "duration nan": ({"duration": float("nan")}, "duration = nan: valid: "),
    "duration endless": ({"duration": float("inf")}, "duration = inf: valid: "),
    "duration a text": ({"duration": "22"}, "duration = '22': valid: "),
    "tick": ({"tick": 0.0}, r"tick = 0\.0: valid: 0\.001 to 0\.02 s"),
    "tick of no steps": ({"tick": 0.0015}, r"physics_step = 0\.001 s: the control tick of 0\.0015 s must be"),
    "tick a text": ({"tick": "fast"}, "tick = 'fast': needs a number"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_simulated_is_refused_before_there_is_a_world(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("follower_humanoid.plant.simulator.World", None)
    arguments, told = BAD[case]
    with pytest.raises(ConfigurationError, match=told):
        simulate(**{"leader": "none", "duration": 0.01, **arguments})


def test_nodes_that_a_chain_does_not_have_are_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"without: no node 'ledaer'; valid: .*leader"):
        Chain(without=("ledaer",))
    with pytest.raises(UnknownNameError, match=r"more: no node 'arm_tasks'; valid: arm_task$"):
        Chain(more=("arm_tasks",))
    with pytest.raises(ConfigurationError, match="without = 'leader': needs a tuple of names, of leader, "):
        Chain(without="leader")  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match=r"'simulator' \(nothing moves without it\); valid: arm_"):
        Chain(without=("simulator",))
    # Parameters of a node that is left out do no harm: what is simulated again has them too.
    chain = Chain({"leader": {"programme": "fig5"}}, without=("leader", "arm_task"))
    try:
        with pytest.raises(UnknownNameError, match=r"no node 'legs'; valid: .*leg_controller"):
            chain.adjust("legs", {})
    finally:
        chain.close()


def test_a_programme_may_be_a_path(tmp_path: Path) -> None:
    file = tmp_path / "pull.yaml"
    file.write_text("- {until: 1, left: [5, 0, 0]}")
    runs = [simulate(leader, 0.03) for leader in (file, str(file))]
    assert runs[0]["leader/left_hand/wrench"].force[0].tolist() == [5.0, 0.0, 0.0]
    assert runs[0].joint_hash() == runs[1].joint_hash()


def test_a_fall_ends_the_run() -> None:
    run = simulate("none", 1.5, {"leg_controller": {"motor.voltage_limit": 1.0}})
    assert run.duration < 1.4


class _Forgetful(RunRecorder):
    """Records nothing."""

    def __init__(self) -> None:
        super().__init__(TICK, (), "")

    def add(self, topic: str, tick: int, sample: Any) -> None:
        """Lets it go."""


class _Sample:
    """Something whose end can be seen."""


def test_samples_that_are_published_on_change_are_let_go_like_all_others() -> None:
    alive: list[weakref.ref[_Sample]] = []

    def now_and_then(topic: str, tick: int, sample: Any) -> Any:
        if topic != "footsteps":  # nobody reads them
            return sample
        if tick % 20:
            return None
        made = _Sample()
        alive.append(weakref.ref(made))
        return made

    chain = Chain(without=("leader",), interference=now_and_then)
    chain.recorder = _Forgetful()
    for _ in range(55):  # a sample is kept for two of the longest periods
        chain.advance()
    chain.close()
    assert len(alive) == 3
    assert not any(sample() for sample in alive)
