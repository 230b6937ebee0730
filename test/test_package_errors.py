"""A wrong name is answered in a sentence: where, of what kind, which name, and which ones are valid."""

import pytest

from follower_humanoid.bench.disturbances import ROWS
from follower_humanoid.core.config import build
from follower_humanoid.errors import UnknownNameError
from follower_humanoid.graph.config_file import load_parameters
from follower_humanoid.graph.graph_config import RunConfig


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("node", "gate", ["simulator", "leader"]), "no node 'gate'; valid: leader, simulator"),
        (("node", "gate", ["leader"], "a.yaml"), "a.yaml: no node 'gate'; valid: leader"),
        (("node", "gate", ["leader"], "", "a gait?"), "no node 'gate' (a gait?); valid: leader"),
        (("row", "c", ["b, d", "a"]), "no row 'c'; valid: 'a', 'b, d'"),
        (("row", "c", []), "no row 'c'; valid: none"),
        (("row", "c", iter("ba")), "no row 'c'; valid: a, b"),
    ],
)
def test_a_name_comes_right_after_its_kind(arguments, told):
    assert str(UnknownNameError(*arguments)) == told


def test_names_of_the_benchmark_can_be_told_apart():
    told = str(UnknownNameError("scenario", "none", ROWS))
    listed = told.partition("valid: ")[2]
    assert sorted(listed.removeprefix("'").removesuffix("'").split("', '")) == sorted(ROWS)


def test_the_place_comes_first(tmp_path):
    with pytest.raises(UnknownNameError, match=r"^simulator: no parameter 'speed'; valid: duration"):
        build(RunConfig, {"speed": 1.0}, "simulator")
    own = tmp_path / "own.yaml"
    own.write_text("gate: {ros__parameters: {a: 1}}")
    with pytest.raises(UnknownNameError, match=r"own\.yaml: no node 'gate'; valid: arm_controller, "):
        load_parameters([own])
    own.write_text("simulator: {ros__parameters: {gravity: 1}}")
    with pytest.raises(UnknownNameError, match=r"own\.yaml: simulator: no parameter 'gravity'; valid: "):
        load_parameters([own])
