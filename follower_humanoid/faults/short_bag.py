"""A small whole bag of a standing robot, to be damaged."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

from follower_humanoid.bag.recorder import Recorded, recorded_topics
from follower_humanoid.bag.writer import About, BagWriter
from follower_humanoid.core.cdr import NANOSECONDS
from follower_humanoid.graph.record import Run, samples_of
from follower_humanoid.graph.simulate import TICK, simulate
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.codecs import Codec

_TICKS = 10
_START = 1_700_000_000 * NANOSECONDS
Damage = Callable[[bytes], bytes]


@cache
def _messages() -> list[tuple[str, int, bytes]]:
    """Topic, time [ns] and message of everything in a run of some ticks."""
    run: Run = simulate("fig4", _TICKS * TICK)
    robot = RobotModel()
    return [
        (
            name,
            round(tick * TICK * NANOSECONDS),
            Codec(name, robot).encode(sample, round(tick * TICK * NANOSECONDS)),
        )
        for name in run.series
        for tick, sample in samples_of(run[name]).items()
    ]


def short_bag(folder: Path, damage: Damage = lambda data: data) -> Path:
    """Writes the bag, its messages damaged; returns its file."""
    topics: dict[str, Recorded] = {topic.name: topic for topic in recorded_topics()}
    about = About(RobotModel().urdf, {"parameters.yaml": "{}\n"}, {"tick": repr(TICK)})
    with BagWriter(folder, about, _START) as writer:
        channels: dict[str, int] = {}
        for name, time, data in sorted(_messages(), key=lambda message: message[1]):
            if name not in topics:
                continue
            if name not in channels:
                channels[name] = writer.add_topic(f"/{name}", topics[name].type_name, [])
            writer.write(channels[name], damage(data), _START + time, _START + time)
    return next(folder.glob("*.mcap"))
