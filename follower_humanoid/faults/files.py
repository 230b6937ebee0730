"""Hostile files, given to their readers in a process that may crash, hang or fill the memory."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field

from follower_humanoid.bench.check import Check
from follower_humanoid.faults.case import Effort, survived

KINDS = ("YAML", "URDF", "MCAP")
LARGEST_MEMORY = 1024.0  # MiB
_LONGEST_START = 120.0  # wall time for some files [s]; what uses no CPU time hangs all the same
_SEED = 7


@dataclass
class Outcome:
    """What came of many files.

    Attributes:
        read, refused: Files that were read, and refused in one line.
        findings: Everything else, one text each.
        peak: Largest memory of the process [MiB].
    """

    read: int = 0
    refused: int = 0
    findings: list[str] = field(default_factory=list)
    peak: float = 0.0


def tried_files(kind: str, count: int, seed: int) -> Outcome:
    """Has `count` files of a kind read."""
    command = [sys.executable, "-m", "follower_humanoid.faults.file_worker", kind, str(count), str(seed)]
    outcome = Outcome()
    trying = -1
    longest = max(_LONGEST_START, 0.5 * count)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            said, complained = process.communicate(timeout=longest)
        except subprocess.TimeoutExpired:
            process.kill()
            said, complained = process.communicate()
            outcome.findings.append(f"not done after {longest:.0f} s")
    for line in said.splitlines():
        report = json.loads(line)
        trying = report.get("trying", trying)
        if "finding" in report:
            outcome.findings.append(f"file {report['file']} of seed {seed}: {report['finding']}")
        if "peak" in report:
            outcome.read, outcome.refused, outcome.peak = report["read"], report["refused"], report["peak"]
    if process.returncode != 0:
        last = complained.strip().splitlines()[-1:] or ["without a word"]
        outcome.findings.append(
            f"file {trying} of seed {seed}: process ended with {process.returncode}, {last[0]}"
        )
    return outcome


def hostile_files(effort: Effort) -> Iterator[Check]:
    """A line per kind of file."""
    for kind in KINDS:
        count = effort.count(50, 10_000)
        outcome = tried_files(kind, count, _SEED)
        good = not outcome.findings and outcome.peak < LARGEST_MEMORY
        observed = f"{outcome.read} read, {outcome.refused} refused, {outcome.peak:.0f} MiB"
        observed += f"; {len(outcome.findings)} faults" if outcome.findings else ""
        observed += "".join(f"; {finding}" for finding in outcome.findings[:3])
        required = f"{count} read or refused in one line, memory < {LARGEST_MEMORY:.0f} MiB"
        yield survived(f"hostile {kind} files", required, observed, good)
