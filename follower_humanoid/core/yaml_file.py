"""Reading a YAML file that a person wrote: only plain data, and every fault named with file and line.

Stricter than `yaml.safe_load` where that would surprise: a name given twice, an alias (which can
blow up a small file into a huge one) and a tag are faults; `5e-3` is a number and `1:30` is a text,
as in ROS 2's own parameter files.
"""

from __future__ import annotations

import re
from collections.abc import Hashable
from pathlib import Path
from typing import Any, cast

import yaml

from follower_humanoid.errors import ConfigurationError

_LARGEST_FILE = 1_000_000  # bytes; a larger one is not a file that a person wrote


class _Fault(Exception):
    """Valid YAML that is not plain data."""

    def __init__(self, problem: str, mark: Any) -> None:
        super().__init__(problem)
        self.line = mark.line + 1


class _PlainLoader(yaml.SafeLoader):
    """Safe YAML of mappings, lists, texts, numbers, true and false."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Refuses aliases and tags; all else is read as usual."""
        event = cast(Any, self).peek_event()  # untyped in the stubs
        if isinstance(event, yaml.AliasEvent):
            raise _Fault("aliases are not allowed", event.start_mark)
        if getattr(event, "tag", None) is not None:
            raise _Fault("tags are not allowed", event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Refuses a name given twice: silently keeping one of them would hide the other."""
        seen: set[Any] = set()
        for key_node, _ in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise _Fault("a name must be a plain text", key_node.start_mark)
            if key_node.value in seen:
                raise _Fault(f"'{key_node.value}' is given twice", key_node.start_mark)
            seen.add(key_node.value)
        return super().construct_mapping(node, deep)


_PlainLoader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("int", r"[-+]?(0|[1-9][0-9]*)", "-+0123456789"),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
     "-+0123456789."),
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
):  # fmt: skip
    _PlainLoader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), _first)


def read_yaml(path: Path | str) -> Any:
    """The content of one YAML file.

    Returns:
        Mappings, lists, texts, numbers, booleans and None; None for an empty file.

    Raises:
        ConfigurationError: The file cannot be read or is not plain YAML; one line with file and line.
    """
    path = Path(path)
    try:
        if not path.exists():
            raise ConfigurationError(f"{path}: no such file")
        if not path.is_file():
            raise ConfigurationError(f"{path}: not a file")
        if path.stat().st_size > _LARGEST_FILE:
            raise ConfigurationError(f"{path}: larger than {_LARGEST_FILE} bytes")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigurationError(f"{path}: not UTF-8 text") from error
    return parse_yaml(text, str(path))


def parse_yaml(text: str, where: str) -> Any:
    """The content of a YAML text, by the same rules; `where` names its origin in messages.

    Raises:
        ConfigurationError: It is not plain YAML, or too long.
    """
    if len(text) > _LARGEST_FILE:
        raise ConfigurationError(f"{where}: longer than {_LARGEST_FILE} characters")
    try:
        return yaml.load(text, _PlainLoader)
    except _Fault as error:
        raise ConfigurationError(f"{where}:{error.line}: {error}") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        fault = error.problem or error.context
        raise ConfigurationError(f"{where}{line}: not valid YAML: {fault}") from error
    except yaml.YAMLError as error:
        raise ConfigurationError(f"{where}: not valid YAML: {' '.join(str(error).split())}") from error
    except RecursionError as error:
        raise ConfigurationError(f"{where}: nested too deeply") from error
    except ValueError as error:  # an integer of thousands of digits
        raise ConfigurationError(f"{where}: not valid YAML: {error}") from error


def read_value(text: str, where: str) -> Any:
    """One value from a command line, by the same rules; what is no YAML is a text.

    Raises:
        ConfigurationError: It is nested too deeply or a number of thousands of digits.
    """
    try:
        return yaml.load(text, _PlainLoader)
    except (_Fault, yaml.YAMLError):
        return text
    except RecursionError as error:
        raise ConfigurationError(f"{where}: nested too deeply") from error
    except ValueError as error:
        raise ConfigurationError(f"{where}: {error}") from error
