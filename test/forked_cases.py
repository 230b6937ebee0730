"""A forked process lives as a started one does; run by `test_ros_forked.py` in a process of its own."""

from __future__ import annotations

import os
import signal
import sys
import time
import types
from pathlib import Path
from types import SimpleNamespace

import pytest

from follower_humanoid.ros.crew import Crew
from follower_humanoid.ros.forked import Forked, Gate

COMMAND = ["/somewhere/python", "/somewhere/lib/leader", "--option", "two words"]


def forked(main, gate, environment=None, prepare=lambda: None):
    return Forked(COMMAND, main, environment or {}, gate, prepare)


def sleep_long():
    time.sleep(3600.0)
    return 0


class LastBreath:
    """Sends its process a signal when the interpreter takes everything down."""

    def __del__(self, kill=os.kill, process=os.getpid, number=signal.SIGTERM):
        kill(process(), number)


def handle_signals_to_the_end():
    signal.signal(signal.SIGTERM, lambda number, frame: None)
    module = sys.modules["kept_to_the_end"] = types.ModuleType("kept_to_the_end")
    module.breath = LastBreath()
    return 5


def test_a_signal_that_comes_when_all_is_done_does_not_take_the_place_of_the_status():
    gate = Gate()
    process = forked(handle_signals_to_the_end, gate)
    gate.open()
    assert process.wait() == 5


def test_status_is_what_main_returns():
    gate = Gate()
    both = [forked(lambda: 3, gate), forked(lambda: sys.exit(4), gate)]
    assert both[0].poll() is None
    gate.open()
    assert [process.wait() for process in both] == [3, 4]


def test_an_exception_is_told_and_is_a_failure(capfd):
    gate = Gate()
    process = forked(lambda: 1 // 0, gate)
    gate.open()
    assert process.wait() == 1
    assert "ZeroDivisionError" in capfd.readouterr().err


def test_it_waits_for_the_gate_and_goes_home_when_that_is_gone(tmp_path):
    gate = Gate()
    trace = tmp_path / "trace"
    process = forked(lambda: trace.touch() or 5, gate)
    time.sleep(0.2)
    assert process.poll() is None
    gate.close()
    assert process.wait() == 0
    assert not trace.exists()


def test_ps_shows_its_name_and_it_has_its_own_process_group_and_environment(tmp_path):
    gate = Gate()
    told = tmp_path / "told"

    def tell():
        told.write_text(f"{os.environ['GIVEN']} {os.getpgid(0) == os.getpid()}")
        print("dropped")
        return sleep_long()

    process = forked(tell, gate, {"GIVEN": "value"})
    gate.open()
    while not told.exists() or not told.read_text():
        time.sleep(0.01)
    try:
        words = Path(f"/proc/{process.pid}/cmdline").read_bytes().rstrip(b"\0").decode()
        assert words == " ".join(COMMAND)
        assert told.read_text() == "value True"
        assert "GIVEN" not in os.environ
    finally:
        process.kill()
        assert process.wait() == -signal.SIGKILL


def test_it_obeys_sigterm_although_its_parent_handles_it_otherwise(tmp_path):
    before = signal.signal(signal.SIGTERM, lambda number, frame: None)
    try:
        gate = Gate()
        there = tmp_path / "there"
        process = forked(lambda: there.touch() or sleep_long(), gate)
        gate.open()
        while not there.exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        assert process.wait() == -signal.SIGTERM
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.fixture
def preparation(tmp_path):
    """What to do before the gate: it goes on until it is told to end, and leaves a trace."""
    end, ended = tmp_path / "end", tmp_path / "ended"

    def prepare():
        while not end.exists():
            time.sleep(0.01)
        ended.touch()

    return SimpleNamespace(prepare=prepare, end=end.touch, ended=ended.exists)


def test_whoever_forks_knows_how_many_have_not_prepared_yet(preparation):
    gate = Gate()
    both = [forked(lambda: 0, gate, prepare=preparation.prepare), forked(lambda: 0, gate)]
    while gate.missing > 1:
        time.sleep(0.01)
    assert not preparation.ended()
    preparation.end()
    while gate.missing:
        time.sleep(0.01)
    assert preparation.ended()
    gate.open()
    assert [process.wait() for process in both] == [0, 0]


@pytest.mark.parametrize(("change", "status"), [(Gate.open, 5), (Gate.close, 0)])
def test_who_still_prepares_passes_an_open_gate_later_and_goes_home_from_one_that_is_gone(
    preparation, change, status
):
    gate = Gate()
    process = forked(lambda: 5, gate, prepare=preparation.prepare)
    change(gate)
    preparation.end()
    assert process.wait() == status


def test_a_crew_is_prepared_without_an_onlooker_that_has_died_but_not_without_others(monkeypatch):
    monkeypatch.setitem(sys.modules, "follower_humanoid.nodes.nobody", SimpleNamespace(main=lambda args: 0))
    monkeypatch.setattr("follower_humanoid.ros.crew.node_command", lambda name: COMMAND)
    for onlooker in (True, False):
        crew = Crew()
        crew.fork("nobody", [], (), aside=onlooker, prepare=lambda: os.kill(os.getpid(), signal.SIGKILL))
        crew.members[0].process.wait()
        assert crew.prepared is onlooker
        assert (crew.ended() is None) is onlooker
        crew.kill()


def test_a_crew_can_tell_how_a_process_ended_where_its_starter_ignored_that(monkeypatch):
    monkeypatch.setitem(sys.modules, "follower_humanoid.nodes.nobody", SimpleNamespace(main=lambda args: 0))
    monkeypatch.setattr("follower_humanoid.ros.crew.node_command", lambda name: COMMAND)
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        crew = Crew()
        crew.fork("nobody", [], (), prepare=lambda: os.kill(os.getpid(), signal.SIGKILL))
        assert crew.members[0].process.wait() == -signal.SIGKILL
        crew.kill()
    finally:
        signal.signal(signal.SIGCHLD, before)
