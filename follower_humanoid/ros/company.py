"""Whether others of a ROS domain are on this machine, known at once: by the ports they listen at."""

from __future__ import annotations

from pathlib import Path

_TABLES = ("/proc/net/udp", "/proc/net/udp6")
_BASE, _PER_DOMAIN, _FIRST = 7400, 250, 10  # DDSI-RTPS 2.5, 9.6.1.1: default port numbers of participants
_OWN = 2  # ports of one participant: discovery and data


def has_company(domain: int) -> bool:
    """True where more than one participant listens at the domain's ports; false where nobody can tell."""
    first = _BASE + _PER_DOMAIN * domain
    ports = {port for table in _TABLES for port in _local_ports(Path(table))}
    return len(ports & set(range(first + _FIRST, first + _PER_DOMAIN))) > _OWN


def _local_ports(table: Path) -> list[int]:
    try:
        lines = table.read_text(encoding="ascii").splitlines()[1:]
    except OSError:
        return []
    return [int(line.split()[1].rpartition(":")[2], 16) for line in lines]
