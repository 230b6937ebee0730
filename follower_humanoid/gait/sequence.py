"""Sequences of motion primitives: what runs in parallel, what follows what; read from YAML."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.gait.primitives import PRIMITIVES, ZMP, Primitive
from follower_humanoid.resources import share_path

SUPPORTS = ("double", "single")
_LARGEST_NUMBER = 1e6  # beyond it nothing in a half-step has a meaning


@dataclass(frozen=True)
class Phase:
    """Primitives that run in parallel.

    Attributes:
        name: For logs and errors.
        single_support: True while the swing foot is in the air.
        share: Part of the half-step time, 0…1.
        primitives: At most one owner per channel at any progress.
    """

    name: str
    single_support: bool
    share: float
    primitives: tuple[Primitive, ...]

    def __post_init__(self) -> None:
        if not self.primitives:
            raise ConfigurationError(f"phase '{self.name}' has no primitives")
        if not 0.0 < self.share <= 1.0:
            raise ConfigurationError(f"phase '{self.name}': share = {self.share}: valid: above 0 to 1")
        for primitive in self.primitives:
            self._check_window(primitive)
        for i, first in enumerate(self.primitives):
            for second in self.primitives[i + 1 :]:
                overlap = min(first.end, second.end) - max(first.start, second.start)
                if first.channel == second.channel and overlap > 1e-9:
                    raise ConfigurationError(
                        f"phase '{self.name}': {_word(first)} and {_word(second)} both move "
                        f"'{first.channel}' between {max(first.start, second.start)} and "
                        f"{min(first.end, second.end)}"
                    )

    def _check_window(self, primitive: Primitive) -> None:
        if not 0.0 <= primitive.start < primitive.end <= 1.0:
            raise ConfigurationError(
                f"phase '{self.name}', {_word(primitive)}: window {primitive.start} to {primitive.end}: "
                "valid: 0 <= start < end <= 1"
            )
        for field in dataclasses.fields(primitive):
            if not math.isfinite(getattr(primitive, field.name)):
                raise ConfigurationError(
                    f"phase '{self.name}', {_word(primitive)}: {field.name} is not finite"
                )

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the primitives."""
        return tuple(map(primitive_name, self.primitives))

    @cached_property
    def zmp_windows(self) -> tuple[tuple[Primitive | None, float, float], ...]:
        """What moves the ZMP, in order of time: primitive, start and end, 0…1; None while it rests."""
        windows: list[tuple[Primitive | None, float, float]] = []
        begin = 0.0
        for primitive in sorted((p for p in self.primitives if p.channel == ZMP), key=lambda p: p.start):
            if primitive.end <= begin:
                continue
            if primitive.start > begin:
                windows.append((None, begin, primitive.start))
                begin = primitive.start
            windows.append((primitive, begin, primitive.end))
            begin = primitive.end
        if begin < 1.0:
            windows.append((None, begin, 1.0))
        return tuple(windows)


@dataclass(frozen=True)
class Sequence:
    """Phases of a half-step, in order: double support first, single support last.

    Attributes:
        name: For logs and errors.
        phases: Their shares add up to 1.
        brisk_time: Half-steps shorter than this spend less of their time on double support, down to half
            its share: a quick step needs the time for its swing [s].
    """

    name: str
    phases: tuple[Phase, ...]
    brisk_time: float = 0.0

    def __post_init__(self) -> None:
        kinds = [phase.single_support for phase in self.phases]
        if not kinds or kinds[-1] is not True or kinds[0] is not False or kinds != sorted(kinds):
            raise ConfigurationError(
                f"sequence '{self.name}': needs phases of double support, then of single support"
            )
        total = sum(phase.share for phase in self.phases)
        if abs(total - 1.0) > 1e-6:
            raise ConfigurationError(f"sequence '{self.name}': the shares add up to {total}, not 1")

    @cached_property
    def doubles(self) -> int:
        """How many phases come before lift-off."""
        return sum(not phase.single_support for phase in self.phases)

    @cached_property
    def double_share(self) -> float:
        """Part of the half-step time on both feet, 0…1."""
        return sum(phase.share for phase in self.phases if not phase.single_support)

    def phase_time(self, phase: Phase, duration: float) -> float:
        """Time of a phase in a half-step of `duration` [s]."""
        double, squeeze = self.double_share, self._squeeze(duration)
        if phase.single_support:
            return duration * phase.share * (1.0 - squeeze * double) / (1.0 - double)
        return duration * phase.share * squeeze

    def times(self, duration: float) -> tuple[float, ...]:
        """Times of all phases [s]."""
        return tuple([self.phase_time(phase, duration) for phase in self.phases])

    def double_time(self, duration: float) -> float:
        """Time on both feet in a half-step of `duration` [s]."""
        return duration * self.double_share * self._squeeze(duration)

    def _squeeze(self, duration: float) -> float:
        """Factor on the double support of a quick step."""
        return min(1.0, max(0.5, duration / self.brisk_time)) if self.brisk_time > 0.0 else 1.0


