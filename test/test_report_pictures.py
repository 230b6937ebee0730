"""The report draws what is there and says what is not."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from graph_bench import PATIENCE
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.layout_engine import ConstrainedLayoutEngine
from report_run import DURATION, SWINGS, TICK, flow, walking

from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.reader import read_run
from follower_humanoid.bag.recorder import recorded_topics
from follower_humanoid.bag.writer import About, BagWriter
from follower_humanoid.core.samples import SIDES
from follower_humanoid.graph.record import Run
from follower_humanoid.nodes import report as nodes_report
from follower_humanoid.pictures.ground import footprints
from follower_humanoid.pictures.report import PICTURES, make_report
from follower_humanoid.pictures.signals import LIMBS, limb_voltages
from follower_humanoid.pictures.style import views
from follower_humanoid.pictures.zmp import zmp_margins
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec


@pytest.fixture(scope="module")
def run() -> Run:
    return walking()


def write_as_bag(folder: Path) -> Path:
    """The made-up run as the graph's own messages."""
    robot = RobotModel()
    types = {topic.name: topic.type_name for topic in recorded_topics()}
    codecs: dict[str, Codec] = {}
    channels: dict[str, int] = {}
    with BagWriter(folder, About(robot.urdf, {}, {"tick": repr(TICK)}), 0) as writer:
        for tick in range(round(DURATION / TICK) + 1):
            now = round(tick * TICK * 1e9)
            for topic, sample in flow(robot, tick).items():
                if topic.endswith("/command"):
                    sample = type(sample)(sample.effort * 0, sample.effort * 0, sample.effort)
                if topic not in codecs:
                    codecs[topic] = Codec(topic, robot)
                    channels[topic] = writer.add_topic(f"/{topic}", types[topic], [offered_qos()])
                writer.write(channels[topic], codecs[topic].encode(sample, now), now, now)
    return folder


def ink(path: Path) -> float:
    """Share of a picture that is not white."""
    return float(np.mean(imread(path)[..., :3].min(axis=-1) < 0.9))


def test_every_picture_is_drawn(run: Run, tmp_path: Path) -> None:
    report = make_report([("walk", run)], tmp_path / "report")
    assert report.notes == ()
    for picture in PICTURES:
        assert ink(tmp_path / "report" / f"{picture.name}.png") > 0.005, picture.name
    assert (tmp_path / "report" / "report.pdf").read_bytes().count(b"/Type /Page ") == len(PICTURES)
    with (tmp_path / "report" / "steps.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["length [m]"] for row in rows] == ["0.400", "0.400", "0.000"]
    assert all(file.is_file() for file in report.files)


def test_a_figure_is_laid_out_once_for_both_files(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    laid_out: list[object] = []
    execute = ConstrainedLayoutEngine.execute

    def counted(self: ConstrainedLayoutEngine, fig: Figure) -> object:
        laid_out.append(fig)
        return execute(self, fig)

    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", counted)
    make_report([("walk", run)], tmp_path)
    assert len(laid_out) == len(set(map(id, laid_out))) == len(PICTURES)


def test_several_runs_share_the_figures(run: Run, tmp_path: Path) -> None:
    report = make_report([("first", run), ("second", run)], tmp_path)
    assert len({view.color for view in report.views}) == 2
    assert all(ink(tmp_path / f"{picture.name}.png") > 0.005 for picture in PICTURES)
    assert "second" in (tmp_path / "steps.csv").read_text()


def test_what_was_not_recorded_is_left_out_and_told(tmp_path: Path) -> None:
    bare = walking(
        without=("zmp", "legs/command", "gait", "support_polygon", "primitives", "footsteps", "com")
    )
    report = make_report([("bare", bare)], tmp_path)
    assert not (tmp_path / "zmp.png").exists()
    assert any("'zmp'" in note and "zmp not recorded" in note for note in report.notes)
    assert any("'voltages'" in note and "legs/command" in note for note in report.notes)
    assert (tmp_path / "footprints.png").exists()


def test_a_bag_of_body_motion_alone_still_gives_sticks(tmp_path: Path) -> None:
    names = set(flow(RobotModel(), 0)) - {"joint_states", "odom"}
    report = make_report([("motion", walking(without=tuple(names)))], tmp_path)
    assert [file.name for file in report.files] == ["report.html", "report.pdf", "sticks.png"]


def test_footprints_lie_where_the_soles_stood(run: Run) -> None:
    (view,) = views([("walk", run)])
    centers = {(side, round(float(outline[:, 0].min() + 0.07), 6)) for side, outline in footprints(view)}
    assert centers == {(side, 0.0) for side in SIDES} | {(side, end) for side, *_, end in SWINGS}


def test_margin_is_the_distance_to_the_edge(run: Run) -> None:
    times, margins = zmp_margins(run)
    standing = margins[times < 0.9]
    np.testing.assert_allclose(standing, 0.07, atol=1e-9)  # the heels are nearest


def test_every_joint_is_in_one_limb(run: Run) -> None:
    (view,) = views([("walk", run)])
    drawn = [limb_voltages(view, limb) for limb in LIMBS]
    assert sum(len(names) for _, names, _ in drawn) == 45
    assert all(volts.shape == (len(run["legs/command"]), len(names)) for _, names, volts in drawn)


def report(*args: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "follower_humanoid.nodes.report", *map(str, args)]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)


def test_the_executable_reports_on_a_bag(tmp_path: Path) -> None:
    bag = write_as_bag(tmp_path / "walk")
    done = report(bag)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "closing" in done.stdout
    assert (tmp_path / "walk-report" / "report.pdf").is_file()


def test_a_bag_and_memory_give_the_same_run(run: Run, tmp_path: Path) -> None:
    read = read_run(write_as_bag(tmp_path / "walk"))
    assert read.joint_hash() == run.joint_hash()
    assert set(read) == set(run)
    assert read["footsteps"].samples[0].steps[1].side is run["footsteps"].samples[0].steps[1].side


def test_a_truncated_bag_is_reported_with_a_note(tmp_path: Path) -> None:
    whole = write_as_bag(tmp_path / "walk") / "walk_0.mcap"
    part = tmp_path / "part.mcap"
    part.write_bytes(whole.read_bytes()[: whole.stat().st_size * 6 // 10])
    done = report(part, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "cut off" in done.stderr
    assert (tmp_path / "out" / "sticks.png").is_file()


def test_a_bag_that_is_too_large_for_the_memory_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object) -> Run:
        raise MemoryError

    monkeypatch.setattr(nodes_report, "read_run", refuse)
    assert nodes_report.main([str(tmp_path / "huge")]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "huge: too long for this machine's memory" in told


@pytest.mark.parametrize("what", ["nowhere", "empty", "text"])
def test_what_is_no_bag_ends_with_one_line(tmp_path: Path, what: str) -> None:
    if what != "nowhere":
        (tmp_path / what).write_bytes(b"" if what == "empty" else b"some text")
    done = report(tmp_path / what)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / f"{what}-report").exists()
