"""Messages from YAML and to YAML, for any type that is installed."""

from __future__ import annotations

import array
import importlib
import math
import re
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import yaml

from follower_humanoid.command_line import UsageError
from follower_humanoid.ros2_front.verbs import CommandError

_TEXT = re.compile(r"^w?string(?:<(\d+)>)?$")
_SEQUENCE = re.compile(r"^sequence<(.+?)(?:, *(\d+))?>$")
_ARRAY = re.compile(r"^(.+)\[(\d+)\]$")
_INTEGER = re.compile(r"^(u?)int(8|16|32|64)$")
_FLOATS = ("float", "double", "long double")
_LARGEST_FLOAT = 3.4028235677973366e38  # beyond it rounding to single precision gives infinity
_TRUNCATED = "..."


def interface(type_name: str, kind: str = "msg") -> Any:
    """The class of `package/msg/Type`; `package/Type` is understood too.

    Args:
        type_name: As people type it.
        kind: `msg` or `srv`.

    Raises:
        CommandError: Not installed.
        UsageError: Not a name of a type.
    """
    parts = type_name.split("/")
    if len(parts) == 2:
        parts.insert(1, kind)
    if len(parts) != 3 or parts[1] != kind or not all(part.isidentifier() for part in parts):
        raise UsageError(f"'{type_name}' is no type: needs package/{kind}/Type")
    try:
        module = importlib.import_module(f"{parts[0]}.{kind}")
    except ImportError:
        raise CommandError(f"type '{type_name}': package {parts[0]} is not installed") from None
    if not hasattr(module, parts[2]):
        raise CommandError(f"type '{type_name}': package {parts[0]} has no such type")
    return getattr(module, parts[2])


def read_values(text: str) -> dict[str, Any]:
    """The mapping in a YAML text.

    Raises:
        UsageError: Not YAML, or no mapping.
    """
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise UsageError(f"values are no YAML: {error}") from None
    if values is None or values == "":
        return {}
    if not isinstance(values, dict):
        raise UsageError(f"values need to be a mapping such as '{{data: 1}}', not {text!r}")
    return values


def fill(message: Any, values: Mapping[str, Any], where: str = "") -> None:
    """Sets the fields that are named; a header may be `auto`, a stamp `now`.

    Raises:
        UsageError: A field does not exist, or a value does not fit it.
    """
    kinds = message.get_fields_and_field_types()
    for name, value in values.items():
        path = f"{where}{name}"
        if name not in kinds:
            valid = ", ".join(kinds) or "none"
            raise UsageError(f"no field '{path}' in {type_name_of(type(message))}; valid: {valid}")
        try:
            setattr(message, name, _value(getattr(message, name), kinds[name], value, path))
        except (AssertionError, OverflowError, TypeError, ValueError) as error:
            raise UsageError(f"{path} = {value!r}: {error or 'out of range'}") from None


def type_name_of(message_class: Any) -> str:
    """`package/msg/Type`."""
    package, kind, *_ = message_class.__module__.split(".")
    return f"{package}/{kind}/{message_class.__name__}"


def _value(old: Any, kind: str, value: Any, path: str) -> Any:
    if match := _SEQUENCE.match(kind) or _ARRAY.match(kind):
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Sequence):
            raise UsageError(f"{path} = {value!r}: needs a list")
        length = match.group(2)
        if length and _ARRAY.match(kind) and len(value) != int(length):
            raise UsageError(f"{path} has {len(value)} entries: needs {length}")
        if length and len(value) > int(length):
            raise UsageError(f"{path} has {len(value)} entries: at most {length}")
        return [_single(None, match.group(1), v, f"{path}[{i}]") for i, v in enumerate(value)]
    return _single(old, kind, value, path)


