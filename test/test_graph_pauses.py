"""A simulator that is paused leaves nothing out, and one that is cleaned up ends the run well."""

from __future__ import annotations

import numpy as np
from graph_bench import bringup, change_state

from follower_humanoid.bag.reader import read_run

TICK_NS = 2_000_000


def test_a_pause_leaves_no_gap(tmp_path):
    bag = tmp_path / "bag"
    patient = tmp_path / "patient.yaml"
    patient.write_text("simulator: {ros__parameters: {hold_after: 10.0}}\n")
    options = ("--composed", "--leader", "none", "--realtime", "--bag", str(bag), "--params", str(patient))
    with bringup(tmp_path, *options) as running:
        running.wait_until_it_runs()
        change_state("simulator", running.environment, "deactivate")
        change_state("simulator", running.environment, "activate")
        running.wait_until_time(running.time + 1.0)
        running.end()
        assert running.process.returncode == 0, running.complained
    states = read_run(bag)["joint_states"]
    np.testing.assert_array_equal(states.stamps, TICK_NS * np.arange(len(states)))


def test_a_simulator_that_is_cleaned_up_ends_the_run_well(tmp_path):
    with bringup(tmp_path, "--composed", "--leader", "none", "--bag", "none") as running:
        running.wait_until_it_runs()
        change_state("simulator", running.environment, "deactivate", "cleanup")
        assert running.wait() == 0, running.complained
        assert running.complained == ""
