"""Steps are what the feet did."""

from __future__ import annotations

import numpy as np
import pytest
from report_run import SWINGS, walking

from follower_humanoid.graph.record import Run
from follower_humanoid.pictures.body import Body
from follower_humanoid.pictures.steps import COLUMNS, find_steps, table_rows
from follower_humanoid.pictures.style import views
from follower_humanoid.pictures.table import text_table


@pytest.fixture(scope="module")
def run() -> Run:
    return walking()


def test_each_swing_is_one_step_and_a_bounce_is_none(run: Run) -> None:
    steps = find_steps(run, Body(run))
    assert [step.side for step in steps] == [side for side, *_ in SWINGS]
    np.testing.assert_allclose([step.lift_off for step in steps], [1.0, 3.0, 5.0], atol=0.011)
    np.testing.assert_allclose([step.landing for step in steps], [2.0, 4.0, 6.0], atol=0.011)


def test_lengths_are_between_the_soles(run: Run) -> None:
    steps = find_steps(run, Body(run))
    np.testing.assert_allclose([step.length for step in steps], [0.4, 0.4, 0.0], atol=1e-9)
    np.testing.assert_allclose([step.width for step in steps], [-0.18, 0.18, -0.18], atol=1e-9)
    np.testing.assert_allclose([step.heading for step in steps], 0.0, atol=1e-9)


def test_a_closing_step_is_not_counted(run: Run) -> None:
    assert [step.counted for step in find_steps(run, Body(run))] == [True, True, False]
    bare = walking(without=("footsteps", "primitives"))
    assert [step.counted for step in find_steps(bare, Body(bare))] == [True, True, False]


def test_a_step_lasts_from_the_first_shift_of_weight(run: Run) -> None:
    # The primitives begin half a second before each lift-off.
    np.testing.assert_allclose([step.duration for step in find_steps(run, Body(run))], 1.5, atol=0.03)


def test_the_table_numbers_counted_steps(run: Run) -> None:
    rows = table_rows(find_steps(run, Body(run)))
    assert [row[0] for row in rows] == ["1", "2", "–"]
    assert all(len(row) == len(COLUMNS) for row in rows)


def test_a_run_without_steps_says_so_instead_of_an_empty_table(run: Run) -> None:
    standing = walking(until=0.9)
    assert text_table(views([("standing", standing)])) == "no half-steps"
    assert len(text_table(views([("walk", run)])).splitlines()) == 1 + 3
