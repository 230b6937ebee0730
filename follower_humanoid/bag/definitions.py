"""Message definitions and type hashes, as a bag stores them, from the installed message packages."""

from __future__ import annotations

import functools
import json
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from follower_humanoid.errors import ConfigurationError

_SEPARATOR = "=" * 80
_PRIMITIVES = frozenset(
    "bool byte char float32 float64 int8 uint8 int16 uint16 int32 uint32 int64 uint64 string wstring".split()
)
# A field line: type, perhaps bounded or an array, then a name; a constant has '=' after the name.
_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[a-z]\w*\s*(?![\w\s]*=)")
# Bags carry transforms also where tf2_msgs is not installed; there are no wheels of it.
_OWN_TEXTS = {"tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n"}
_OWN_HASHES = {
    "tf2_msgs/msg/TFMessage": "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
}


@dataclass(frozen=True)
class Definition:
    """What a reader who knows nothing of ROS needs to decode a message.

    Attributes:
        type_name: `package/msg/Type`.
        text: The root definition followed by every definition it depends on, each once.
        type_hash: RIHS hash of the type, empty where the installation does not state it.
    """

    type_name: str
    text: str
    type_hash: str


@functools.cache
def definition(type_name: str) -> Definition:
    """The definition of `package/msg/Type`.

    Raises:
        ConfigurationError: The message package is not installed.
    """
    parts = [_text(type_name)]
    known = {type_name}
    pending = _dependencies(type_name, parts[0])
    while pending:
        dependency = pending.pop(0)
        if dependency in known:
            continue
        known.add(dependency)
        text = _text(dependency)
        package, _, name = dependency.partition("/msg/")
        parts.append(f"{_SEPARATOR}\nMSG: {package}/{name}\n{text}")
        pending += _dependencies(dependency, text)
    return Definition(type_name, "\n".join(part.rstrip("\n") for part in parts) + "\n", _type_hash(type_name))


def _dependencies(type_name: str, text: str) -> list[str]:
    package = type_name.partition("/")[0]
    found = []
    for line in text.splitlines():
        match = _FIELD.match(line.partition("#")[0])
        if match is None or match.group(1) in _PRIMITIVES:
            continue
        owner, _, name = match.group(1).rpartition("/")
        found.append(f"{owner.partition('/')[0] or package}/msg/{name}")
    return found


def _text(type_name: str) -> str:
    if type_name in _OWN_TEXTS:
        return _OWN_TEXTS[type_name]
    return _share_file(type_name, ".msg").read_text(encoding="utf-8")


def _type_hash(type_name: str) -> str:
    if type_name in _OWN_HASHES:
        return _OWN_HASHES[type_name]
    try:
        described = json.loads(_share_file(type_name, ".json").read_text(encoding="utf-8"))
    except ConfigurationError:
        return ""
    for entry in described["type_hashes"]:
        if entry["type_name"] == type_name:
            return str(entry["hash_string"])
    return ""


def _share_file(type_name: str, suffix: str) -> Path:
    package, _, name = type_name.partition("/msg/")
    prefixes = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    for prefix in (*prefixes, Path(sys.prefix)):
        path = prefix / "share" / package / "msg" / f"{name}{suffix}"
        if path.is_file():
            return path
    raise ConfigurationError(
        f"message type {type_name} is not installed (no {name}{suffix} of package {package})"
    )
