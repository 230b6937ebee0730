"""Sequences of primitives from YAML: the package's own, one of a user, and every fault in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gait_bench import AHEAD, STAND, IdealRobot, until

from follower_humanoid.core.samples import Side
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.gait.feet import half_step_length
from follower_humanoid.gait.motion_config import CompositionConfig
from follower_humanoid.gait.primitives import Bend, Stretch
from follower_humanoid.gait.sequence import Sequence, load_sequence, primitive_name
from follower_humanoid.resources import share_path

OWN = share_path("config/sequences/half_step.yaml").read_text(encoding="utf-8")

# Two phases of each kind, a rest between two primitives, heel strike, no toe.
OTHER = """
name: march
phases:
  - name: shift
    support: double
    share: 0.2
    primitives:
      - {primitive: lean, end: 0.5, forward: 0.0, inward: 0.01}
  - name: settle
    support: double
    share: 0.2
    primitives:
      - {primitive: lean, forward: 0.02}
  - name: lift
    support: single
    share: 0.25
    primitives:
      - {primitive: bend, height: 1.2}
      - {primitive: stretch, forward: -0.15}
  - name: reach
    support: single
    share: 0.35
    primitives:
      - {primitive: incline, end: 0.9, forward: 0.08}
      - {primitive: stretch, end: 0.8}
      - {primitive: lower, start: 0.1, end: 0.98}
      - {primitive: level, end: 0.5, pitch: -0.1}
      - {primitive: level, start: 0.5, end: 0.95}
