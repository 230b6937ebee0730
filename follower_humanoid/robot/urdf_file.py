"""Reading a robot description that may come from anywhere: one well-formed file that needs no other."""

from __future__ import annotations

import math
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from follower_humanoid.errors import ConfigurationError

_LARGEST_FILE = 2_000_000  # bytes, thirty times this robot's
_DEEPEST = 50
_PIECE = 4096  # characters that are parsed before the depth is looked at
# Attributes that hold numbers, wherever they stand.
_NUMERIC = frozenset(
    "xyz rpy ixx ixy ixz iyy iyz izz radius length size lower upper effort velocity damping friction".split()
)
_LARGEST_NUMBER = 1e9
_NAMES = {"link": ("name",), "joint": ("name",), "parent": ("link",), "child": ("link",), "mimic": ("joint",)}
_PLACE = re.compile(r": line (\d+), column \d+$")


def read_urdf(path: Path) -> str:
    """The text of a robot description.

    Raises:
        ConfigurationError: Not a file, too large, not well-formed, with a document type (whose
            entities can name other files or grow without bound), with a number that is none or
            too large for a robot, a link or joint whose name has spaces or unprintable characters,
            or with the name of another file outside its own folder.
    """
    if not os.path.isfile(path):  # a device or a pipe would be read without end
        reason = "not a file" if os.path.exists(path) else "no such file"
        raise ConfigurationError(f"URDF {path} cannot be read: {reason}")
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise ConfigurationError(f"URDF {path} is larger than {_LARGEST_FILE} bytes")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(f"URDF {path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ConfigurationError(f"URDF {path} cannot be read: not UTF-8 text") from None
    if "<!DOCTYPE" in text:
        raise ConfigurationError(f"URDF {path} is malformed: a document type is not allowed")
    root = _parsed(text, path)
    for element in root.iter():
        _check_numbers(element, path)
        _check_names(element, path)
    for name in _other_files(root):
        if not name.startswith("package://") and (Path(name).is_absolute() or ".." in Path(name).parts):
            raise ConfigurationError(f"URDF {path} names '{name}', a file outside its own folder")
    return text


def _parsed(text: str, path: Path) -> ET.Element:
    """The tree; parsed piece by piece, so that one too deep is never built."""
    parser: Any = ET.XMLPullParser(("start", "end"))
    depth = 0
    root: ET.Element | None = None
    try:
        for begin in range(0, len(text), _PIECE):
            parser.feed(text[begin : begin + _PIECE])
            for event, element in parser.read_events():
                root = element if root is None else root
                depth += 1 if event == "start" else -1
                if depth > _DEEPEST:
                    raise ConfigurationError(f"URDF {path} is malformed: nested too deeply")
        parser.close()
    except ET.ParseError as error:
        reason = _PLACE.sub(r" in line \1", str(error))
        raise ConfigurationError(f"URDF {path} is malformed: {reason}") from None
    if root is None:
        raise ConfigurationError(f"URDF {path} is malformed: it is empty")
    return root


def _check_numbers(element: ET.Element, path: Path) -> None:
    for key, text in element.attrib.items():
        if key not in _NUMERIC and not (element.tag == "mass" and key == "value"):
            continue
        for word in text.split():
            try:
                value = float(word)
            except ValueError:
                value = math.nan
            if not abs(value) <= _LARGEST_NUMBER:
                raise ConfigurationError(
                    f"URDF {path}: {element.tag} {key} = '{word[:40]}': "
                    f"needs a number up to {_LARGEST_NUMBER:g}"
                )


def _check_names(element: ET.Element, path: Path) -> None:
    """Names become frames, columns and words in messages; parsers differ in what they make of spaces."""
    for key in _NAMES.get(element.tag, ()):
        name = element.attrib.get(key, "")
        if not name.isprintable() or any(character.isspace() for character in name):
            raise ConfigurationError(
                f"URDF {path}: {element.tag} {key} = {name[:40]!r}: needs a name without spaces"
            )


def _other_files(root: ET.Element) -> Iterator[str]:
    for element in root.iter():
        if "filename" in element.attrib:
            yield element.attrib["filename"]
