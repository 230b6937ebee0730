"""Force programmes: what the leader does to the hands, and pushes at the base, over time.

A programme is YAML in one of two forms. Forces in [N], axes of world; what is left out is zero:

    - {until: 6.6, left: [5, 0, -10]}         each entry holds until its time [s]
    - {until: 22, left: [4, 3, -10]}

    interpolate: linear                       straight lines between points in time [s]
    points:
      - {at: 0, right: [0, 0, 0]}
      - {at: 4, right: [5, 0, 0]}
"""

from __future__ import annotations

import math
import os
from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from follower_humanoid.core.samples import Array
from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.resources import share_path

BUILT_IN = ("fig4", "fig5")
_PLACES = ("left", "right", "base")


@dataclass(frozen=True)
class Forces:
    """Forces on the robot in world axes, each of shape (3,) [N]; `base` acts at the base_link origin."""

    left: Array
    right: Array
    base: Array


_NO_FORCES = Forces(*np.zeros((3, 3)))


class Programme:
    """Forces over time: constant between times, or linear.

    Attributes:
        duration: End of the programme [s]; zero force from there on.
    """

    def __init__(self, times: list[float], forces: Array, linear: bool) -> None:
        """Takes checked values.

        Args:
            times: Strictly increasing [s]: ends of the entries, or the times of the points.
            forces: Left hand, right hand, base per time, shape (n, 3, 3) [N].
            linear: True for points joined by straight lines.
        """
        self._times = times
        self._forces = forces
        self._entries = [Forces(*held) for held in forces]
        self._linear = linear
        self.duration = times[-1]

    def at(self, time: float) -> Forces:
        """Forces at a time [s]: an entry holds up to, not at, its end; zero outside the programme.

        As long as an entry holds, they are one and the same object.
        """
        index = bisect_right(self._times, time)
        if index == len(self._times) or time < 0.0:
            return _NO_FORCES
        if not self._linear:
            return self._entries[index]
        if index == 0:
            return _NO_FORCES
        begin, end = self._times[index - 1], self._times[index]
        share = (time - begin) / (end - begin)
        return Forces(*((1.0 - share) * self._forces[index - 1] + share * self._forces[index]))


def load_programme(name_or_path: str, *others: str) -> Programme:
    """A built-in programme by its name, or one from a YAML file; other words are named as valid, no more.

    Raises:
        ConfigurationError: No such programme, or the file is not a programme; one line that names
            the file, the entry, and what is valid.
    """
    if name_or_path in BUILT_IN:
        path = share_path(f"config/programmes/{name_or_path}.yaml")
    else:
        path = Path(name_or_path)
        if not os.path.exists(path):  # unlike Path's, False for a name that no file can have
            valid = ", ".join((*BUILT_IN, *others))
            raise ConfigurationError(
                f"no force programme '{name_or_path}'; valid: {valid}, or a YAML file"
            )
    return parse_programme(read_yaml(path), str(path))


def parse_programme(content: Any, where: str) -> Programme:
    """A programme from the plain data of its YAML; `where` names the file in messages.

    Raises:
        ConfigurationError: As for `load_programme`.
    """
    if isinstance(content, list):
        entries, key, linear = content, "until", False
    elif isinstance(content, dict):
        entries, key, linear = _points(content, where), "at", True
    else:
        raise ConfigurationError(
            f"{where}: needs a list of '{{until: s, left: [x, y, z]}}' or 'interpolate: linear' with 'points'"
        )
    if len(entries) < (2 if linear else 1):
        raise ConfigurationError(f"{where}: needs at least {'two points' if linear else 'one entry'}")
    times: list[float] = []
    forces = np.zeros((len(entries), len(_PLACES), 3))
    for number, entry in enumerate(entries):
        here = f"{where}: {'point' if linear else 'entry'} {number + 1}"
        times.append(_time(entry, key, times, here))
        for place, name in enumerate(_PLACES):
            if name in entry:
                forces[number, place] = _force(entry[name], f"{here}: {name}")
    return Programme(times, forces, linear)


def _points(content: dict[Any, Any], where: str) -> list[Any]:
    _check_names(content, ("interpolate", "points"), where)
    if content.get("interpolate") != "linear":
        raise ConfigurationError(f"{where}: interpolate = {content.get('interpolate')!r}: valid: linear")
    points = content.get("points")
    if not isinstance(points, list):
        raise ConfigurationError(f"{where}: points needs a list of '{{at: s, left: [x, y, z]}}'")
    return points


def _check_names(mapping: dict[Any, Any], valid: tuple[str, ...], where: str) -> None:
    for name in mapping:
        if name not in valid:
            raise ConfigurationError(f"{where}: no '{name}'; valid: {', '.join(valid)}")


def _time(entry: Any, key: str, earlier: list[float], where: str) -> float:
    if not isinstance(entry, dict):
        raise ConfigurationError(f"{where}: needs '{{{key}: s, left: [x, y, z], right: …, base: …}}'")
    _check_names(entry, (key, *_PLACES), where)
    if key not in entry:
        raise ConfigurationError(f"{where}: '{key}' is missing")
    time = _number(entry[key], f"{where}: {key}")
    if earlier and time <= earlier[-1]:
        raise ConfigurationError(f"{where}: {key} = {time:g}: needs to be later than {earlier[-1]:g}")
    if time < 0.0 or (key == "until" and time == 0.0):
        raise ConfigurationError(f"{where}: {key} = {time:g}: needs to be after 0")
    return time


def _force(value: Any, where: str) -> list[float]:
    if not isinstance(value, list) or len(value) != 3:
        raise ConfigurationError(f"{where} = {value!r}: needs three numbers [x, y, z]")
    return [_number(entry, where) for entry in value]


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigurationError(f"{where} = {value!r}: needs a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ConfigurationError(f"{where} = {value}: needs a finite number")
    return number