"""


def load(folder: Path, text: str) -> Sequence:
    file = folder / "sequence.yaml"
    file.write_text(text, encoding="utf-8")
    return load_sequence(str(file))


def test_the_packages_own_sequence_has_all_primitives() -> None:
    sequence = load_sequence()
    assert sequence.name == "half_step"
    words = {primitive_name(p) for phase in sequence.phases for p in phase.primitives}
    assert words == {"lean", "incline", "bend", "stretch", "lower", "level", "toe"}
    assert sum(phase.share for phase in sequence.phases) == pytest.approx(1.0)


def test_defaults_of_a_primitive_are_those_of_its_class(tmp_path: Path) -> None:
    lift = load(tmp_path, OTHER).phases[2]
    assert lift.primitives == (Bend(height=1.2), Stretch(forward=-0.15))
    assert lift.primitives[0] == Bend(start=0.0, end=1.0, height=1.2)


def test_phase_times_add_up_to_the_half_step_whatever_its_pace() -> None:
    sequence = load_sequence()
    for duration in (0.4, 0.7, 1.2, 3.1, 6.0):
        times = [sequence.phase_time(phase, duration) for phase in sequence.phases]
        assert sum(times) == pytest.approx(duration)
        assert min(times) > 0.0
    slow = [sequence.phase_time(phase, 3.1) for phase in sequence.phases]
    np.testing.assert_allclose(slow, [phase.share * 3.1 for phase in sequence.phases])


def test_a_users_sequence_walks(tmp_path: Path) -> None:
    file = tmp_path / "march.yaml"
    file.write_text(OTHER, encoding="utf-8")
    ideal = IdealRobot(config=CompositionConfig(sequence=str(file)), dt=0.02)
    outputs = ideal.run(11.5, until(6.0, AHEAD))
    seen = {name for out in outputs for name in out.primitives.names}
    assert seen == {"lean", "incline", "bend", "stretch", "lower", "level"}
    taken = [step for step in ideal.steps() if step.taken]
    assert [step.counted for step in taken] == [True, True, False]
    assert [step.side for step in taken] == [Side.RIGHT, Side.LEFT, Side.RIGHT]
    np.testing.assert_allclose([step.position[0] for step in taken], [0.4, 0.8, 0.8], atol=2e-3)
    left, right = (ideal.sole(side).translation for side in Side)
    assert half_step_length(ideal.foot(Side.LEFT), ideal.foot(Side.RIGHT)) == pytest.approx(0.0, abs=2e-3)
    assert left[1] - right[1] == pytest.approx(0.18, abs=2e-3)


LEAN = "{primitive: lean}"


def phases(double: str = LEAN, single: str = "{primitive: bend}", share: str = "0.6") -> str:
    return (
        f"phases:\n  - {{name: shift, support: double, share: 0.4, primitives: [{double}]}}\n"
        f"  - {{name: swing, support: single, share: {share}, primitives: [{single}]}}\n"
    )


FAULTS = {
    "empty": ("", "phases"),
    "not a mapping": ("- 1\n- 2\n", "phases"),
    "not YAML": ("phases: [", "not valid YAML"),
    "no phases": ("name: x\n", "phases"),
    "phases empty": ("phases: []\n", "double support"),
    "phases a text": ("phases: all\n", "phases"),
    "phase a number": ("phases: [3]\n", "phase 1"),
    "no primitives": ("phases:\n  - {name: shift, support: double, share: 0.4}\n", "phase 1"),
    "primitives empty": (phases(double=""), "phase 'shift' has no primitives"),
    "unknown support": (
        phases().replace("support: single", "support: air"),
        "phase 'swing': support = 'air'",
    ),
    "no support": (phases().replace("support: single, ", ""), "phase 'swing': support"),
    "share a text": (phases(share="most"), "phase 'swing': share = 'most'"),
    "share a truth": (phases(share="true"), "phase 'swing': share = True"),
    "share missing": (phases().replace("share: 0.6, ", ""), "phase 'swing': share"),
    "share negative": (phases(share="-0.6"), "phase 'swing': share = -0.6"),
    "share not finite": (phases(share=".nan"), "phase 'swing': share = nan"),
    "share too large": (phases(share="1.6"), "phase 'swing': share = 1.6"),
    "shares that do not add up": (phases(share="0.5"), "add up to 0.9"),
    "single before double": (
        phases()
        .replace("support: double", "support: first")
        .replace("support: single", "support: double")
        .replace("support: first", "support: single"),
        "double support, then of single",
    ),
    "single only": (
        "phases: [{name: swing, support: single, share: 1, primitives: [{primitive: lean}]}]\n",
        "double",
    ),
    "unknown primitive": (
        phases(single="{primitive: jump}"),
        "phase 'swing': no primitive 'jump'; valid: bend",
    ),
    "primitive a list": (phases(single="{primitive: [bend]}"), "phase 'swing'"),
    "unknown key": ("nam: x\n" + phases(), "yaml: no key 'nam'; valid: brisk_time, name, phases"),
    "unknown key of a phase": (phases().replace("share: 0.6", "share: 0.6, shar: 1"), "': no key 'shar'"),
    "key twice": (phases().replace("share: 0.6", "share: 0.6, share: 0.6"), "'share' is given twice"),
    "brisk time a text": ("brisk_time: soon\n" + phases(), "brisk_time = 'soon'"),
    "brisk time negative": ("brisk_time: -1\n" + phases(), "brisk_time = -1"),
    "primitive without a name": (phases(single="{height: 1.0}"), "phase 'swing': a primitive needs a name"),
    "primitive a text": (phases(single="bend"), "phase 'swing': a primitive needs a name"),
    "unknown parameter": (
        phases(single="{primitive: bend, hight: 1.0}"),
        "phase 'swing', bend: no parameter 'hight'; valid: end, height, start",
    ),
    "parameter a text": (
        phases(single="{primitive: bend, height: high}"),
        "phase 'swing', bend: height = 'high'",
    ),
    "parameter a truth": (
        phases(single="{primitive: bend, height: true}"),
        "phase 'swing', bend: height = True",
    ),
    "parameter missing": (phases(single="{primitive: bend, height: }"), "phase 'swing', bend: height = None"),
    "parameter not finite": (phases(single="{primitive: bend, height: .inf}"), "phase 'swing', bend: height"),
    "window backwards": (
        phases(single="{primitive: bend, start: 0.6, end: 0.5}"),
        "phase 'swing', bend: window",
    ),
    "window too long": (
        phases(single="{primitive: bend, end: 1.5}"),
        "phase 'swing', bend: window 0.0 to 1.5",
    ),
    "window negative": (phases(single="{primitive: bend, start: -0.1}"), "phase 'swing', bend: window -0.1"),
    "window not a number": (phases(single="{primitive: bend, end: .nan}"), "phase 'swing', bend: window"),
    "two owners of a channel": (
        phases(single="{primitive: bend, end: 0.6}, {primitive: lower, start: 0.5}"),
        "phase 'swing': bend and lower both move 'swing_height' between 0.5 and 0.6",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_is_named_in_one_line(fault: str, tmp_path: Path) -> None:
    text, words = FAULTS[fault]
    with pytest.raises(ConfigurationError) as caught:
        load(tmp_path, text)
    message = str(caught.value)
    assert words in message
    assert "sequence.yaml" in message
    assert "\n" not in message


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(ConfigurationError, match=r"no such file|not a file") as caught:
            load_sequence(str(path))
        assert str(path) in str(caught.value)
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(ConfigurationError, match=r"binary\.yaml"):
        load_sequence(str(tmp_path / "binary.yaml"))


def test_standing_needs_no_sequence() -> None:
    ideal = IdealRobot(dt=0.02)
    ideal.run(0.2, until(0.0, AHEAD, STAND))
    assert ideal.outputs[-1].primitives.names == ()
