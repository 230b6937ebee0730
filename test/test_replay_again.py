"""A recorded run simulated again: identical bit for bit, or the first difference is named."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.record import Run
from follower_humanoid.graph.repeatable import repeatable
from follower_humanoid.graph.resimulate import samples_of
from follower_humanoid.graph.simulate import simulate
from follower_humanoid.replay.again import repeat

TICKS = 150
PARAMETERS: dict[str, dict[str, Any]] = {"simulator": {"ground.friction": 0.7}}
PROGRAMME = """
- {until: 0.1, left: [4.0, 1.0, 0.0], base: [0.0, 3.0, 0.0]}
- {until: 0.5, right: [6.0, 0.0, 1.0]}
"""


def about(parameters: dict[str, dict[str, Any]]) -> dict[str, str]:
    """As bringup writes it: with parameters of the graph among the component's own."""
    blocks = {name: {"ros__parameters": {"tick": 0.002, **values}} for name, values in parameters.items()}
    return {"parameters.yaml": yaml.safe_dump(blocks)}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    programme = tmp_path_factory.mktemp("programme") / "pull.yaml"
    programme.write_text(PROGRAMME)
    made = simulate(str(programme), TICKS * 0.002, PARAMETERS)
    return dataclasses.replace(made, about=about(PARAMETERS))


def changed(run: Run, topic: str, name: str, row: int, value: Any) -> Run:
    series = run[topic]
    values = series.fields[name].copy()
    values[row] = value
    altered = dataclasses.replace(series, fields={**series.fields, name: values})
    return dataclasses.replace(run, series={**run.series, topic: altered})


def test_the_same_again(run):
    outcome = repeat(repeatable(run), verify=True)
    assert outcome.difference is None
    assert outcome.compared == outcome.ticks == TICKS
    assert outcome.digest == run.joint_hash()


def test_another_wrench_is_found_out_in_the_tick_after_it(run):
    force = run["left_hand/applied"].force[40] + np.array([0.0, 0.0, 1e-9])
    outcome = repeat(repeatable(changed(run, "left_hand/applied", "force", 40, force)), verify=True)
    assert outcome.difference is not None
    assert outcome.difference.tick in (40, 41)


def test_the_last_bit_of_one_joint_is_found_and_named(run):
    position = run["joint_states"].position[30].copy()
    position[7] = np.nextafter(position[7], 1.0)
    outcome = repeat(repeatable(changed(run, "joint_states", "position", 30, position)), verify=True)
    difference = outcome.difference
    assert difference is not None
    assert (difference.tick, difference.joint, difference.joints) == (30, run.joint_names[7], 1)
    assert f"tick 30 (0.060 s), joint {run.joint_names[7]}" in str(difference)


def test_another_parameter_makes_a_difference(run):
    other = dataclasses.replace(run, about=about({"simulator": {"motors.resistance": 0.7}}))
    outcome = repeat(repeatable(other), verify=True)
    assert outcome.difference is not None


def test_a_whole_run_is_simulated_where_nothing_is_compared(run):
    other = dataclasses.replace(run, about=about({"simulator": {"motors.resistance": 0.7}}))
    outcome = repeat(repeatable(other), verify=False)
    assert outcome.ticks == TICKS
    assert outcome.digest != run.joint_hash()


def test_joints_in_another_order_are_compared_by_name(run):
    states = run["joint_states"]
    fields = {name: values[:, ::-1] for name, values in states.fields.items()}
    series = {**run.series, "joint_states": dataclasses.replace(states, fields=fields)}
    turned = dataclasses.replace(run, series=series, joint_names=run.joint_names[::-1])
    assert repeat(repeatable(turned), verify=True).difference is None


def test_samples_are_as_they_were(run):
    wrench = samples_of(run["left_hand/applied"])[40]
    np.testing.assert_array_equal(wrench.force, run["left_hand/applied"].force[40])
    gait = samples_of(run["gait"])[20]
    assert gait.walk_speed == run["gait"].walk_speed[4]
    assert samples_of(run["support_polygon"])


def test_what_is_missing_is_named(run):
    with pytest.raises(ConfigurationError, match=r"carries no parameters.yaml"):
        repeatable(dataclasses.replace(run, about={}))
    with pytest.raises(ConfigurationError, match=r"parameters.yaml in the bag cannot be read"):
        repeatable(dataclasses.replace(run, about={"parameters.yaml": "[1, 2]"}))
    with pytest.raises(UnknownNameError, match=r"yaml in the bag: simulator: no parameter 'resistence'; v"):
        repeatable(dataclasses.replace(run, about=about({"simulator": {"resistence": 1.0}})))
    with pytest.raises(ConfigurationError, match="no URDF"):
        repeatable(dataclasses.replace(run, urdf=""))
    series = {name: values for name, values in run.series.items() if name != "base/applied"}
    with pytest.raises(ConfigurationError, match="no base/applied"):
        repeatable(dataclasses.replace(run, series=series))


def test_a_bag_that_begins_later_cannot_be_simulated_again(run):
    states = run["joint_states"]
    later = dataclasses.replace(states, ticks=states.ticks + 5, stamps=states.stamps + 10_000_000)
    with pytest.raises(ConfigurationError, match=r"begins at 0.010 s"):
        repeatable(dataclasses.replace(run, series={**run.series, "joint_states": later}))


def test_other_versions_and_missing_ticks_are_noted(run):
    applied = run["right_hand/applied"]
    fewer = dataclasses.replace(
        applied, ticks=applied.ticks[:-3], stamps=applied.stamps[:-3],
        fields={name: values[:-3] for name, values in applied.fields.items()},
    )  # fmt: skip
    texts = {**run.about, "versions.yaml": "numpy: 0.0.1\n"}
    other = dataclasses.replace(run, about=texts, series={**run.series, "right_hand/applied": fewer})
    notes = repeatable(other).notes
    assert any("recorded with numpy 0.0.1" in note for note in notes)
    assert any(f"right_hand/applied: 3 of {TICKS} ticks are missing" in note for note in notes)


def test_a_node_of_somebody_else_is_taken_from_the_bag(run):
    nodes = "simulator,wrench_sensing,motion_composition,zmp_balance,leg_controller,arm_controller"
    parameters = {"simulator": {**PARAMETERS["simulator"], "nodes": nodes}}
    recorded = repeatable(dataclasses.replace(run, about=about(parameters)))
    assert any("gait_mapping was somebody else's" in note for note in recorded.notes)
    assert repeat(recorded, verify=True).difference is None


def test_the_urdf_of_the_bag_is_used(run: Run, tmp_path: Path):
    text = run.urdf.replace("<robot", "<!-- of the bag --><robot", 1)
    assert repeat(repeatable(dataclasses.replace(run, urdf=text)), verify=True).difference is None
