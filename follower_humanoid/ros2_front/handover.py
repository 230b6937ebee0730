"""A real `ros2` always goes first: this front only stands in where there is none."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

# Console scripts name the module that they call, editable ones the distribution. The name alone is not
# enough: the path of an interpreter may have it.
_OURS = re.compile(rb"follower_humanoid\.ros2_front|['\"]follower[-_]humanoid(==[^'\"]*)?['\"]")
_LONGEST_SCRIPT = 16384


def is_ours(path: Path) -> bool:
    """Whether an executable is a copy of this front, which may be installed in several places."""
    try:
        with path.open("rb") as file:
            return _OURS.search(file.read(_LONGEST_SCRIPT)) is not None
    except OSError:
        return False


def real_ros2(folders: Iterable[str] | None = None) -> Path | None:
    """The first `ros2` in the folders of the PATH that is not this front."""
    if folders is None:
        folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    for folder in folders:
        path = Path(folder or ".", "ros2")
        if path.is_file() and os.access(path, os.X_OK) and not is_ours(path):
            return path
    return None


def hand_over(args: list[str]) -> None:
    """Becomes the real `ros2` with the same arguments; returns where there is none."""
    path = real_ros2()
    if path is not None:
        os.execv(path, [str(path), *args])
