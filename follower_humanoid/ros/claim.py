"""The names of a robot's nodes, claimed on this machine: discovery takes time, the kernel knows at once."""

from __future__ import annotations

import hashlib
import socket
from collections.abc import Sequence

from follower_humanoid.errors import ConfigurationError


class Claim:
    """Holds the names of nodes in a ROS domain until it is closed, or its process is gone.

    A name is an abstract Unix socket: no file is left behind, it is gone with the process however that ends,
    and it reaches as far as the loopback network over which robots of one machine would meet. Without such
    sockets nothing is claimed.
    """

    def __init__(self, domain: int, namespace: str, nodes: Sequence[str]) -> None:
        """Claims all names or none, in the given order: of two who begin together one gets them.

        Args:
            domain: ROS domain.
            namespace: Without a leading slash.
            nodes: Names of nodes.

        Raises:
            ConfigurationError: Somebody else holds one.
        """
        self._held: list[socket.socket] = []
        if not hasattr(socket, "AF_UNIX"):
            return
        for node in nodes:
            holder = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            self._held.append(holder)
            try:
                holder.bind(_address(domain, namespace, node))
            except FileNotFoundError:  # abstract names are Linux's own
                self.close()
                return
            except OSError:
                self.close()
                raise already_runs(domain, namespace, [node]) from None

    def close(self) -> None:
        """Gives the names back."""
        while self._held:
            self._held.pop().close()


def already_runs(domain: int, namespace: str, nodes: Sequence[str]) -> ConfigurationError:
    """What to tell whoever wants to start nodes of names that are taken."""
    return ConfigurationError(
        f"another robot runs in ROS domain {domain} under namespace '/{namespace}': {', '.join(nodes)}; "
        "valid: another --namespace, or another ROS_DOMAIN_ID"
    )


def _address(domain: int, namespace: str, node: str) -> bytes:
    """Of any length in, short enough for the kernel out."""
    name = f"{domain}/{namespace}/{node}".encode()
    return b"\0follower_humanoid/" + hashlib.sha256(name).hexdigest().encode()
