"""The benchmark's command line: what makes no difference is refused, and a bad end is not bad usage."""

from __future__ import annotations

import json

import pytest

from follower_humanoid.bench import __main__ as benchmark
from follower_humanoid.bench import growth, limits, speed, standard_tests
from follower_humanoid.errors import FollowerError


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--limits", "--json", "x.json"], "--json has no use with --limits"),
        (["--growth", "--json", "x.json"], "--json has no use with --growth"),
        (["--tuning", "DIR", "--json", "x.json"], "--json has no use with --tuning"),
        (["--speed", "--only", "fig. 4"], "--only has no use with --speed"),
        (["--growth", "--only", "fig. 4"], "--only has no use with --growth"),
        (["--tuning", "DIR", "--only", "fig. 4"], "--only has no use with --tuning"),
        (["--limits", "--brief"], "--brief has no use with --limits"),
        (["--robust", "--brief"], "--brief has no use with --robust"),
        (["--tuning", "DIR", "--brief"], "--brief has no use with --tuning"),
        (["--faults", "--robust"], "--faults and --robust: one at a time"),
        (["--speed", "--growth"], "--speed and --growth: one at a time"),
        (["--only", "nothing"], "no scenario 'nothing'; valid: "),
        (["--faults", "--only", "nothing"], "no scenario 'nothing'; valid: "),
        (["--limits", "--only", "nothing"], "no limit 'nothing'; valid: "),
        (["--json", "/no/such/folder/x.json"], "--json /no/such/folder/x.json: no such folder"),
        (["--speed", "--json", "/no/such/folder/x.json"], "--json /no/such/folder/x.json: no such folder"),
        (["--json", "/tmp"], "--json /tmp: is a folder, needs the name of a file"),
        (["--tuning", __file__], f"--tuning {__file__}: is not a folder"),
        (["--tuning", f"{__file__}/below"], f"--tuning {__file__}/below: {__file__} is not a folder"),
        (["--robust", "--only", "push"], "no scenario 'push'; valid: '0.5 m/s', "),
    ],
)
def test_bad_usage_is_told_in_one_line(words, told, capsys):
    assert benchmark.main(words) == 2
    streams = capsys.readouterr()
    assert streams.err.startswith(told)
    assert streams.err.count("\n") == 1
    assert streams.out == ""


@pytest.mark.parametrize("words", [["--growth"], ["--speed", "--brief"], ["--limits", "--only", "push"], []])
def test_a_run_that_ends_badly_is_not_bad_usage(words, monkeypatch, capsys):
    def end_badly(*_: object) -> None:
        raise FollowerError("one follower ended with status 3")

    monkeypatch.setattr(growth, "measure", end_badly)
    monkeypatch.setattr(speed, "measure", end_badly)
    monkeypatch.setattr(limits, "LIMITS", {"push": end_badly})
    monkeypatch.setattr(benchmark, "simulate", end_badly)
    assert benchmark.main(words) == 1
    assert capsys.readouterr().err == "one follower ended with status 3\n"


def test_a_new_folder_for_pictures_is_welcome(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(standard_tests, "STANDARD_TESTS", ())
    folder = tmp_path / "new" / "pictures"
    assert benchmark.main(["--tuning", str(folder)]) == 0
    assert folder.is_dir()
    assert capsys.readouterr() == ("", "")


def test_help_tells_the_exit_statuses(capsys):
    with pytest.raises(SystemExit, match="0"):
        benchmark.main(["--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "Exit status: 0 every number holds, 1 some do not, or a run ended badly, 2 bad usage." in told


def test_what_is_asked_for_is_run_and_written(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(benchmark, "run_graph", lambda: [])
    path = tmp_path / "table.json"
    name = benchmark.graph.NAME
    assert benchmark.main(["--brief", "--only", name, "--json", str(path)]) == 0
    assert json.loads(path.read_text()) == {name: []}
    assert "0 of 0 numbers hold" in capsys.readouterr().out
