"""What a run came to: the exit status of bringup, and the words for it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from types import MappingProxyType

from follower_humanoid.errors import BAD_CONFIGURATION
from follower_humanoid.graph.graph_config import RECORDER
from follower_humanoid.graph.wiring import SIMULATOR
from follower_humanoid.ros.crew import Member, how_it_ended
from follower_humanoid.ros.managed_node import FAILED

ENDED, EXIT_STATUS = "ended", "exit_status"
"""Under these names the simulator tells in its last diagnostics that the run is over, and how."""

SIMULATED_TIME = "simulated_time [s]"
CLOSED_AT, MISSED_TICKS = "closed_at [s]", "missed_ticks"
"""Under these the recorder tells in its last diagnostics how far the bag goes, and what it lacks before."""
_ROUNDING = 1e-6  # of times told as text [s]


class Outcome(Enum):
    """Why bringup no longer watches."""

    ASKED = auto()  # a signal
    ENDED = auto()  # the simulator has said so
    LOST = auto()  # a process went that should not
    LATE = auto()  # the graph was not ready in time


@dataclass(frozen=True)
class End:
    """The end of watching.

    Attributes:
        outcome: Why.
        member: The process that went, where one did.
    """

    outcome: Outcome
    member: Member | None = None


def judge(
    end: End,
    simulator: Mapping[str, str],
    stuck: Sequence[str] = (),
    recorder: int | None = None,
    bag: Mapping[str, str] = MappingProxyType({}),
) -> tuple[int, list[str]]:
    """Exit status and what to say, one line each. A process's status alone is no proof of a good end:
    whoever is sent a signal by somebody else ends with 0 too.

    Args:
        end: Why bringup stopped watching.
        simulator: What the simulator's last diagnostics said.
        stuck: Nodes that gave no sign of life.
        recorder: How the recorder's process ended; None without a bag.
        bag: What the recorder's last diagnostics said.
    """
    status, said = _judged(end, simulator, stuck)
    if recorder and status != BAD_CONFIGURATION and not (end.member and RECORDER in end.member.nodes):
        return FAILED, [*said, f"the bag is incomplete: recorder {how_it_ended(recorder)}"]
    if end.outcome is Outcome.ENDED and status != FAILED and (lacking := _lacking(simulator, bag)):
        return FAILED, [*said, f"the bag is incomplete: {lacking}"]
    return status, said


def _lacking(simulator: Mapping[str, str], bag: Mapping[str, str]) -> str:
    """What a bag lacks of a run: a recorder that was halted at its end may hear no more of it."""
    try:
        until, closed_at = float(simulator[SIMULATED_TIME]), float(bag[CLOSED_AT])
        missed = int(bag[MISSED_TICKS])
    except (KeyError, ValueError):  # no last word, which says nothing about the bag
        return ""
    if missed:
        return f"{missed} states did not arrive"
    return f"it ends at {closed_at:.3f} s of {until:.3f} s" if closed_at < until - _ROUNDING else ""


def _judged(end: End, simulator: Mapping[str, str], stuck: Sequence[str]) -> tuple[int, list[str]]:
    if end.outcome is Outcome.ASKED:
        return 0, []
    if end.outcome is Outcome.LATE:
        return FAILED, []  # whose lateness it was has been told
    word, member = simulator.get(ENDED, ""), end.member
    if word and (end.outcome is Outcome.ENDED or (member and SIMULATOR in member.nodes)):
        told = simulator.get(EXIT_STATUS, "")
        status = int(told) if re.fullmatch(r"[0-9]{1,3}", told) else FAILED
        lost = [f"lost: {', '.join(stuck)} (no sign of life)"] if stuck and status == FAILED else []
        told_already = status in (0, BAD_CONFIGURATION)  # a bad configuration the node has told itself
        return status, [] if told_already else [word, *lost]
    ended = None if member is None else member.process.returncode
    if member is None or ended is None:
        return FAILED, []
    if ended == BAD_CONFIGURATION:
        return BAD_CONFIGURATION, []  # the node has said why
    nodes = "" if member.nodes in ((), (member.name,)) else f" with {', '.join(member.nodes)}"
    return FAILED, [f"lost: {member.name}{nodes}, {how_it_ended(ended)}"]
