"""A reset of the running graph while one of its nodes hangs."""

from __future__ import annotations

import os
import signal

import pytest
from graph_bench import RESET, bringup, run_script, wait_until


@pytest.mark.timeout(900)
def test_in_real_time_a_reset_goes_on_without_a_node_that_hangs(tmp_path):
    with bringup(tmp_path, "--realtime", "--leader", "none", "--bag", "none") as running:
        running.wait_until_it_runs()
        os.kill(running.child("gait_mapping"), signal.SIGSTOP)
        assert wait_until(lambda: "gait_mapping" in running.complained)  # the run goes on without it
        run_script(RESET, running.environment)
        assert wait_until(lambda: "the reset goes on without" in running.complained)
        running.wait_until_time(running.time + 1.0)
        running.end()
        assert running.process.returncode == 0, running.complained
