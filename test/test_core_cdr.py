"""The wire format's primitives against rclpy's own serialisation."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, String

from follower_humanoid.core.cdr import HEADER, CdrBytes, clock_bytes, padding, put_stamp, stamp_of, text_of

STAMP = 12_345_678_901


def test_clock_and_stamp_are_as_rclpy_has_them():
    message = Clock(clock=Time(sec=12, nanosec=345_678_901))
    assert clock_bytes(STAMP) == bytes(serialize_message(message))
    assert stamp_of(bytes(serialize_message(message))) == STAMP
    before = Header(stamp=Time(sec=-3, nanosec=1), frame_id="world")
    assert stamp_of(bytes(serialize_message(before))) == -3 * 10**9 + 1


def test_a_stamp_of_the_other_byte_order_is_read():
    assert stamp_of(b"\0\0\0\0" + (12).to_bytes(4, "big") + (345_678_901).to_bytes(4, "big")) == STAMP


@pytest.mark.parametrize("length", range(12))
def test_what_is_cut_short_has_no_stamp(length):
    assert stamp_of(clock_bytes(STAMP)[:length]) == -1
    assert stamp_of(clock_bytes(STAMP)) >= 0


def test_what_is_written_can_be_read_by_rclpy():
    for text in ("", "a", "größer", "x" * 1000):
        written = CdrBytes()
        written.text(text)
        assert deserialize_message(bytes(written.data), String).data == text
        written = CdrBytes()
        offset = written.stamp()
        written.text(text)
        put_stamp(written.data, offset, STAMP)
        header = deserialize_message(bytes(written.data), Header)
        assert (header.stamp.sec, header.stamp.nanosec, header.frame_id) == (12, 345_678_901, text)


def test_padding_counts_from_behind_the_header():
    assert [padding(len(HEADER) + n, 8) for n in (0, 1, 7, 8)] == [0, 7, 1, 0]


@pytest.mark.parametrize("text", ["", "a", "Füße", "x" * 1000])
def test_a_text_is_as_rclpy_has_it(text):
    assert text_of(bytes(serialize_message(String(data=text)))) == text
    stamped = bytes(serialize_message(Header(stamp=Time(sec=1), frame_id=text)))
    assert text_of(stamped, len(HEADER) + 8) == text


def test_what_is_no_text_is_none():
    whole = bytes(serialize_message(String(data="abc")))
    assert [text_of(whole[:length]) for length in range(len(whole) - 4)] == [None] * (len(whole) - 4)
    bad_bytes = (b"\xff\xff\xff\xff", b"\0\0\0\0", b"\2\0\0\0\xff\0", b"\2\0\0\0ab")
    assert [text_of(HEADER + data) for data in bad_bytes] == [None] * 4
