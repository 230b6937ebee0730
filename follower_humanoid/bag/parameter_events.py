"""Changed parameters as they lie in an `rcl_interfaces/msg/ParameterEvent`."""

from __future__ import annotations

from typing import Any

from follower_humanoid.bag.cdr import CdrError, Cursor

Values = dict[str, Any]
# Kinds of values, from rcl_interfaces/msg/ParameterType; 0 is "not set", 5 a sequence of bytes.
_BOOL, _INTEGER, _DOUBLE, _STRING = 1, 2, 3, 4
_BOOLS, _INTEGERS, _DOUBLES, _STRINGS = 6, 7, 8, 9


def parameter_event(cursor: Cursor) -> tuple[int, str, Values]:
    """Stamp [ns], name of the node without its namespace, and name → value of what was changed.

    Raises:
        CdrError: The bytes are not such a message.
    """
    stamp = cursor.stamp()
    node = cursor.text().rpartition("/")[2]
    _new, changed, _deleted = (_parameters(cursor) for _ in range(3))
    return stamp, node, changed


def _parameters(cursor: Cursor) -> Values:
    values: Values = {}
    for _ in range(cursor.length()):
        name = cursor.text()
        values[name] = _value(cursor)
    return values


def _value(cursor: Cursor) -> Any:
    """The value of the kind that is set; all kinds are in the message."""
    kind = cursor.byte()
    found: dict[int, Any] = {_BOOL: bool(cursor.byte())}
    found[_INTEGER] = cursor.long_integers(1)[0]
    found[_DOUBLE] = float(cursor.doubles("double", 1)[0])
    found[_STRING] = cursor.text()
    cursor.skip(cursor.length())
    found[_BOOLS] = tuple(bool(cursor.byte()) for _ in range(cursor.bounded(cursor.length())))
    found[_INTEGERS] = cursor.long_integers(cursor.bounded(cursor.length()))
    found[_DOUBLES] = tuple(cursor.doubles("doubles", cursor.bounded(cursor.length())).tolist())
    found[_STRINGS] = cursor.texts()
    if kind not in found:
        raise CdrError("a parameter without a value")
    return found[kind]
