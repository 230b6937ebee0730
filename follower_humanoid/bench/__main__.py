"""`python -m follower_humanoid.bench`: runs the scenarios, prints the table, writes JSON."""

from __future__ import annotations

import argparse
import dataclasses
import functools
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from follower_humanoid.bench import graph
from follower_humanoid.bench.check import NO_FALL, Check
from follower_humanoid.bench.scenarios import SCENARIOS, Evidence, Scenario
from follower_humanoid.command_line import Parser, check_room
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError, FollowerError, UnknownNameError
from follower_humanoid.graph.simulate import simulate

Runs = dict[str, Callable[[], list[Check]]]

# What is done instead of the scenarios → further options that it heeds.
_INSTEAD = {
    "faults": ("only", "brief", "json"),
    "robust": ("only", "json"),
    "speed": ("brief", "json"),
    "limits": ("only",),
    "tuning": (),
    "growth": ("brief",),
}


def main(args: list[str] | None = None) -> int:
    """Command line; 0 = every number holds, 1 = some do not, or a run ended badly, 2 = bad usage."""
    try:
        run = _chosen(_parser().parse_args(args))
    except FollowerError as error:
        return _complain(error, BAD_CONFIGURATION)
    try:
        return run()
    except FollowerError as error:
        return _complain(error, 1)


def _complain(error: FollowerError, status: int) -> int:
    print(error, file=sys.stderr)
    return status


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="benchmark",
        description=__doc__,
        epilog="Exit status: 0 every number holds, 1 some do not, or a run ended badly, 2 bad usage.",
    )
    parser.add_argument(
        "--only", action="append", default=[], metavar="NAME", help="run this scenario; repeatable"
    )
    parser.add_argument("--brief", action="store_true", help="the short form that runs with the tests")
    parser.add_argument("--faults", action="store_true", help="try faults instead, see docs/reliability.md")
    parser.add_argument("--robust", action="store_true", help="disturb it instead, see docs/tuning.md")
    parser.add_argument("--speed", action="store_true", help="measure speed instead, see docs/speed.md")
    parser.add_argument("--limits", action="store_true", help="how much it stands, by bisection, instead")
    parser.add_argument(
        "--tuning", type=Path, metavar="DIR", help="pictures of the three standard tests instead"
    )
    parser.add_argument("--growth", action="store_true", help="more robots, longer runs: takes hours")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table as JSON")
    return parser


def _chosen(options: argparse.Namespace) -> Callable[[], int]:
    """Looks at the options; returns what does what they ask for, with the exit status.

    Raises:
        FollowerError: They cannot be used.
    """
    _refuse_unused(options)
    _check_writable(options.json)
    _check_folder(options.tuning)
    if options.tuning is not None:
        return functools.partial(_draw, options.tuning)
    if options.speed:
        return functools.partial(_speed, options.brief, options.json)
    if options.growth:
        return functools.partial(_growth, options.brief)
    if options.limits:
        return functools.partial(_limits, _known_limits(options.only))
    known = _scenarios(options.brief)
    if options.faults:
        known = _faults(options.brief)
    elif options.robust:
        known = _disturbances()
    return functools.partial(_table, _choose(options.only, known), options.json)


def _refuse_unused(options: argparse.Namespace) -> None:
    """An option that makes no difference is a misunderstanding."""
    asked = [name for name in _INSTEAD if getattr(options, name)]
    if len(asked) > 1:
        raise ConfigurationError(f"--{asked[0]} and --{asked[1]}: one at a time")
    for instead in asked:
        for name in ("only", "brief", "json"):
            if getattr(options, name) and name not in _INSTEAD[instead]:
                raise ConfigurationError(f"--{name} has no use with --{instead}")


def _table(chosen: Runs, path: Path | None) -> int:
    """Runs what was chosen, one after the other."""
    table: dict[str, list[Check]] = {}
    for name, run in chosen.items():
        table[name] = run()
        _write(path, table)
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
    speed = scenario.duration / (time.perf_counter() - started)
    checks = _until_a_fall(scenario.checks(Evidence.of(run)))
    return _shown(f"{scenario.name} ({scenario.duration:g} s simulated, {speed:.2f} × real time)", checks)


