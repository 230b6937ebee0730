"""Programs that are stopped while they still load what they need: status 0, and not a word."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest
from graph_bench import ENDLESS

STUCK_WHILE_IMPORTING = f"""
import importlib.abc, sys, time

class Slow(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name.startswith(SLOW):
            print("importing", flush=True)
            time.sleep({ENDLESS})

sys.meta_path.insert(0, Slow())
sys.argv = ["program", *WORDS]
from follower_humanoid.nodes.PROGRAM import main
sys.exit(main())
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("program", "words", "slow"),
    [
        ("bringup", ["--bag", "none"], "follower_humanoid.ros."),
        ("bringup", ["--bag", "none"], "follower_humanoid.gait.composition"),  # where kernels are compiled
        ("arm_experiment", ["board", "--bag", "none"], "follower_humanoid.arm_experiment."),
    ],
)
def test_a_signal_while_a_program_loads_is_a_clean_stop(program, words, slow, number, tmp_path):
    text = STUCK_WHILE_IMPORTING.replace("PROGRAM", program).replace("WORDS", repr(words))
    command = [sys.executable, "-c", text.replace("SLOW", repr(slow))]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=tmp_path, text=True, **streams) as process:
        assert process.stdout.readline() == "importing\n"
        process.send_signal(number)
        assert process.communicate() == ("", "")
    assert process.returncode == 0
