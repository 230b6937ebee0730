"""What has come on some topics, decoded only when somebody asks for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from follower_humanoid.ros.codecs import Codec
from follower_humanoid.ros.validation import MessageError


class Glance(Mapping[str, Any]):
    """Topic → newest sample; the same object until another message has come."""

    def __init__(self, codecs: Mapping[str, Codec], reject: Callable[[Exception], None]) -> None:
        """Nothing yet. Args: how topics are read, and where complaints about messages go."""
        self._codecs, self._reject = codecs, reject
        self._messages: dict[str, bytes] = {}  # not decoded yet
        self._samples: dict[str, Any] = {}

    def put(self, topic: str, message: bytes) -> None:
        """Takes in a serialised message."""
        self._messages[topic] = message

    def forget(self) -> None:
        """Drops everything."""
        self._messages.clear()
        self._samples.clear()

    def __getitem__(self, topic: str) -> Any:
        message = self._messages.pop(topic, None)
        if message is not None:
            try:
                self._samples[topic] = self._codecs[topic].decode(message)
            except MessageError as error:  # the sample before it stays
                self._reject(error)
        return self._samples[topic]

    def __iter__(self) -> Iterator[str]:
        return (topic for topic in self._codecs if topic in self)

    def __len__(self) -> int:
        return sum(1 for _ in self)
