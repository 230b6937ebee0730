"""The exit status of bringup: what counts is how the run ended, not how a process did."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from graph_bench import ENDLESS, PATIENCE, beside, wait_until

from follower_humanoid.ros import crew as crew_module
from follower_humanoid.ros.bringup_run import BringupRun
from follower_humanoid.ros.crew import Crew, Member
from follower_humanoid.ros.outcome import End, Outcome, judge


def member(name, status, nodes=None):
    return Member(name, (name,) if nodes is None else nodes, SimpleNamespace(returncode=status))


def said(status, words="the run ended at 2.000 s"):
    return {"ended": words, "exit_status": str(status)}


STALLED = ["no message", "lost: legs (no sign of life)"]
REGULAR = End(Outcome.ENDED)
CASES = {
    "regular": (REGULAR, said(0), (), 0, 0, []),
    "regular without a bag": (REGULAR, said(0), (), None, 0, []),
    "fall": (REGULAR, said(3, "fell"), (), 0, 3, ["fell"]),
    "a status that is no number": (REGULAR, said("much", "fell"), (), 0, 1, ["fell"]),
    "stall": (REGULAR, said(1, "no message"), ("legs",), 0, 1, STALLED),
    "asked": (End(Outcome.ASKED), {}, (), 0, 0, []),
    "late": (End(Outcome.LATE), {}, (), None, 1, []),
    "node killed": (
        End(Outcome.LOST, member("leader", -9)), {}, (), 0, 1, ["lost: leader, killed by SIGKILL"],
    ),
    "node that ended politely": (
        End(Outcome.LOST, member("leader", 0)), {}, (), 0, 1, ["lost: leader, ended with status 0"],
    ),
    "simulator stopped by somebody": (
        End(Outcome.LOST, member("simulator", 0)), {}, (), 0, 1, ["lost: simulator, ended with status 0"],
    ),
    "composed process": (
        End(Outcome.LOST, member("composed", -11, ("leader", "simulator"))), {}, (), 0, 1,
        ["lost: composed with leader, simulator, killed by SIGSEGV"],
    ),
    "viewer": (
        End(Outcome.LOST, member("viewer", 1, ())), {}, (), 0, 1, ["lost: viewer, ended with status 1"],
    ),
    "last word heard late": (End(Outcome.LOST, member("simulator", 3)), said(3, "fell"), (), 0, 3, ["fell"]),
    "bad configuration": (End(Outcome.LOST, member("leader", 2)), {}, (), 1, 2, []),
    "recorder failed": (REGULAR, said(0), (), 1, 1, ["the bag is incomplete: recorder ended with status 1"]),
    "recorder killed after a fall": (
        REGULAR, said(3, "fell"), (), -9, 1, ["fell", "the bag is incomplete: recorder killed by SIGKILL"],
    ),
    "recorder killed at a signal": (
        End(Outcome.ASKED), {}, (), -9, 1, ["the bag is incomplete: recorder killed by SIGKILL"],
    ),
    "recorder lost": (
        End(Outcome.LOST, member("recorder", 1)), {}, (), 1, 1, ["lost: recorder, ended with status 1"],
    ),
}  # fmt: skip


def in_the_bag(latest, missed=0):
    return {"closed_at [s]": f"{latest:g}", "missed_ticks": str(missed)}


LACKING = {
    "whole": (in_the_bag(2.0), 0, []),
    "never closed, or never told": ({}, 0, []),
    "rubbish": (in_the_bag(2.0) | {"closed_at [s]": "soon"}, 0, []),
    "cut off": (in_the_bag(1.5), 1, ["the bag is incomplete: it ends at 1.500 s of 2.000 s"]),
    "with a gap": (in_the_bag(2.0, 7), 1, ["the bag is incomplete: 7 states did not arrive"]),
}


@pytest.mark.parametrize("case", LACKING)
@pytest.mark.parametrize("end", ["ended", "asked"])
def test_a_bag_without_the_end_of_the_run_is_told(case, end):
    reported, status, words = LACKING[case]
    simulator = said(0) | {"simulated_time [s]": "2"}
    if end == "asked":  # what was under way when somebody asked for the end is nobody's promise
        assert judge(End(Outcome.ASKED), simulator, (), 0, reported) == (0, [])
    else:
        assert judge(REGULAR, simulator, (), 0, reported) == (status, words)


def test_what_a_fall_came_to_is_told_before_what_its_bag_lacks():
    simulator = said(3, "fell") | {"simulated_time [s]": "2"}
    words = ["fell", "the bag is incomplete: it ends at 1.500 s of 2.000 s"]
    assert judge(REGULAR, simulator, (), 0, in_the_bag(1.5)) == (1, words)


def test_a_tick_that_broke_has_no_state_that_a_bag_could_lack():
    simulator = said(1, "the physics broke") | {"simulated_time [s]": "2"}
    assert judge(REGULAR, simulator, (), 0, in_the_bag(1.998)) == (1, ["the physics broke"])


@pytest.mark.parametrize("case", CASES)
def test_status_and_words(case):
    end, simulator, stuck, recorder, status, words = CASES[case]
    assert judge(end, simulator, stuck, recorder) == (status, words)


STUBBORN = f"import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); READY; time.sleep({ENDLESS})"


@pytest.fixture
def crew():
    """Nobody of it is left, whatever the test came to."""
    made = Crew()
    yield made
    made.kill()


def start_and_wait(crew, name, program, ready):
    """Starts a program that makes the file READY once it handles signals, and waits for that."""
    words = program.replace("READY", f"open({str(ready)!r}, 'w')")
    crew.members.append(Member(name, (), subprocess.Popen([sys.executable, "-c", words])))
    assert wait_until(ready.exists)


def test_a_signal_shortens_a_stop_that_has_begun(crew, tmp_path):
    start_and_wait(crew, "stubborn", STUBBORN, tmp_path / "ready")
    naps = []
    begin = time.monotonic()
    crew.stop(lambda: begin + (0.0 if len(naps) > 10 else ENDLESS), naps.append)
    assert len(naps) == 11
    assert crew.members[0].process.returncode == -9


def test_a_signal_leaves_less_time_than_the_end_of_a_run():
    """People who press Ctrl-C do not wait for long; a disk at the end of a run may take its time.

    How long whole graphs take to stop is measured by `benchmark --faults`.
    """

    def latest_stop(asked):
        run = SimpleNamespace(_stop=SimpleNamespace(asked=asked, asked_at=101.0))
        return BringupRun._latest_stop(run, 100.0)

    assert latest_stop(True) <= 104.0
    assert latest_stop(False) >= 110.0


def test_who_only_looks_on_is_asked_to_end_but_not_waited_for(crew, tmp_path):
    start_and_wait(crew, "onlooker", STUBBORN, tmp_path / "ready")
    crew.members[0] = dataclasses.replace(crew.members[0], vital=False)
    begin = time.monotonic()
    crew.stop(lambda: begin + ENDLESS, time.sleep, last="recorder")  # soon, or this test never ends
    assert crew.members[0].process.returncode == -9


@pytest.mark.parametrize(
    ("work", "status"),
    [
        ("time.process_time() < 1.5", 7),
        ("time.sleep(0.01) or time.monotonic() < begin + 2.0", 7),  # a little, again and again
        (f"time.sleep({ENDLESS}) is None", -9),  # soon, or this test never ends
    ],
)
def test_a_writer_is_waited_for_while_it_gets_anything_done(crew, work, status, tmp_path, monkeypatch):
    monkeypatch.setattr(crew_module, "_LONGEST_WRITING", ENDLESS)
    words = (
        "import signal, sys, time; signal.signal(signal.SIGTERM, lambda *_: done.append(1)); done = []\n"
        "READY\n"
        "while not done: time.sleep(0.01)\n"
        f"begin = time.monotonic()\nwhile {work}: pass\n"
        "sys.exit(7)"
    )
    start_and_wait(crew, "recorder", words, tmp_path / "ready")
    begin = time.monotonic()
    crew.stop(lambda: begin + 0.1, time.sleep, last="recorder")
    assert crew.members[0].process.returncode == status


FAILS_AT_THE_END = """
import sys
from follower_humanoid.ros.managed_node import ManagedNode
from follower_humanoid.ros.spin import run

class Writer(ManagedNode):
    def start(self):
        print("started", flush=True)
        if "over" in sys.argv:
            self.quit(0, "over")
    def finish(self):
        self.quit(1, "disk full")

sys.exit(run([lambda: Writer("recorder")], []))
"""


@pytest.mark.parametrize("word", ["over", "signal"])
def test_a_failure_while_closing_is_a_failure(word):
    command = [sys.executable, "-c", FAILS_AT_THE_END, word]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with beside(process):
        assert process.stdout.readline() == "started\n"
        if word == "signal":
            process.terminate()
        _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1, errors
    assert "disk full" in errors
