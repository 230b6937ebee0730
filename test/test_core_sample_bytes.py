"""Samples come out of bytes as they went in, bit for bit, whatever is missing."""

from __future__ import annotations

import numpy as np
import pytest

from follower_humanoid.core.sample_bytes import packed, unpacked
from follower_humanoid.core.samples import Gait, Inertial, Joints, Odometry, Wrench


def some_sample(rng):
    """Of any kind, or none; numbers that are not finite too: bits are bits."""
    n = int(rng.integers(1, 6))
    special = [0.0, -0.0, np.inf, np.nan, 5e-324]

    def array(size):
        return np.where(rng.random(size) < 0.2, rng.choice(special, size), rng.normal(size=size))

    makers = (
        lambda: None,
        lambda: Joints(array(n), array(n), array(n)),
        lambda: Odometry(array(3), array(4), array(3), array(3)),
        lambda: Inertial(array(4), array(3), array(3)),
        lambda: Wrench(array(3), array(3), str(rng.choice(["", "world", "größe"]))),
    )
    return makers[rng.integers(len(makers))]()


def bits(sample):
    if sample is None:
        return None
    values = [getattr(sample, name) for name in type(sample).__dataclass_fields__]
    return type(sample), [v if isinstance(v, str) else v.tobytes() for v in values]


@pytest.mark.parametrize("seed", range(100))
def test_there_and_back(seed):
    rng = np.random.default_rng(seed)
    samples = [some_sample(rng) for _ in range(rng.integers(7))]
    again = unpacked(*packed(samples))
    assert [bits(a) for a in again] == [bits(s) for s in samples]
    for made in again:
        for name in () if made is None else type(made).__dataclass_fields__:
            value = getattr(made, name)
            assert isinstance(value, str) or (value.flags.writeable and value.flags.c_contiguous)


def test_nothing_else_is_taken():
    with pytest.raises(KeyError):
        packed([Gait(0.0, 0.0, 1.0, 1.0, 0.0)])
