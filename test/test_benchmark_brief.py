"""The short form of the benchmark: every number of its scenarios must hold."""

from __future__ import annotations

import pytest

from follower_humanoid.bench.__main__ import run_scenario
from follower_humanoid.bench.scenarios import SCENARIOS, Scenario


@pytest.mark.parametrize("scenario", [s for s in SCENARIOS if s.brief], ids=lambda s: s.name)
def test_every_number_holds(scenario: Scenario) -> None:
    missed = [f"{c.what}: {c.measured}, needs {c.required}" for c in run_scenario(scenario) if not c.passed]
    assert not missed
