"""Executable: `report BAG... [--out DIR]` draws what recorded runs show."""

from __future__ import annotations

import sys
from pathlib import Path

from follower_humanoid.bag.reader import read_run
from follower_humanoid.command_line import Parser
from follower_humanoid.errors import BAD_CONFIGURATION, ConfigurationError


def main(args: list[str] | None = None) -> int:
    """Makes the report; returns the exit status."""
    parser = Parser(prog="report", description="Draw what recorded runs show.")
    parser.add_argument(
        "bags", metavar="BAG", nargs="+", type=Path, help="bag folder or .mcap file; several are compared"
    )
    parser.add_argument("--out", type=Path, help="folder for the pictures (default: beside the first bag)")
    parser.add_argument("--namespace", help="of the robot, where a bag holds several")
    try:
        options = parser.parse_args(args)
        bags: list[Path] = options.bags
        # Drawing needs a second to import; what is wrong with a bag is told before.
        runs = [
            (label, read_run(bag, options.namespace)) for label, bag in zip(_labels(bags), bags, strict=True)
        ]
        from follower_humanoid.pictures.report import make_report
        from follower_humanoid.pictures.table import text_table

        report = make_report(runs, options.out or _beside(bags[0]))
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return BAD_CONFIGURATION
    except MemoryError:
        print(f"report: {', '.join(map(str, bags))}: too long for this machine's memory", file=sys.stderr)
        return BAD_CONFIGURATION
    for note in report.notes:
        print(f"note: {note}", file=sys.stderr)
    if report.has_steps:
        print(text_table(report.views))
    for file in report.files:
        print(file)
    return 0


def _beside(bag: Path) -> Path:
    bag = bag.resolve()
    return bag.with_name(f"{bag.stem if bag.is_file() else bag.name}-report")


def _labels(bags: list[Path]) -> list[str]:
    """Short names of the bags; numbered where two are the same."""
    names = [bag.resolve().stem if bag.is_file() else bag.resolve().name for bag in bags]
    return [
        f"{name} ({number})" if names.count(name) > 1 else name for number, name in enumerate(names, start=1)
    ]


if __name__ == "__main__":
    sys.exit(main())
