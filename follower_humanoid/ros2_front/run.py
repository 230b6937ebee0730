"""`ros2 run PACKAGE EXECUTABLE [arguments]`."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn

from follower_humanoid import resources
from follower_humanoid.command_line import UsageError
from follower_humanoid.executables import EXECUTABLES
from follower_humanoid.ros2_front.verbs import CommandError

_HELP = """usage: ros2 run [-h] [--prefix COMMAND] PACKAGE EXECUTABLE [arguments]

Run an executable of a package; its arguments are passed on.

  --prefix COMMAND  put before the executable, e.g. --prefix 'gdb -ex run --args'"""


def run(words: Sequence[str]) -> int:
    """Becomes the executable, so that signals and exit status are its own."""
    rest = list(words)
    prefix: list[str] = []
    while rest and rest[0].startswith("-"):
        option, _, value = rest.pop(0).partition("=")
        if option in ("-h", "--help"):
            print(_HELP)
            return 0
        if option != "--prefix" or not (value or rest):
            raise UsageError(f"ros2 run: no such argument: {option}; valid: -h, --help, --prefix COMMAND")
        prefix = shlex.split(value or rest.pop(0))
    if len(rest) < 2:
        raise UsageError("ros2 run: needs a package and an executable; ros2 run --help says more")
    package, name, *arguments = rest
    _become([*prefix, *find(package, name), *arguments])


def find(package: str, name: str) -> list[str]:
    """The start of the command line that runs an executable.

    Raises:
        CommandError: No such package or executable.
    """
    if package == resources.PACKAGE and name in EXECUTABLES:
        return resources.node_command(name)  # with this interpreter, whatever the PATH says
    folders = [prefix / "lib" / package for prefix in _prefixes()]
    for folder in folders:
        path = folder / name
        if path.is_file() and os.access(path, os.X_OK):
            return [str(path)]
    known = sorted({path.name for folder in folders for path in _executables(folder)})
    if package == resources.PACKAGE:
        known = list(EXECUTABLES)
    if known:
        raise CommandError(f"no executable '{name}' in package {package}; valid: {', '.join(known)}")
    raise CommandError(f"no package '{package}' with executables")


def _become(command: list[str]) -> NoReturn:
    sys.stdout.flush()
    try:
        os.execvp(command[0], command)
    except OSError as error:
        raise CommandError(f"{command[0]}: {error.strerror}") from None


def _prefixes() -> Iterator[Path]:
    yield from (Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p)
    yield Path(sys.prefix)


def _executables(folder: Path) -> Iterator[Path]:
    if folder.is_dir():
        yield from (path for path in folder.iterdir() if path.is_file() and os.access(path, os.X_OK))