def _single(old: Any, kind: str, value: Any, path: str) -> Any:
    if "/" in kind:
        inner = old if old is not None else interface(kind)()
        if kind == "std_msgs/Header" and value == "auto":
            value = {"stamp": "now"}
        if kind == "builtin_interfaces/Time" and value == "now":
            seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
            value = {"sec": seconds, "nanosec": nanoseconds}
        if not isinstance(value, Mapping):
            raise UsageError(f"{path} = {value!r}: needs a mapping, fields of {kind}")
        fill(inner, value, f"{path}.")
        return inner
    if text := _TEXT.match(kind):
        written = value if isinstance(value, str) else str(value)
        if text.group(1) and len(written) > int(text.group(1)):
            raise UsageError(f"{path} = {value!r}: at most {text.group(1)} characters")
        return written
    if kind == "boolean":
        if not isinstance(value, bool):
            raise UsageError(f"{path} = {value!r}: needs true or false")
        return value
    return _number(kind, value, path)


def _number(kind: str, value: Any, path: str) -> Any:
    """Checked here: the setters of messages let through what does not fit, and sending it would crash."""
    if isinstance(value, bool):
        raise UsageError(f"{path} = {value!r}: needs a number")
    if kind in _FLOATS:
        number = float(value)
        if kind == "float" and math.isfinite(number) and abs(number) >= _LARGEST_FLOAT:
            raise UsageError(f"{path} = {value!r}: too large for float32")
        return number
    if isinstance(value, float) and value != int(value):
        raise UsageError(f"{path} = {value!r}: needs a whole number")
    whole = int(value)
    match = _INTEGER.match(kind)
    unsigned, bits = (bool(match.group(1)), int(match.group(2))) if match else (True, 8)
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    if not low <= whole <= high:
        raise UsageError(f"{path} = {value!r}: valid: {low} to {high}")
    return bytes([whole]) if kind == "octet" else whole


def plain(value: Any, longest: int | None = None, arrays: bool = True, texts: bool = True) -> Any:
    """A message, or a part of one, as YAML can write it.

    Args:
        value: The message.
        longest: Entries of a list and characters of a text that are shown; None: all.
        arrays, texts: Whether the content of lists and texts is shown at all.
    """
    if hasattr(value, "get_fields_and_field_types"):
        kinds = value.get_fields_and_field_types()
        shown = {}
        for name, kind in kinds.items():
            inner = getattr(value, name)
            if not arrays and (_SEQUENCE.match(kind) or _ARRAY.match(kind)):
                shown[name] = f"<{kind}: {len(inner)} entries>"
            else:
                shown[name] = plain(inner, longest, arrays, texts)
        return shown
    if isinstance(value, bytes):
        return value[0] if len(value) == 1 else list(value)
    if isinstance(value, str):
        if not texts:
            return f"<string: {len(value)} characters>"
        return value if longest is None or len(value) <= longest else value[:longest] + _TRUNCATED
    if isinstance(value, np.ndarray | array.array):
        value = value.tolist()
    if isinstance(value, list | tuple):
        part = value if longest is None else value[:longest]
        shown_part = [plain(entry, longest, arrays, texts) for entry in part]
        return shown_part if len(part) == len(value) else [*shown_part, _TRUNCATED]
    return value.item() if isinstance(value, np.generic) else value


def yaml_text(value: Any, flow: bool = False) -> str:
    """YAML in the order of the fields."""
    text: str = yaml.safe_dump(
        value, sort_keys=False, allow_unicode=True, default_flow_style=flow, width=float("inf")
    )
    return text.removesuffix("...\n")


def field_of(message: Any, path: str) -> Any:
    """The part of a message that a path such as `wrench.force.x` or `position[3]` names.

    Raises:
        UsageError: There is no such part.
    """
    value = message
    for name, index in re.findall(r"([A-Za-z_]\w*)|\[(-?\d+)\]", path):
        try:
            value = getattr(value, name) if name else value[int(index)]
        except (AttributeError, IndexError, TypeError):
            raise UsageError(f"no field '{path}' in {type_name_of(type(message))}") from None
    return value
