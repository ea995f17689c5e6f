"""Mutations of a valid file, as by a bad disk, a truncated copy or a typing error."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

_NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eEdD][-+]?\d+)?")

NASTY = (
    b"0", b"-1", b"1", b"2", b"7", b"1e9", b"1000000000", b"2147483648", b"4294967296",
    b"9223372036854775807", b"9223372036854775808", b"99999999999999999999999", b"9" * 400,
    b"1e308", b"-1e308", b"1e400", b"1e-320", b"nan", b"inf", b"-inf", b"1_000", "١٢".encode(), b"",
    b"0x10", b"1.5.2", b"--3", b"1+5", b"1,5", b"true", b"'", b'"', b"[", b"]", b"{", b"../x",
    b"\x00", b"\xff", b"\xef\xbb\xbf", b"a" * 300, b"*", b"$", b"#",
)  # fmt: skip
"""Replacements of numbers."""

Mutation = Callable[[np.random.Generator, bytes, Sequence[bytes]], bytes]


def mutated(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    """The content after one to three mutations; pieces of `others` are spliced in."""
    for _ in range(int(rng.integers(1, 4))):
        content = MUTATIONS[int(rng.integers(len(MUTATIONS)))](rng, content, others)
    return content


def _flip_bits(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        if changed:
            changed[int(rng.integers(len(changed)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _set_bytes(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    """A run of bytes with one value, such as the 0xff of a large count."""
    if not content:
        return content
    start, length = int(rng.integers(len(content))), int(rng.integers(1, 9))
    value = rng.choice([0, 1, 0x7F, 0x80, 0xFF])
    return content[:start] + bytes([int(value)]) * length + content[start + length :]


def _truncate(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    return content[: int(rng.integers(len(content) + 1))]


def _cut_out(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    start = int(rng.integers(len(content) + 1))
    return content[:start] + content[start + int(rng.integers(1, 200)) :]


def _splice(rng: np.random.Generator, content: bytes, others: Sequence[bytes]) -> bytes:
    other = others[int(rng.integers(len(others)))]
    start, place = int(rng.integers(len(other) + 1)), int(rng.integers(len(content) + 1))
    return content[:place] + other[start : start + int(rng.integers(1, 400))] + content[place:]


def _replace_number(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    found = list(_NUMBER.finditer(content))
    if not found:
        return content
    chosen = found[int(rng.integers(len(found)))]
    return content[: chosen.start()] + NASTY[int(rng.integers(len(NASTY)))] + content[chosen.end() :]


def _on_lines(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    """Duplicate, delete or exchange lines, or repeat a line many times."""
    lines = content.split(b"\n")
    one, two = (int(rng.integers(len(lines))) for _ in range(2))
    match int(rng.integers(4)):
        case 0:
            lines.insert(two, lines[one])
        case 1:
            del lines[one]
        case 2:
            lines[one], lines[two] = lines[two], lines[one]
        case _:
            lines[one:one] = [lines[one]] * int(rng.integers(2, 300))
    return b"\n".join(lines)


def _insert(rng: np.random.Generator, content: bytes, _: Sequence[bytes]) -> bytes:
    place = int(rng.integers(len(content) + 1))
    word = NASTY[int(rng.integers(len(NASTY)))] * int(rng.choice([1, 1, 1, 50]))
    return content[:place] + word + content[place:]


MUTATIONS: tuple[Mutation, ...] = (
    _flip_bits, _set_bytes, _truncate, _cut_out, _splice, _replace_number, _replace_number,
    _on_lines, _insert,
)  # fmt: skip
"""Replacement of numbers has twice the weight, because readers rely on numbers."""
