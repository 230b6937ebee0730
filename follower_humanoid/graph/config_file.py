"""ROS 2 parameter files: read, laid over one another, and checked against the dataclasses.

A file has blocks `node: {ros__parameters: {name: value}}`. A block's name may be the bare node
name, a full name with namespace, or a pattern of ROS 2 (`*` one part, `**` any number of parts):
`/**` sets a parameter of every node that has it. Nested mappings and dotted names mean the same.
Within a file an exact name wins over a pattern; of several files the later one wins.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from follower_humanoid.core.config import ParameterInfo, build, parameters_of
from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError, UnknownNameError
from follower_humanoid.graph.node_configs import config_classes, node_names, node_parameters

_KEY = "ros__parameters"

Parameters = dict[str, dict[str, Any]]


def load_parameters(paths: Iterable[Path | str], namespace: str = "") -> Parameters:
    """Merges parameter files; later ones win.

    Args:
        paths: ROS 2 parameter files.
        namespace: Namespace the nodes run under, for blocks that name it.

    Returns:
        Node → dotted parameter name → value in the parameter's own type; only what the files set.

    Raises:
        ConfigurationError: A file is unreadable, names a node or parameter that does not exist, or
            sets a value that its node would reject. One line: file, node, parameter, value, what is valid.
    """
    merged: Parameters = {}
    files = [Path(path) for path in paths]
    for path in files:
        for node, values in _read(path, namespace).items():
            merged.setdefault(node, {}).update(values)
    where = ", ".join(str(path) for path in files)
    for node, values in merged.items():
        _check_together(node, values, where)
    return merged


def _read(path: Path, namespace: str) -> Parameters:
    """One file's values per node, patterns resolved and every value checked."""
    content = read_yaml(path)
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise ConfigurationError(f"{path}: needs blocks 'node: {{{_KEY}: {{name: value}}}}'")
    blocks = list(_blocks(content, "", path))
    # A pattern is a default for many: it comes first, so that an exact name wins wherever it stands.
    blocks.sort(key=lambda block: "*" not in block[0])
    merged: Parameters = {}
    for key, values in blocks:
        nodes = [node for node in node_names() if _matches(key, node, namespace)]
        if not nodes:
            raise UnknownNameError("node", key, node_names(), path)
        known = {node: node_parameters(node) for node in nodes}
        for name, value in values.items():
            for node, checked in _checked(known, name, value, f"{path}: {key}").items():
                merged.setdefault(node, {})[name] = checked
    return merged


def _blocks(content: dict[Any, Any], prefix: str, path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every `ros__parameters` block with the name of its node; namespaces may be nested."""
    for key, inner in content.items():
        name = f"{prefix}{key}"
        if not isinstance(inner, dict):
            block = prefix.rstrip("/") or name
            raise ConfigurationError(f"{path}: {block}: needs a block '{_KEY}: {{name: value}}'")
        if _KEY in inner:
            values = inner[_KEY]
            others = [str(other) for other in inner if other != _KEY]
            if others:
                raise ConfigurationError(f"{path}: {name}: '{others[0]}' stands beside '{_KEY}', not in it")
            if values is not None and not isinstance(values, dict):
                raise ConfigurationError(f"{path}: {name}: {_KEY} needs 'name: value' lines")
            yield name, _flat(values or {}, f"{path}: {name}")
        elif inner:
            yield from _blocks(inner, f"{name}/", path)
        else:
            raise ConfigurationError(f"{path}: {name}: needs a block '{_KEY}: {{name: value}}'")


def _flat(values: dict[Any, Any], where: str, prefix: str = "") -> dict[str, Any]:
    """Nested mappings as dotted names."""
    flat: dict[str, Any] = {}
    for key, value in values.items():
        name = f"{prefix}{key}"
        inner = _flat(value, where, f"{name}.") if isinstance(value, dict) else {name: value}
        twice = sorted(inner.keys() & flat.keys())
        if twice:
            raise ConfigurationError(f"{where}: {twice[0]} is given twice")
        flat.update(inner)
    return flat


def _matches(key: str, node: str, namespace: str) -> bool:
    """Whether a block's name means this node; a name without a leading slash leaves the namespace open."""
    inside = [part for part in namespace.split("/") if part]
    wanted = [part for part in key.split("/") if part]
    if key.startswith("/"):
        return _parts_match(wanted, [*inside, node])
    return _parts_match(wanted, [node]) or _parts_match(wanted, [*inside, node])


def _parts_match(wanted: list[str], parts: list[str]) -> bool:
    if not wanted:
        return not parts
    if wanted[0] == "**":
        return _parts_match(wanted[1:], parts) or (bool(parts) and _parts_match(wanted, parts[1:]))
    return bool(parts) and wanted[0] in ("*", parts[0]) and _parts_match(wanted[1:], parts[1:])


def _checked(
    known: dict[str, dict[str, ParameterInfo]], name: str, value: Any, where: str
) -> dict[str, Any]:
    """Node → checked value, for those of the nodes that have the parameter; one at least must."""
    having = {node: infos[name] for node, infos in known.items() if name in infos}
    if not having:
        valid = {valid for infos in known.values() for valid in infos}
        raise UnknownNameError("parameter", name, valid, where)
    try:
        return {node: info.checked(value, where) for node, info in having.items()}
    except OverflowError as error:  # a whole number beyond the floating-point range
        raise ConfigurationError(f"{where}: {name}: number too large") from error


def _check_together(node: str, values: dict[str, Any], where: str) -> None:
    """Finds what only the values together get wrong, such as a lower threshold above the upper one."""
    for config_class in config_classes(node):
        own = {info.name for info in parameters_of(config_class)}
        try:
            build(config_class, {name: value for name, value in values.items() if name in own})
        except ConfigurationError as error:
            raise ConfigurationError(f"{where}: {node}: {error}") from error

