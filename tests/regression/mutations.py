"""Damaged and hostile variants of valid files; the same seed gives the same variant."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

HOSTILE = [
    *(
        b"",
        b"0",
        b"-1",
        b"1",
        b"2",
        b"3",
        b"4",
        b"0.0",
        b"-0.0",
        b"1e-320",
        b"1e308",
        b"-1e308",
        b"1e999",
        b"nan",
        b"inf",
    ),
    *(b"-inf", b"NaN", b"1.0-5", b"1.5d300", b"0x10", b"1_000", b"99999999", b"2147483648", b"4294967295"),
    *(b"9223372036854775807", b"-9223372036854775808", b"18446744073709551616", b"1000000000000", b"9" * 400, b"true"),
    *(
        b"'a'",
        b'"a"',
        b"[]",
        b"{}",
        b"[[[[[[[[",
        b"../../../../etc/passwd",
        b"/dev/zero",
        b"/dev/stdin",
        b"%s%n",
        b"THRU",
    ),
    *(
        b"\x00",
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"\xc2\xb2",
        b"\r",
        b"\r\n",
        b"\n\n",
        b",",
        b",,,,,,,,",
        b"=",
        b"*",
        b"$",
        b"+",
    ),
]
_WORD = re.compile(rb"[^\s,=\[\]]+")
_NUMBER = re.compile(rb"[-+]?\d[\d.eE+-]*")


def mutated(seed: int, samples: list[bytes], *, binary: bool = False) -> bytes:
    """Change one of ``samples`` in one to six random ways; binary formats mostly keep their length."""
    chance = random.Random(seed)
    content = chance.choice(samples)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 6))):
        content = chance.choice(_BINARY_WAYS if binary else _WAYS)(chance, content, samples)
    return content


def _span(chance: random.Random, content: bytes) -> tuple[int, int]:
    start = chance.randint(0, len(content))
    return start, min(len(content), start + chance.choice([1, 2, 8, 40, 400]))


def _truncate(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    return content[: chance.randint(0, len(content))]


def _remove(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    start, end = _span(chance, content)
    return content[:start] + content[end:]


def _repeat(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    start, end = _span(chance, content)
    return content[:end] + content[start:end] * chance.choice([1, 1, 3, 50]) + content[end:]


def _flip(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    changed = bytearray(content)
    for _ in range(chance.choice([1, 4, 16]) if changed else 0):
        changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def _overwrite(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    """Put a hostile number of one to eight bytes over what stands there."""
    number = chance.choice([0, 1, 7, 0x7F, 0xFF, 0x7FFFFFFF, 0xFFFFFFFF, 2**40, 2**63 - 1, 2**64 - 1])
    raw = number.to_bytes(8, "little")[: chance.choice([1, 2, 4, 8])]
    start = chance.randint(0, max(0, len(content) - len(raw)))
    return content[:start] + raw + content[start + len(raw) :]


def _garbage(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    start, end = _span(chance, content)
    return content[:start] + chance.randbytes(end - start) + content[start:]


def _garbage_in_place(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    start, end = _span(chance, content)
    return content[:start] + chance.randbytes(end - start) + content[end:]


def _replace(pattern: re.Pattern[bytes]) -> Callable[[random.Random, bytes, list[bytes]], bytes]:
    def replace(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
        found = list(pattern.finditer(content))
        if not found:
            return content + chance.choice(HOSTILE)
        place = chance.choice(found)
        other = chance.choice(HOSTILE) if chance.random() < 0.7 else chance.choice(found).group()
        return content[: place.start()] + other + content[place.end() :]

    return replace


def _swap_lines(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    lines = content.splitlines(keepends=True)
    if len(lines) > 1:
        first, second = chance.randrange(len(lines)), chance.randrange(len(lines))
        lines[first], lines[second] = lines[second], lines[first]
    return b"".join(lines)


def _drop_line(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    lines = content.splitlines(keepends=True)
    gone = chance.randrange(len(lines) or 1)
    return b"".join(lines[:gone] + lines[gone + 1 :])


def _foreign_line(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    """Put a line of any sample somewhere between lines."""
    lines, others = content.splitlines(keepends=True), chance.choice(samples).splitlines(keepends=True)
    lines.insert(chance.randint(0, len(lines)), chance.choice(others))
    return b"".join(lines)


def _splice(chance: random.Random, content: bytes, samples: list[bytes]) -> bytes:
    other = chance.choice(samples)
    start, end = _span(chance, other)
    place = chance.randint(0, len(content))
    return content[:place] + other[start:end] + content[place:]


_NUMBERS, _WORDS = _replace(_NUMBER), _replace(_WORD)
_WAYS = [
    *(_truncate, _remove, _repeat, _flip, _garbage, _swap_lines, _splice, _drop_line, _foreign_line, _foreign_line),
    *([_NUMBERS] * 4),
    *([_WORDS] * 3),
]
_BINARY_WAYS = [*([_flip] * 8), *([_overwrite] * 8), _garbage_in_place, _truncate]
