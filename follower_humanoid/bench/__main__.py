"""`python -m follower_humanoid.bench`: runs the scenarios, prints the table, writes JSON."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from follower_humanoid.bench.scenarios import NO_FALL, SCENARIOS, Check, Evidence, Scenario
from follower_humanoid.errors import ConfigurationError, FollowerError, UnknownNameError
from follower_humanoid.graph.simulate import simulate


def main(args: list[str] | None = None) -> int:
    """Command line; 0 = every number holds, 1 = some do not, 2 = bad usage."""
    parser = argparse.ArgumentParser(prog="benchmark", description=__doc__)
    parser.add_argument(
        "--only", action="append", default=[], metavar="NAME", help="run this scenario; repeatable"
    )
    parser.add_argument("--brief", action="store_true", help="the short form that runs with the tests")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table as JSON")
    options = parser.parse_args(args)
    try:
        chosen = _choose(options.only, options.brief)
        _check_writable(options.json)
    except FollowerError as error:
        print(f"benchmark: {error}", file=sys.stderr)
        return 2
    table: dict[str, list[Check]] = {}
    for scenario in chosen:
        table[scenario.name] = run_scenario(scenario)
        _write(options.json, table)
    missed = [f"{name}: {c.what}" for name, checks in table.items() for c in checks if not c.passed]
    total = sum(len(checks) for checks in table.values())
    print(
        f"\n{total - len(missed)} of {total} numbers hold" + "".join(f"\n  missed: {line}" for line in missed)
    )
    return 1 if missed else 0


def run_scenario(scenario: Scenario) -> list[Check]:
    """Simulates, measures and prints one scenario."""
    started = time.perf_counter()
    run = simulate(scenario.programme, scenario.duration)
    wall = time.perf_counter() - started
    checks = _until_a_fall(scenario.checks(Evidence.of(run)))
    print(
        f"\n{scenario.name} ({scenario.duration:g} s simulated, {scenario.duration / wall:.2f} × real time)"
    )
    for check in checks:
        mark = "ok  " if check.passed else "MISS"
        print(f"  {mark} {check.what:<42} {check.required:<40} {check.measured}", flush=True)
    return checks


def _until_a_fall(checks: Iterator[Check]) -> list[Check]:
    """All checks of a scenario; after a fall, which is always the first, nothing more can be measured."""
    done = []
    for check in checks:
        done.append(check)
        if check.what == NO_FALL and not check.passed:
            break
    return done


def _check_writable(path: Path | None) -> None:
    if path is not None and not path.resolve().parent.is_dir():
        raise ConfigurationError(f"--json {path}: no such folder")


def _write(path: Path | None, table: dict[str, list[Check]]) -> None:
    """The table so far."""
    if path is None:
        return
    rows = {name: [dataclasses.asdict(check) for check in checks] for name, checks in table.items()}
    path.write_text(json.dumps(rows, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def _choose(names: list[str], brief: bool) -> list[Scenario]:
    known = {scenario.name: scenario for scenario in SCENARIOS}
    for name in names:
        if name not in known:
            raise UnknownNameError("scenario", name, known)
    chosen = [known[name] for name in names] if names else list(SCENARIOS)
    return [scenario for scenario in chosen if scenario.brief or not brief]


if __name__ == "__main__":
    sys.exit(main())
