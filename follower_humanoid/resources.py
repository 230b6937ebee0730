"""Where the package's own files are: installed (ament prefix, venv) or in a source checkout."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from follower_humanoid.errors import ConfigurationError

PACKAGE = "follower_humanoid"


def share_path(relative: str) -> Path:
    """Absolute path of a file under the package's share folder, e.g. `urdf/follower.urdf`.

    The source checkout comes first, so that an editable install sees its own files.

    Raises:
        ConfigurationError: The file is in none of the places.
    """
    prefixes = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    places = [Path(__file__).resolve().parent.parent]
    places += [prefix / "share" / PACKAGE for prefix in (*prefixes, Path(sys.prefix))]
    for place in places:
        if (place / "package.xml").is_file() and (place / relative).is_file():
            return place / relative
    looked = ", ".join(str(place) for place in places)
    raise ConfigurationError(f"file {relative} of {PACKAGE} not found; looked in: {looked}")
