"""`replay BAG --simulate [--verify]`: the run once more, from what the bag carries."""

from __future__ import annotations

import hashlib
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from follower_humanoid.bag.reader import read_run
from follower_humanoid.errors import ConfigurationError, PhysicsError
from follower_humanoid.graph.compare import Comparison, Difference
from follower_humanoid.graph.repeatable import Recorded, repeatable
from follower_humanoid.graph.resimulate import Keep, Repetition

FAILED = 1
DIFFERS = 4
_TELL_EVERY = 0.5


@dataclass
class Outcome:
    """How far a repetition came.

    Attributes:
        ticks: Ticks simulated.
        wall: Time that took [s].
        digest: SHA-256 of the joint positions, as `Run.joint_hash` has it.
        difference: The first one; None where there was none, or nothing was compared.
        compared: Ticks that were compared.
        fall: What the robot fell by, empty while upright.
    """

    ticks: int = 0
    wall: float = 0.0
    digest: str = ""
    difference: Difference | None = None
    compared: int = 0
    fall: str = ""


def simulate_again(bag: Path, namespace: str | None, verify: bool, keep: Keep | None = None) -> int:
    """Simulates a recorded run again and says what came out; returns the exit status.

    Args:
        bag: The recorded run.
        namespace: Of the robot; None: the only one in the bag.
        verify: Compare with the bag.
        keep: Makes what takes the new run in; None: it is not kept.

    Raises:
        ConfigurationError: The bag does not carry what it takes.
    """
    run = read_run(bag, namespace)
    try:
        recorded = repeatable(run)
    except ConfigurationError as error:
        raise ConfigurationError(f"bag {bag}: {error}") from None
    for note in [*run.notes, *recorded.notes]:
        print(f"note: {note}", file=sys.stderr)
    try:
        outcome = repeat(recorded, verify, keep)
    except KeyboardInterrupt:
        print("stopped before the end", file=sys.stderr)
        return FAILED
    except PhysicsError as error:
        print(error, file=sys.stderr)
        return FAILED
    except OSError as error:  # the new bag names itself
        kept = f"{error.filename}: {error.strerror}; what was written before can be read"
        print(kept if error.filename else f"a temporary file: {error.strerror}", file=sys.stderr)
        return FAILED
    simulated = (outcome.ticks - 1) * run.tick
    factor = simulated / max(outcome.wall, 1e-9)
    print(f"simulated again: {outcome.ticks} ticks, {simulated:.3f} s")
    print(f"real-time factor: {factor:.2f}")
    if outcome.fall:
        print(f"the robot fell: {outcome.fall}")
    print(f"joint positions: sha256 {outcome.digest}", flush=True)
    if outcome.difference is not None:
        print(f"bag {bag} {outcome.difference}", file=sys.stderr)
        return DIFFERS
    if verify:
        print(f"identical to the bag: joint positions of {outcome.compared} ticks, bit for bit")
    return 0


def repeat(recorded: Recorded, verify: bool, keep: Keep | None = None) -> Outcome:
    """Runs to the last recorded tick; when verifying, to the first difference at most."""
    outcome = Outcome()
    digest = hashlib.sha256()
    begin = told = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder:
        chain = Repetition(recorded, Path(folder), keep)
        try:
            comparison = Comparison(recorded.run, chain.robot.joint_names)
            for tick in range(recorded.ticks):
                position = chain.simulator.observe().joints.position
                digest.update(position.astype("<f8").tobytes())
                outcome.ticks = tick + 1
                if verify:
                    outcome.difference = comparison.look(tick, position)
                    if outcome.difference is not None:
                        break
                if tick + 1 < recorded.ticks:
                    chain.advance()
                else:
                    chain.publish_state()
                if time.monotonic() - told > _TELL_EVERY:
                    told = time.monotonic()
                    _progress(tick * recorded.run.tick, recorded.ticks * recorded.run.tick)
            outcome.compared = comparison.compared
            fall = chain.simulator.fall
            if fall is not None:
                outcome.fall = f"{fall.reason} at {fall.time:.3f} s"
        finally:
            _progress()
            chain.close()
    outcome.wall = time.monotonic() - begin
    outcome.digest = digest.hexdigest()
    return outcome


def _progress(time_reached: float | None = None, whole: float = 0.0) -> None:
    """One line that renews itself, on a terminal only."""
    if sys.stderr.isatty():
        text = "" if time_reached is None else f"t = {time_reached:.1f} s of {whole:.1f} s"
        print(f"\r{text:40}\r", end="", file=sys.stderr, flush=True)
