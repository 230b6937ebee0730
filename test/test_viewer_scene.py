"""What is told to the pages: all that can be seen to have moved, and nothing else."""

import dataclasses
import io
from contextlib import redirect_stdout

import numpy as np
import pytest
import viser
from report_run import walking

from follower_humanoid.core.samples import SIDES, Footstep, Side
from follower_humanoid.viewer.footprints import outlines
from follower_humanoid.viewer.moment import Moment, Trail
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.stage import Stage
from follower_humanoid.viewer.tape import Tape


class Told:
    """A scene, and what its pages are told."""

    def __init__(self, server: viser.ViserServer, stage: Stage) -> None:
        self.stage = stage
        self._server = server

    def by(self, moment: Moment, trail: Trail) -> list[tuple[str, dict]]:
        recorder = self._server.get_scene_serializer()
        known = len(recorder._messages)  # all that is there already
        self.stage.draw(moment, trail)
        told = [message for _, message in recorder._messages[known:]]
        recorder.serialize()  # ends it
        return [(message["name"], message) for message in told]


@pytest.fixture(scope="module")
def tape():
    return Tape(walking())


@pytest.fixture
def told(tape):
    with redirect_stdout(io.StringIO()):
        server = viser.ViserServer("127.0.0.1", 0, verbose=False)
        yield Told(server, Stage(server.scene, Skeleton(tape.run.urdf, tape.run.joint_names)))
        server.stop()


def crept(moment: Moment, way: float) -> Moment:
    base = moment["odom"]
    moved = dataclasses.replace(base, position=base.position + np.array([way, 0.0, 0.0]))
    return Moment(moment.time, {**moment.samples, "odom": moved})


def test_nothing_is_told_while_nothing_can_be_seen_to_move(tape, told):
    moment, trail = tape.moment(3.0), tape.trail(3.0)
    assert told.by(moment, trail)
    assert told.by(moment, trail) == []
    assert told.by(crept(moment, 0.5e-4), trail) == []
    assert told.by(crept(moment, 2e-4), trail) != []


def test_each_kind_of_copies_is_told_once_a_picture(tape, told):
    told.by(tape.moment(3.0), tape.trail(3.0))
    names = [name for name, _ in told.by(tape.moment(3.1), tape.trail(3.1))]
    assert len(names) == len(set(names))
    assert {"/world", "/world/robot/box"} <= set(names)


def test_handles_know_what_was_told(tape, told):
    told.by(tape.moment(2.0), tape.trail(2.0))
    messages = dict(told.by(tape.moment(3.1), tape.trail(3.1)))
    base = tape.moment(3.1)["odom"].position
    np.testing.assert_allclose(messages["/world"]["position"], [-base[0], -base[1], 0.0], atol=1e-9)
    np.testing.assert_allclose(told.stage.offset, messages["/world"]["position"])


@pytest.mark.parametrize("side", SIDES)
def test_footprints_lie_where_the_soles_stood(side: Side):
    sole = Skeleton().sole_outline(side)
    steps = [
        Footstep(side, np.array([0.3 * n, 0.1, 0.0]), yaw, taken=True)
        for n, yaw in enumerate((0.0, 0.7, -2.0))
    ]
    edges = outlines(sole, steps).reshape(len(steps), len(sole), 2, 3)
    for step, found in zip(steps, edges, strict=True):
        c, s = np.cos(step.yaw), np.sin(step.yaw)
        wanted = sole[:, :2] @ np.array([[c, s], [-s, c]]) + step.position[:2]
        np.testing.assert_allclose(found[:, 0, :2], wanted, atol=1e-12)
        np.testing.assert_array_equal(found[:, 1], np.roll(found[:, 0], -1, axis=0))
    assert outlines(sole, []).shape == (0, 2, 3)
