"""Gives hostile files to their readers, in a process of its own: it may crash, hang or fill the memory.

`python -m follower_humanoid.faults.file_worker KIND COUNT SEED` prints a line of JSON per finding and
one at the end.
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import sys
import tempfile
from pathlib import Path
from types import FrameType

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.faults.hostile_files import KINDS, MIB, HostileFiles
from follower_humanoid.ros.quiet import quiet_stderr

LONGEST_READ = 20.0  # CPU time [s], a thousand times what most files take


class Hang(BaseException):
    """A reader that does not come back; no reader catches it."""


def main(kind: str, count: int, seed: int) -> int:
    """Reads `count` files; a finding is whatever is neither read nor refused in one line."""
    signal.signal(signal.SIGPROF, _hang)
    read = refused = 0
    with tempfile.TemporaryDirectory(prefix="follower_humanoid_") as folder, quiet_stderr():
        hostile: HostileFiles = KINDS[kind](Path(folder))
        path = Path(folder, f"file{hostile.suffix}")
        for number in range(count):
            path.write_bytes(hostile.content(number, random.Random(f"{kind} {seed} {number}")))
            print(json.dumps({"trying": number}), flush=True)
            finding = _read(hostile, path)
            if finding is None:
                read += 1
            elif finding == "":
                refused += 1
            else:
                print(json.dumps({"file": number, "finding": finding}), flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / MIB
    print(json.dumps({"read": read, "refused": refused, "peak": peak}), flush=True)
    return 0


def _read(hostile: HostileFiles, path: Path) -> str | None:
    """None where the file was read, nothing where it was refused, else what went wrong."""
    signal.setitimer(signal.ITIMER_PROF, LONGEST_READ)
    try:
        hostile.read(path)
    except ConfigurationError as error:
        return "" if "\n" not in str(error) else f"several lines: {error!r}"
    except Hang:
        return f"not read in {LONGEST_READ:g} s of CPU time"
    except Exception as error:  # whatever else it is, it is a finding
        return f"{type(error).__name__}: {error}"[:200]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return None


def _hang(number: int, frame: FrameType | None) -> None:
    raise Hang


if __name__ == "__main__":
    sys.stdout = os.fdopen(os.dup(1), "w")  # what C libraries print goes elsewhere
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