def _speed(brief: bool, path: Path | None) -> int:
    """Measures speed and prints tables; 0 = every number holds."""
    from follower_humanoid.bench import speed

    seconds, repeats = (1.0, 1) if brief else (6.0, 3)
    costs = speed.measure(seconds, repeats, lambda text: print(text, file=sys.stderr, flush=True))
    print(f"\nspeed (fig. 4, {seconds:g} s simulated, median of {repeats})\n{speed.table(costs)}\n")
    checks = _lines(speed.checks(costs))
    if path is not None:
        numbers = {**speed.as_numbers(costs), "checks": [dataclasses.asdict(check) for check in checks]}
        path.write_text(json.dumps(numbers, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return 0 if all(check.passed for check in checks) else 1


def _growth(brief: bool) -> int:
    """Measures growth and prints its table; 0 = every number holds."""
    from follower_humanoid.bench import growth

    lines, checks = growth.measure(brief, lambda text: print(text, file=sys.stderr, flush=True))
    print("\n".join(["\ngrowth", *lines, ""]))
    return 0 if all(check.passed for check in _lines(checks)) else 1


def run_graph() -> list[Check]:
    """The scenario that needs ROS."""
    return _shown(f"{graph.NAME} (fig. 4 through bringup)", list(graph.graph_checks()))


def _shown(title: str, checks: list[Check]) -> list[Check]:
    print(f"\n{title}")
    return _lines(checks)


def _lines(checks: Iterable[Check]) -> list[Check]:
    """Prints each as soon as it is known."""
    done = []
    for check in checks:
        mark = "ok  " if check.passed else "MISS"
        print(f"  {mark} {check.what:<46} {check.required:<40} {check.measured}", flush=True)
        done.append(check)
    return done


def _until_a_fall(checks: Iterator[Check]) -> list[Check]:
    """All checks of a scenario; after a fall, which is always the first, nothing more can be measured."""
    done = []
    for check in checks:
        done.append(check)
        if check.what == NO_FALL and not check.passed:
            break
    return done


def _check_writable(path: Path | None) -> None:
    if path is None:
        return
    if not os.path.isdir(os.path.dirname(os.path.realpath(path))):
        raise ConfigurationError(f"--json {path}: no such folder")
    if os.path.isdir(path):
        raise ConfigurationError(f"--json {path}: is a folder, needs the name of a file")


def _check_folder(path: Path | None) -> None:
    if path is None:
        return
    if os.path.lexists(path) and not os.path.isdir(path):
        raise ConfigurationError(f"--tuning {path}: is not a folder")
    check_room(path, "--tuning")


def _write(path: Path | None, table: dict[str, list[Check]]) -> None:
    """The table so far."""
    if path is None:
        return
    rows = {name: [dataclasses.asdict(check) for check in checks] for name, checks in table.items()}
    path.write_text(json.dumps(rows, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def _scenarios(brief: bool) -> Runs:
    """Name → what runs it, in the order of the table."""
    known: Runs = {
        scenario.name: functools.partial(run_scenario, scenario)
        for scenario in SCENARIOS
        if scenario.brief or not brief
    }
    known[graph.NAME] = run_graph
    return known


def _faults(brief: bool) -> Runs:
    """Name → what tries it, in the order of the table."""
    from follower_humanoid.faults.case import Effort, Fault
    from follower_humanoid.faults.table import FAULTS

    def tried(fault: Fault) -> list[Check]:
        print(f"\n{fault.name}")
        return _lines(fault.try_it(Effort(brief)))

    return {fault.name: functools.partial(tried, fault) for fault in FAULTS if fault.brief or not brief}


def _disturbances() -> Runs:
    """Name → what disturbs the robot, in the order of the table."""
    from follower_humanoid.bench import disturbances, laws

    rows = {**disturbances.ROWS, **laws.ROWS}

    def tried(name: str) -> list[Check]:
        print(f"\n{name}", flush=True)
        return _lines(rows[name]())

    return {name: functools.partial(tried, name) for name in rows}


def _known_limits(names: list[str]) -> list[str]:
    """Those that were named, else all parts of the table of limits."""
    from follower_humanoid.bench.limits import LIMITS

    for name in names:
        if name not in LIMITS:
            raise UnknownNameError("limit", name, LIMITS)
    return names or list(LIMITS)


def _limits(names: list[str]) -> int:
    """Prints parts of the table of limits."""
    from follower_humanoid.bench.limits import LIMITS

    for name in names:
        for limit in LIMITS[name]():
            print(f"| {limit.what} | {limit} |", flush=True)
    return 0


def _draw(folder: Path) -> int:
    """Writes the pictures of docs/tuning.md."""
    from follower_humanoid.bench.standard_tests import draw_standard_tests

    for file in draw_standard_tests(folder):
        print(file, flush=True)
    return 0


def _choose(names: list[str], known: Runs) -> Runs:
    """Those that were named, else all."""
    for name in names:
        if name not in known:
            raise UnknownNameError("scenario", name, known)
    return {name: known[name] for name in names or known}


if __name__ == "__main__":
    sys.exit(main())
