"""Configuration as frozen dataclasses: each value has a unit, a meaning and a range, stated once.

A node's ROS parameters, the blocks of `config/follower.yaml` and the arguments of the
ROS-free chain are all made from the same dataclass, so they cannot drift apart.
Nested dataclasses become dotted names (`motor.resistance`).
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, TypeVar

from follower_humanoid.errors import ConfigurationError, UnknownNameError

ConfigT = TypeVar("ConfigT")
LARGEST_INTEGER = 2**63 - 1  # of a ROS parameter


def parameter(
    default: Any,
    meaning: str,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
    read_only: bool = True,
    path: bool = False,
) -> Any:
    """A dataclass field with what a user must know about it.

    Args:
        default: Value when nothing else is said; its type is the parameter's type
            (bool, int, float, str, or a tuple of float).
        meaning: One line for the YAML file and `ros2 param describe`.
        unit: SI unit, empty for pure numbers.
        low, high: Inclusive range of numbers (of every entry of a tuple).
        choices: Valid words of a text parameter.
        read_only: False where changing it on a running node is safe.
        path: True where the text names a file or folder: absolute, or below the working directory.
    """
    metadata = {
        "meaning": meaning, "unit": unit, "low": low, "high": high,
        "choices": choices, "read_only": read_only, "path": path,
    }
    return dataclasses.field(default=default, metadata=metadata)


@dataclass(frozen=True)
class ParameterInfo:
    """One parameter of a configuration dataclass, under its dotted name."""

    name: str
    default: Any
    meaning: str
    unit: str
    low: float | None
    high: float | None
    choices: tuple[str, ...]
    read_only: bool
    path: bool = False

    def checked(self, value: Any, where: str = "") -> Any:
        """The value in this parameter's type.

        Raises:
            ConfigurationError: Wrong type, not finite, out of range or not a valid word.
        """
        label = f"{where}: {self.name}" if where else self.name
        if isinstance(self.default, tuple):
            if isinstance(value, str | bytes) or not hasattr(value, "__len__"):
                raise ConfigurationError(f"{label} = {value!r}: needs {len(self.default)} numbers")
            if len(value) != len(self.default):
                raise ConfigurationError(f"{label} has {len(value)} entries: needs {len(self.default)}")
            return tuple(self._number(v, float, label) for v in value)
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise ConfigurationError(f"{label} = {value!r}: needs true or false")
            return value
        if isinstance(self.default, int | float):
            return self._number(value, type(self.default), label)
        if not isinstance(value, str):
            raise ConfigurationError(f"{label} = {value!r}: needs a text")
        if self.choices and value not in self.choices:
            raise ConfigurationError(f"{label} = '{value}': valid: {', '.join(self.choices)}")
        if self.path and ".." in PurePath(value).parts and not PurePath(value).is_absolute():
            raise ConfigurationError(f"{label} = '{value}': valid: an absolute path, or one without '..'")
        if self.path and "\0" in value:
            raise ConfigurationError(f"{label}: a path cannot contain a null character")
        return value

    def _number(self, value: Any, kind: type, label: str) -> Any:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigurationError(f"{label} = {value!r}: needs a number")
        if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
            raise ConfigurationError(f"{label}: a whole number beyond ±{LARGEST_INTEGER}")
        if not math.isfinite(value):
            raise ConfigurationError(f"{label} = {value}: needs a finite number")
        if kind is int and value != int(value):
            raise ConfigurationError(f"{label} = {value}: needs a whole number")
        low = -math.inf if self.low is None else self.low
        high = math.inf if self.high is None else self.high
        if not low <= value <= high:
            raise ConfigurationError(f"{label} = {value}: valid: {low} to {high} {self.unit}".rstrip())
        return kind(value)


def parameters_of(config_class: type, prefix: str = "") -> Iterator[ParameterInfo]:
    """Every parameter of a configuration dataclass, nested ones under dotted names."""
    hints = typing.get_type_hints(config_class)
    for field in dataclasses.fields(config_class):
        kind = hints[field.name]
        if dataclasses.is_dataclass(kind):
            yield from parameters_of(typing.cast(type, kind), f"{prefix}{field.name}.")
        else:
            yield ParameterInfo(name=prefix + field.name, default=field.default, **field.metadata)


def build(config_class: type[ConfigT], values: Mapping[str, Any], where: str = "") -> ConfigT:
    """A configuration from dotted names; what is left out keeps its default.

    Raises:
        ConfigurationError: A value is unusable, or a name does not exist.
    """
    known = {info.name: info for info in parameters_of(config_class)}
    for name in values:
        if name not in known:
            raise UnknownNameError("parameter", name, known, where or config_class.__name__)
    checked = {name: known[name].checked(value, where) for name, value in values.items()}
    return _assemble(config_class, checked, "")


def values_of(config: Any, prefix: str = "") -> dict[str, Any]:
    """The inverse of `build`: dotted names to values."""
    values: dict[str, Any] = {}
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value) and not isinstance(value, type | types.ModuleType):
            values.update(values_of(value, f"{prefix}{field.name}."))
        else:
            values[prefix + field.name] = value
    return values


def _assemble(config_class: type[ConfigT], checked: Mapping[str, Any], prefix: str) -> ConfigT:
    hints = typing.get_type_hints(config_class)
    arguments: dict[str, Any] = {}
    for field in dataclasses.fields(typing.cast(Any, config_class)):
        name = prefix + field.name
        kind = hints[field.name]
        if dataclasses.is_dataclass(kind):
            arguments[field.name] = _assemble(typing.cast(type, kind), checked, f"{name}.")
        elif name in checked:
            arguments[field.name] = checked[name]
    return config_class(**arguments)
