"""The names of a robot's nodes, claimed on this machine: discovery takes time, the kernel knows at once."""

from __future__ import annotations

import errno
import hashlib
import socket
from collections.abc import Sequence
from types import TracebackType

from follower_humanoid.errors import ConfigurationError


class Claim:
    """Holds names of nodes in a ROS domain, as a context.

    A name is an abstract Unix socket: no file is left behind, it is gone with the process however that ends,
    and it reaches as far as the loopback network over which robots of one machine would meet. A name that the
    system does not give to anybody is not held: then discovery alone finds who is there.
    """

    def __init__(self, domain: int, namespace: str, nodes: Sequence[str]) -> None:
        """Claims the names in the given order: of two who begin together one gets them.

        Args:
            domain: ROS domain.
            namespace: Without a leading slash.
            nodes: Names of nodes.

        Raises:
            ConfigurationError: Somebody else holds one; then none is held.
        """
        self._held: list[socket.socket] = []
        for node in nodes:
            try:
                self._hold(_address(domain, namespace, node))
            except OSError as error:
                if error.errno == errno.EADDRINUSE:
                    self.close()
                    raise already_runs(domain, namespace, [node]) from None

    def _hold(self, address: bytes) -> None:
        holder = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._held.append(holder)
        holder.bind(address)

    def close(self) -> None:
        """Gives the names back."""
        while self._held:
            self._held.pop().close()

    def __enter__(self) -> Claim:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


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
