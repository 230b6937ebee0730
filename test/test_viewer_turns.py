"""Pieces of a picture take turns: none is late, and few are in the same picture."""

from itertools import pairwise

import pytest

from follower_humanoid.viewer.moment import Moment
from follower_humanoid.viewer.turns import Turns

INTERVALS = (0.1, 0.07, 0.3, 0.25, 0.05, *[0.2] * 7)


def drawn(rate: float, pictures: int) -> list[list[int]]:
    """Which pieces are in each picture."""
    turns, found = Turns(rate), []
    for piece, interval in enumerate(INTERVALS):
        turns.add(interval, lambda _, piece=piece: found[-1].append(piece))
    for _ in range(pictures):
        found.append([])
        turns.take(Moment(0.0))
    return found


@pytest.mark.parametrize("rate", [1.0, 10.0, 30.0, 60.0])
def test_every_piece_is_drawn_once_in_its_interval(rate):
    pictures = drawn(rate, 240)
    for piece, interval in enumerate(INTERVALS):
        at = [number for number, pieces in enumerate(pictures) if piece in pieces]
        gaps = {later - sooner for sooner, later in pairwise(at)}
        (gap,) = gaps
        assert gap == max(1, round(interval * rate))
        assert at[0] < gap


def test_no_picture_has_many_pieces():
    pictures = drawn(30.0, 240)
    mean = sum(map(len, pictures)) / len(pictures)
    assert max(map(len, pictures)) <= mean + 2.0
