"""Where the package's own files are: installed (ament prefix, venv) or in a source checkout."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

from follower_humanoid.errors import ConfigurationError
from follower_humanoid.executables import EXECUTABLES

PACKAGE = "follower_humanoid"


def share_path(relative: str) -> Path:
    """Absolute path of a file under the package's share folder, e.g. `urdf/follower.urdf`.

    The source checkout comes first, so that an editable install sees its own files.

    Raises:
        ConfigurationError: The file is in none of the places.
    """
    places = [prefix / "share" / PACKAGE for prefix in _prefixes()]
    if (checkout := _checkout()) is not None:
        places.insert(0, checkout)
    return _first_file(places, relative, "file")


def executable_path(name: str) -> Path:
    """Absolute path of an executable: `lib/follower_humanoid/NAME`, in a checkout `scripts/exe/NAME`.

    Raises:
        ConfigurationError: No such executable, or it is in none of the places.
    """
    places = [prefix / "lib" / PACKAGE for prefix in _prefixes()]
    if (checkout := _checkout()) is not None:
        places.insert(0, checkout / "scripts" / "exe")
    if name not in EXECUTABLES:
        raise ConfigurationError(f"no executable '{name}'; valid: {', '.join(EXECUTABLES)}")
    return _first_file(places, name, "executable")


def node_command(name: str) -> list[str]:
    """The start of the command line that runs an executable with this process's own interpreter.

    The path of the executable is part of it, so `ps -f` shows `/NAME`.

    Raises:
        ConfigurationError: No such executable, or it is in none of the places.
    """
    return [sys.executable, str(executable_path(name))]


def _checkout() -> Path | None:
    """The source checkout this module is in; None where it is installed."""
    root = Path(__file__).resolve().parent.parent
    return root if (root / "package.xml").is_file() else None


def _prefixes() -> Iterator[Path]:
    """Installation prefixes, that of this very module first: another install may be on the path too."""
    above = Path(__file__).resolve().parents
    yield from (folder for folder in above if (folder / "share" / PACKAGE / "package.xml").is_file())
    yield from (Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p)
    yield Path(sys.prefix)


def _first_file(places: list[Path], relative: str, kind: str) -> Path:
    for place in places:
        if (place / relative).is_file():
            return place / relative
    looked = ", ".join(str(place) for place in places)
    raise ConfigurationError(f"{kind} {relative} of {PACKAGE} not found; looked in: {looked}")
