"""Writes `config/follower.yaml` from the configuration dataclasses: a block per node, a line per parameter.

    python -m follower_humanoid.graph.config_writer config/follower.yaml

The dataclasses hold the defaults; the file repeats them for people to read and copy, and a test keeps
both equal.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from follower_humanoid.core.config import ParameterInfo
from follower_humanoid.graph.node_configs import (
    config_classes,
    node_names,
    node_parameters,
    shared_parameters,
)
from follower_humanoid.graph.wiring import NODES

_HEAD = """\
# Parameters of every node with their defaults, [unit], meaning and range. Generated: to change a value, write
# the line into a file of your own (any subset of blocks and lines) and give it to `bringup --params FILE`.
"""
_WIDEST = 44  # comments line up, but one long value does not push them all away


def config_text() -> str:
    """The whole parameter file: a block for what all nodes share, then one block per node."""
    shared = shared_parameters()
    blocks = [_block("/**", "All nodes", shared)]
    for node in node_names():
        own = {name: info for name, info in node_parameters(node).items() if name not in shared}
        if own:
            blocks.append(_block(node, _purpose(node), own))
    return "\n".join([_HEAD, *blocks])


def _block(node: str, purpose: str, parameters: dict[str, ParameterInfo]) -> str:
    lines = [f"{name}: {_value(info.default)}" for name, info in parameters.items()]
    width = max(len(line) for line in lines if len(line) <= _WIDEST)
    comments = [_comment(info) for info in parameters.values()]
    body = [f"    {line:{width}}  # {comment}" for line, comment in zip(lines, comments, strict=True)]
    return "\n".join([f"# {purpose}", f"{node}:", "  ros__parameters:", *body, ""])


def _purpose(node: str) -> str:
    """What the node's component, or else its configuration, says of itself."""
    speaker = NODES[node].component_class() if node in NODES else config_classes(node)[0]
    line = (speaker.__doc__ or node).splitlines()[0].removeprefix("Component: ").rstrip(".")
    return line[:1].upper() + line[1:]


def _value(value: Any) -> str:
    """A value as ROS 2 reads it: a float always has a point, or it would be declared an integer."""
    if isinstance(value, tuple):
        return f"[{', '.join(_value(entry) for entry in value)}]"
    if isinstance(value, bool | str):
        return json.dumps(value, ensure_ascii=False)
    text = repr(value)
    if isinstance(value, float) and "." not in text:
        mantissa, _, exponent = text.partition("e")
        return f"{mantissa}.0e{exponent}"
    return text


def _comment(info: ParameterInfo) -> str:
    """Unit, meaning and valid values in one line."""
    kind = info.default[0] if isinstance(info.default, tuple) and info.default else info.default
    is_number = isinstance(kind, int | float) and not isinstance(kind, bool)
    unit = f"[{info.unit or '-'}] " if is_number or info.unit else ""
    text = f"{unit}{info.meaning}"
    if info.choices:
        text += f"; one of {', '.join(info.choices)}"
    if info.low is not None and info.high is not None:
        text += f"; {info.low:g} to {info.high:g}"
    elif info.low is not None:
        text += f"; at least {info.low:g}"
    elif info.high is not None:
        text += f"; at most {info.high:g}"
    return text


def main() -> int:
    """Writes the file named on the command line, not stdout: the physics engine prints there on import."""
    if len(sys.argv) != 2:
        sys.stderr.write("usage: python -m follower_humanoid.graph.config_writer FILE\n")
        return 2
    Path(sys.argv[1]).write_text(config_text(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
