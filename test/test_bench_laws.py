"""The table of ablations tells what got worse, and only that."""

from __future__ import annotations

import pytest

from follower_humanoid.bench import laws
from follower_humanoid.bench.laws import ABLATIONS, Outcome
from follower_humanoid.core.config import build
from follower_humanoid.graph.simulate import Parameters
from follower_humanoid.graph.wiring import NODES


@pytest.mark.parametrize("name", ABLATIONS)
def test_every_part_has_a_parameter_that_turns_it_off(name: str) -> None:
    for node, values in ABLATIONS[name].items():
        config = NODES[node].component_class().Config
        assert build(config, values, node) != build(config, {}, node)


def lines(monkeypatch: pytest.MonkeyPatch, without: Outcome) -> list[tuple[str, bool]]:
    usual = Outcome(errors={"error": 0.010}, margin=0.020)
    off: Parameters = {"zmp_balance": {"feedback": False}}
    monkeypatch.setattr(laws, "ABLATIONS", {"feedback off": off})
    monkeypatch.setattr(laws, "TESTS", {"walk": lambda parameters: without if parameters else usual})
    return [(check.measured, check.passed) for check in laws.ablations()]


def test_a_fall_a_larger_error_and_a_smaller_margin_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert lines(monkeypatch, Outcome(fall="falls at 2.0 s")) == [("walk: falls at 2.0 s", True)]
    worse = Outcome(errors={"error": 0.012}, margin=0.011)
    expected = "walk: error 10.0 → 12.0 mm; walk: ZMP margin 20.0 → 11.0 mm"
    assert lines(monkeypatch, worse) == [(expected, True)]


def test_what_makes_no_difference_does_not_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    for same in (
        Outcome(errors={"error": 0.0101}, margin=0.0199),
        Outcome(errors={"error": 0.001}, margin=0.1),
    ):
        assert lines(monkeypatch, same) == [("nothing", False)]
