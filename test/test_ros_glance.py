"""Messages are decoded when somebody asks, once; what cannot be used is told and leaves what was there."""

import pytest

from follower_humanoid.ros.glance import Glance
from follower_humanoid.ros.validation import MessageError


class Counting:
    """Reads text, and counts how often."""

    def __init__(self) -> None:
        self.read = 0

    def decode(self, data: bytes) -> list[str]:
        self.read += 1
        if data == b"bad":
            raise MessageError("words", "bad")
        return data.decode().split()


@pytest.fixture
def codecs():
    return {"words": Counting(), "others": Counting()}


@pytest.fixture
def complaints():
    return []


@pytest.fixture
def glance(codecs, complaints):
    return Glance(codecs, complaints.append)


def test_what_nobody_asks_for_is_never_decoded(glance, codecs):
    for _ in range(5):
        glance.put("words", b"a b")
        glance.put("others", b"c")
    assert glance["words"] == ["a", "b"]
    assert (codecs["words"].read, codecs["others"].read) == (1, 0)


def test_a_sample_is_the_same_object_until_another_message_has_come(glance):
    glance.put("words", b"a")
    first = glance["words"]
    assert glance["words"] is first
    glance.put("words", b"a")
    assert glance["words"] is not first


def test_there_is_what_has_come(glance):
    assert dict(glance) == {}
    glance.put("words", b"a")
    assert dict(glance) == {"words": ["a"]}
    assert "others" not in glance
    glance.forget()
    assert len(glance) == 0


def test_a_message_that_cannot_be_used_is_told_once_and_the_sample_before_it_stays(glance, complaints):
    glance.put("words", b"bad")
    assert "words" not in glance
    glance.put("words", b"a")
    assert glance["words"] == ["a"]
    glance.put("words", b"bad")
    assert glance["words"] == ["a"]
    assert glance.get("words") == ["a"]
    assert len(complaints) == 2
