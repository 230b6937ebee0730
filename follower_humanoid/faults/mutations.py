"""Seeded damage to texts and bytes: what a broken disk, a careless editor or an attacker leaves behind."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence

_NUMBER = re.compile(r"[-+]?[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?")
_WORD = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
NUMBERS = (
    "nan", ".nan", "inf", "-inf", ".inf", "1e300", "-1e300", "1e999", "0", "-0.0", "-1", "1e-300", "5e-324",
    "9" * 400, "0x10", "1,5", "", "true", "9223372036854775808", "[]", "{}",
)  # fmt: skip
YAML_TOKENS = (
    "&a ", "*a ", "!!python/object/apply:os.system [ls]", "!!binary ", "<<: ", "{", "}", "[" * 300, "]", "- ",
    ": ", "? ", "|\n", ">\n", "'", '"', "#", "\t", "\0", "\n---\n", "%YAML 1.1\n", "\N{SNOWMAN}", "\x85",
)  # fmt: skip
XML_TOKENS = (
    "<", ">", "</", "/>", '"', "&lol;", "&#0;", "&#x1F600;", "<!--", "-->", "<![CDATA[", "]]>", "<link/>",
    "<joint/>", '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>', "\0", "\n" * 50,
)  # fmt: skip


def damaged_text(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    """The text after one to four pieces of damage."""
    for _ in range(rng.randint(1, 4)):
        text = rng.choice(_TEXT_DAMAGE)(text, tokens, rng)
    return text


def _number(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    found = list(_NUMBER.finditer(text))
    if not found:
        return text
    place = rng.choice(found)
    return text[: place.start()] + rng.choice(NUMBERS) + text[place.end() :]


def _word(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    found = list(_WORD.finditer(text))
    if not found:
        return text
    place = rng.choice(found)
    return text[: place.start()] + rng.choice(found).group() + text[place.end() :]


def _insert(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    at = rng.randint(0, len(text))
    return text[:at] + rng.choice(tokens) + text[at:]


def _cut(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    begin = rng.randint(0, len(text))
    return text[:begin] + text[begin + rng.randint(1, 200) :]


def _line(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    """Deletes, doubles or moves a line."""
    lines = text.splitlines(keepends=True) or [""]
    at = rng.randrange(len(lines))
    line = lines.pop(at)
    for _ in range(rng.randint(0, 2)):
        lines.insert(rng.randint(0, len(lines)), line)
    return "".join(lines)


def _truncate(text: str, tokens: Sequence[str], rng: random.Random) -> str:
    return text[: rng.randint(0, len(text))]


_Damage = Callable[[str, Sequence[str], random.Random], str]
_TEXT_DAMAGE: tuple[_Damage, ...] = (_number, _number, _word, _insert, _cut, _line, _truncate)


def damaged_bytes(data: bytes, rng: random.Random, spare: int = 0) -> bytes:
    """Bytes after damage: flipped, overwritten, cut, repeated, or with a huge length written somewhere.

    Args:
        data: What is damaged.
        rng: Of the damage.
        spare: Bytes at the front that stay, such as a magic number.
    """
    body = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        if len(body) <= spare + 8:
            break
        at = rng.randrange(spare, len(body) - 8)
        kind = rng.randrange(6)
        if kind == 0:
            body[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            body[at : at + 8] = rng.randbytes(8)
        elif kind == 2:
            del body[at : at + rng.randint(1, 64)]
        elif kind == 3:
            body[at:at] = body[at : at + rng.randint(1, 512)]
        elif kind == 4:
            width = rng.choice((4, 8))
            huge = rng.choice((0, 2**31, 2**31 - 1, 2**32 - 1, 2**40)) & (2 ** (8 * width) - 1)
            body[at : at + width] = huge.to_bytes(width, "little")
        else:
            del body[at:]
    return bytes(body)
