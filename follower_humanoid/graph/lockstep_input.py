"""What a lock-stepped node keeps of one of its inputs."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class Input:
    """Samples of one input, or of several that come in one piece, kept until no step can need them."""

    topics: tuple[str, ...]
    producer: str
    period: int
    at_once: bool  # True where the message of a tick is used at that tick; even a stranger is waited for
    foreign: bool
    once: bool  # True where no message of a node of ours serves more than one step
    awaited: int | None = None
    samples: dict[int, object] = field(default_factory=dict)
    held: bool = False
    held_since: int = 0
    newest: object = None
    begins: int = 0  # first tick since its node came back
    left: int | None = None  # first tick without its node

    @property
    def missing(self) -> bool:
        """Whether its message is waited for."""
        if self.awaited is None or self.held or self.awaited in self.samples:
            return False
        return self.begins <= self.awaited and (self.left is None or self.awaited < self.left)

    def take(self, held_from: int) -> object:
        """What a step uses, to be asked for once.

        Args:
            held_from: What is held is used only if it came at this tick or later.
        """
        if self.held:
            return self.newest if self.held_since >= held_from else None
        if self.awaited is None:
            return None
        return self.samples.pop(self.awaited, None) if self.once else self.samples.get(self.awaited)

    def forget(self, before: int) -> None:
        """Drops what no step needs any more; the newest is kept for the case that a stranger falls silent."""
        for tick in sorted(self.samples):
            if tick >= before:
                return
            self.newest = self.samples.pop(tick)
