"""Pieces of a picture that need not be in every picture, and take turns."""

from __future__ import annotations

from collections.abc import Callable
from math import gcd

from follower_humanoid.viewer.moment import Moment

Piece = Callable[[Moment], object]


class Turns:
    """Draws each piece as often as it is worth, and as few as possible in the same picture."""

    def __init__(self, rate: float) -> None:
        """Args: pictures a second [Hz]."""
        self._rate = rate
        self._pieces: list[tuple[int, int, Piece]] = []
        self._pictures = 0

    def add(self, interval: float, piece: Piece) -> None:
        """Adds a piece that is drawn once in an interval [s], or in every picture where these are rarer."""
        every = max(1, round(interval * self._rate))

        def met(turn: int) -> int:
            """How many pieces are at some time in the same picture."""
            return sum((turn - other) % gcd(every, often) == 0 for often, other, _ in self._pieces)

        self._pieces.append((every, min(range(every), key=met), piece))

    def take(self, moment: Moment) -> None:
        """Draws what is due in this picture."""
        for every, turn, piece in self._pieces:
            if self._pictures % every == turn:
                piece(moment)
        self._pictures += 1
