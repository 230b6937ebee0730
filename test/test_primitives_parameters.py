"""Each primitive: its target from the walking parameters; its parameters change its motion and no other."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gait_bench import AHEAD, Tick, WalkerBench, always

from follower_humanoid.core.samples import Array, Gait, Side
from follower_humanoid.gait.feet import FootPose
from follower_humanoid.gait.primitives import (
    PRIMITIVES,
    Bend,
    Incline,
    Lean,
    Level,
    Lower,
    Primitive,
    StepContext,
    Stretch,
    Toe,
)
from follower_humanoid.gait.sequence import Sequence, load_sequence, primitive_name

SECONDS = 4.6  # one half-step and part of another
MOTIONS = ("zmp", "swing_place", "swing_height", "yaw", "pitch", "swing_toe", "contacts")

# (primitive, which of its kind in the swing, parameter, new value, motion that changes)
CHANGES = [
    ("lean", 0, "forward", 0.01, "zmp"),
    ("lean", 0, "inward", 0.01, "zmp"),
    ("lean", 0, "end", 0.8, "zmp"),
    ("incline", 0, "forward", 0.06, "zmp"),
    ("incline", 0, "inward", 0.01, "zmp"),
    ("incline", 0, "start", 0.2, "zmp"),
    ("bend", 0, "height", 1.5, "swing_height"),
    ("bend", 0, "start", 0.10, "swing_height"),
    ("lower", 0, "depth", 0.004, "swing_height"),
    ("lower", 0, "end", 0.90, "swing_height"),
    ("stretch", 0, "forward", 0.02, "swing_place"),
    ("stretch", 0, "outward", 0.02, "swing_place"),
    ("stretch", 0, "end", 0.85, "swing_place"),
    ("level", 0, "pitch", 0.1, "pitch"),
    ("toe", 0, "angle", -0.3, "swing_toe"),
    ("toe", 0, "end", 0.40, "swing_toe"),
    ("toe", 1, "angle", 0.05, "swing_toe"),
]
TURNING = replace(AHEAD, walk_dir=0.15, heading=0.15)


def changed(sequence: Sequence, word: str, which: int, values: dict[str, float]) -> Sequence:
    """The sequence with one of its primitives made anew."""
    phases, seen = [], 0
    for phase in sequence.phases:
        primitives: list[Primitive] = []
        for primitive in phase.primitives:
            if primitive_name(primitive) == word:
                if seen == which:
                    primitive = replace(primitive, **values)
                seen += 1
            primitives.append(primitive)
        phases.append(replace(phase, primitives=tuple(primitives)))
    return replace(sequence, phases=tuple(phases))


def motions(ticks: list[Tick]) -> dict[str, Array]:
    swing = np.array([tick.place[Side.RIGHT] for tick in ticks] + [tick.place[Side.LEFT] for tick in ticks])
    return {
        "zmp": np.array([tick.zmp for tick in ticks]),
        "swing_place": swing[:, :2],
        "swing_height": swing[:, 2],
        "yaw": swing[:, 3],
        "pitch": swing[:, 4],
        "swing_toe": np.array([tick.toe for tick in ticks]),
        "contacts": np.array([[tick.shares[side] for side in Side] for tick in ticks]),
    }


def walked(sequence: Sequence) -> dict[str, Array]:
    bench = WalkerBench(sequence=sequence)
    return motions(bench.run(SECONDS, always(TURNING)))


@cache
def unchanged() -> dict[str, Array]:
    return walked(load_sequence())


def test_every_primitive_with_a_parameter_is_tried() -> None:
    own = {
        (word, field.name)
        for word, kind in PRIMITIVES.items()
        for field in dataclasses.fields(kind)
        if field.name not in ("start", "end")
    }
    assert own <= {(word, name) for word, _, name, _, _ in CHANGES}
    assert set(PRIMITIVES) == {word for word, *_ in CHANGES}


@pytest.mark.parametrize(("word", "which", "name", "value", "motion"), CHANGES)
def test_a_parameter_of_a_primitive_changes_its_motion_and_no_other(
    word: str, which: int, name: str, value: float, motion: str
) -> None:
    after = walked(changed(load_sequence(), word, which, {name: value}))
    before = unchanged()
    for other in MOTIONS:
        if other == motion:
            assert np.abs(after[other] - before[other]).max() > 1e-3, f"{other} did not change"
        else:
            np.testing.assert_array_equal(after[other], before[other], err_msg=other)


def test_the_walking_parameter_step_height_moves_only_the_height() -> None:
    bench = WalkerBench()
    after = motions(bench.run(SECONDS, always(replace(TURNING, step_height=1.6))))
    assert after["swing_height"].max() == pytest.approx(1.6 * unchanged()["swing_height"].max())
    for motion in MOTIONS:
        if motion != "swing_height":
            np.testing.assert_array_equal(after[motion], unchanged()[motion], err_msg=motion)


CONTEXT = StepContext(
    stance=FootPose(Side.LEFT, 1.0, 0.5, 0.3, 0.02),
    landing=FootPose(Side.RIGHT, 1.4, 0.4, 0.5, 0.05),
    gait=Gait(1.0, 0.5, 1.0, 1.5, 0.5),
    swing_height=0.04,
    touchdown_load=30.0,
)


def along(yaw: float, forward: float, left: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([c * forward - s * left, s * forward + c * left])


@pytest.mark.parametrize("kind", [Lean, Incline])
def test_lean_and_incline_aim_at_the_stance_sole(kind: type[Lean | Incline]) -> None:
    # Towards the other foot is to the right of a left stance foot.
    target = kind(forward=0.05, inward=0.01).target(CONTEXT)
    np.testing.assert_allclose(target, np.array([1.0, 0.5]) + along(0.3, 0.05, -0.01))
    right = replace(CONTEXT, stance=replace(CONTEXT.stance, side=Side.RIGHT))
    np.testing.assert_allclose(
        kind(forward=0.05, inward=0.01).target(right), np.array([1.0, 0.5]) + along(0.3, 0.05, 0.01)
    )


def test_bend_lifts_over_the_higher_ground_by_step_height() -> None:
    np.testing.assert_allclose(Bend(height=1.2).target(CONTEXT), [0.05 + 1.2 * 1.5 * 0.04])


def test_lower_goes_to_the_ground_and_is_done_where_it_meets_it() -> None:
    lower = Lower(start=0.5, depth=0.01)
    np.testing.assert_allclose(lower.target(CONTEXT), [0.05 - 0.01])
    touching, brushing = 40.0, 20.0
    assert lower.finished(CONTEXT, touching, 0.8)
    assert not lower.finished(CONTEXT, brushing, 0.8)
    assert not lower.finished(CONTEXT, touching, 0.4)  # the load before it has begun is another matter


def test_stretch_reaches_the_landing_place_shifted_in_its_own_axes() -> None:
    np.testing.assert_allclose(Stretch().target(CONTEXT), [1.4, 0.4])
    target = Stretch(forward=0.03, outward=0.02).target(CONTEXT)
    np.testing.assert_allclose(target, np.array([1.4, 0.4]) + along(0.5, 0.03, -0.02))


def test_level_and_toe() -> None:
    np.testing.assert_allclose(Level(pitch=-0.1).target(CONTEXT), [0.5, -0.1])
    np.testing.assert_allclose(Toe(angle=-0.2).target(CONTEXT), [-0.2])


@pytest.mark.parametrize("word", PRIMITIVES)
def test_window_activity_completion_and_end(word: str) -> None:
    primitive = PRIMITIVES[word](start=0.2, end=0.7)
    activity = [primitive.active(p) for p in (0.0, 0.19, 0.2, 0.5, 0.69, 0.7, 1.0)]
    assert activity == [False, False, True, True, True, False, False]
    completion = [primitive.completion(p) for p in (0.0, 0.2, 0.45, 0.7, 1.0)]
    np.testing.assert_allclose(completion, [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-12)
    # Without contact only the window ends a primitive.
    assert not any(primitive.finished(CONTEXT, 0.0, p) for p in (0.0, 0.5, 1.0))
