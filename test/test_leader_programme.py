"""Force programmes: built-in ones, both forms, and one clear line for every fault."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.leader.leader import Leader, LeaderConfig
from follower_humanoid.leader.programme import Programme, load_programme
from follower_humanoid.robot.model import RobotModel


def written(folder: Path, text: str) -> str:
    path = folder / "programme.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def left(programme: Programme, time: float) -> list[float]:
    return list(programme.at(time).left)


def test_figure_4() -> None:
    programme = load_programme("fig4")
    assert programme.duration == 22.0
    assert left(programme, 0.0) == left(programme, 6.599) == [5, 0, -10]
    assert left(programme, 6.6) == left(programme, 15.999) == [3, 0, -10]
    assert left(programme, 16.0) == left(programme, 21.999) == [1, 0, -10]
    assert left(programme, 22.0) == left(programme, 100.0) == [0, 0, 0]
    assert list(programme.at(3.0).right) == list(programme.at(3.0).base) == [0, 0, 0]


def test_figure_5() -> None:
    programme = load_programme("fig5")
    assert programme.duration == 22.0
    assert left(programme, 1.0) == [5, 0, -10]
    assert left(programme, 6.6) == [4, 3, -10]


def test_linear_points(tmp_path: Path) -> None:
    points = "[{at: 1, right: [0, 0, 0]}, {at: 3, right: [4, -2, 0], base: [1, 0, 0]}]"
    text = f"interpolate: linear\npoints: {points}\n"
    programme = load_programme(written(tmp_path, text))
    np.testing.assert_allclose(programme.at(2.0).right, [2, -1, 0])
    np.testing.assert_allclose(programme.at(1.5).right, [1, -0.5, 0])
    np.testing.assert_allclose(programme.at(2.0).base, [0.5, 0, 0])
    for outside in (0.5, 3.0, 9.0):
        np.testing.assert_array_equal(programme.at(outside).right, np.zeros(3))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "needs a list of"),
        ("[]", "needs at least one entry"),
        ("just words", "needs a list of"),
        ("- {until: 1, lefft: [1, 0, 0]}", "entry 1: no 'lefft'; valid: until, left, right, base"),
        ("- {left: [1, 0, 0]}", "entry 1: 'until' is missing"),
        ("- {until: 2}\n- {until: 2}", "entry 2: until = 2: needs to be later than 2"),
        ("- {until: 0}", "entry 1: until = 0: needs to be after 0"),
        ("- {until: .nan}", "entry 1: until = nan: needs a finite number"),
        ("- {until: 1, left: [1, 0]}", r"entry 1: left = \[1, 0\]: needs three numbers"),
        ("- {until: 1, base: [1, 0, .inf]}", "entry 1: base = inf: needs a finite number"),
        ("- {until: 1, base: [1, 0, true]}", "entry 1: base = True: needs a number"),
        ("- {until: 1, base: 5}", "entry 1: base = 5: needs three numbers"),
        (f"- {{until: 1{'0' * 400}}}", "needs a finite number"),
        ("- 3", "entry 1: needs '{until"),
        ("interpolate: cubic\npoints: []", "interpolate = 'cubic': valid: linear"),
        ("points: []", "interpolate = None: valid: linear"),
        ("interpolate: linear", "points needs a list"),
        ("interpolate: linear\npoints: [{at: 1}]", "needs at least two points"),
        ("interpolate: linear\npoints: [{at: 1}, {until: 2}]", "point 2: no 'until'; valid: at, left"),
        ("interpolate: linear\nspeed: 2\npoints: []", "no 'speed'; valid: interpolate, points"),
        ("- {until: 1", "not valid YAML"),
        ("- {until: 1, until: 2}", "given twice"),
        ("- !!python/object/apply:os.getcwd []", "tags are not allowed"),
    ],
)
def test_faults_are_one_line_with_file_and_entry(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ConfigurationError, match=message) as caught:
        load_programme(path)
    assert "\n" not in str(caught.value)
    assert "programme.yaml" in str(caught.value)


def test_unknown_name_lists_the_built_in_ones() -> None:
    with pytest.raises(ConfigurationError, match="no force programme 'fig9'; valid: fig4, fig5, or"):
        load_programme("fig9")


def test_directory_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="not a file"):
        load_programme(str(tmp_path))


def test_leader_publishes_the_programme_in_world_axes(tmp_path: Path) -> None:
    text = "- {until: 1, left: [1, 2, 3], right: [4, 5, 6], base: [7, 8, 9]}"
    leader = Leader(LeaderConfig(written(tmp_path, text)), RobotModel(), 0.01)
    outputs = leader.step(Leader.Inputs(), 0.5)
    assert [list(w.force) for w in (outputs.leader_left, outputs.leader_right, outputs.push)] == [
        [1, 2, 3], [4, 5, 6], [7, 8, 9],
    ]  # fmt: skip
    assert all(w.frame == "world" and not w.torque.any() for w in (outputs.leader_left, outputs.push))
    assert not leader.step(Leader.Inputs(), 1.0).leader_left.force.any()
    assert leader.duration == 1.0


def test_the_wrenches_are_made_anew_only_when_they_change(tmp_path: Path) -> None:
    steps = "[{until: 1, left: [1, 0, 0]}, {until: 2, left: [2, 0, 0]}]"
    leader = Leader(LeaderConfig(written(tmp_path, steps)), RobotModel(), 0.01)
    first, same, second, after, later = (leader.step(Leader.Inputs(), time) for time in (0, 0.99, 1, 2, 9))
    assert first is same
    assert after is later
    assert [list(out.leader_left.force) for out in (same, second, after)] == [[1, 0, 0], [2, 0, 0], [0, 0, 0]]