def primitive_name(primitive: Primitive) -> str:
    """The name a primitive has in a sequence file."""
    return type(primitive).__name__.lower()


_word = primitive_name


def load_sequence(path: str = "") -> Sequence:
    """Reads a sequence file; the package's own half-step when the path is empty.

    Raises:
        ConfigurationError: The file, a phase or a primitive is unusable.
    """
    file = Path(path) if path else share_path("config/sequences/half_step.yaml")
    document = read_yaml(file)
    try:
        if not isinstance(document, dict) or not isinstance(document.get("phases"), list):
            raise ConfigurationError("needs 'name' and a list 'phases'")
        _only_known(document, ("name", "phases", "brisk_time"))
        phases = tuple(_phase(entry, number) for number, entry in enumerate(document["phases"], start=1))
        brisk = _number(document.get("brisk_time", 0.0), "brisk_time")
        if brisk < 0.0:
            raise ConfigurationError(f"brisk_time = {brisk!r}: needs a time in seconds, 0 = never")
        return Sequence(str(document.get("name", file.stem)), phases, brisk)
    except ConfigurationError as error:
        raise ConfigurationError(f"sequence {file}: {error}") from None


def _only_known(entry: dict[Any, Any], names: tuple[str, ...], where: str = "") -> None:
    for name in entry:
        if name not in names:
            raise UnknownNameError("key", str(name), names, where)


def _phase(entry: Any, number: int) -> Phase:
    if not isinstance(entry, dict) or not isinstance(entry.get("primitives"), list):
        raise ConfigurationError(f"phase {number}: needs name, support, share and a list 'primitives'")
    name = str(entry.get("name", number))
    _only_known(entry, ("name", "support", "share", "primitives"), f"phase '{name}'")
    support = entry.get("support")
    if support not in SUPPORTS:
        raise ConfigurationError(f"phase '{name}': support = {support!r}: valid: {', '.join(SUPPORTS)}")
    share = _number(entry.get("share"), f"phase '{name}': share")
    return Phase(name, support == "single", share, tuple(_primitive(p, name) for p in entry["primitives"]))


def _primitive(entry: Any, phase: str) -> Primitive:
    if not isinstance(entry, dict) or "primitive" not in entry:
        raise ConfigurationError(f"phase '{phase}': a primitive needs a name, as in {{primitive: bend}}")
    word = str(entry["primitive"])
    if word not in PRIMITIVES:
        raise UnknownNameError("primitive", word, PRIMITIVES, f"phase '{phase}'")
    kind = PRIMITIVES[word]
    fields = [field.name for field in dataclasses.fields(kind)]
    values: dict[str, float] = {}
    for key, value in entry.items():
        if key == "primitive":
            continue
        if key not in fields:
            raise UnknownNameError("parameter", str(key), fields, f"phase '{phase}', {word}")
        values[key] = _number(value, f"phase '{phase}', {word}: {key}")
    return kind(**values)


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigurationError(f"{where} = {value!r}: needs a number")
    if abs(value) > _LARGEST_NUMBER:  # what is no number at all is told by whoever uses it
        raise ConfigurationError(
            f"{where} = {value if isinstance(value, float) else 'a whole number'}: "
            f"needs a number up to {_LARGEST_NUMBER:g}"
        )
    return float(value)
