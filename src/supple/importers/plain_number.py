"""Numbers in files, written in the digits 0 to 9 only.

Python also accepts 1_000, digits of other scripts, nan, infinity and integers of any length.
"""

from __future__ import annotations

import math
from collections.abc import Callable

LARGEST_INTEGER = 2**63 - 1
"""Largest 64-bit integer, the type of id arrays; larger integers are rejected."""

_LONGEST_INTEGER = 20
"""Largest number of characters of an integer; longer words, which take long to convert, are rejected."""


def in_sixteen_columns(value: float) -> str:
    """A number in 16 characters: nine decimals; eight if it is negative with an exponent of three digits."""
    word = f"{value:16.9E}"
    return word if len(word) == 16 else f"{value:16.8E}"


def is_plain(text: str) -> bool:
    """Whether a text has no characters that only Python accepts in numbers."""
    return text.isascii() and "_" not in text


def is_plain_digits(word: str) -> bool:
    """Whether a word is a whole number from 0 that fits in 64 bits."""
    return (
        word.isascii() and word.isdecimal() and len(word) < _LONGEST_INTEGER and int(word) <= LARGEST_INTEGER
    )


def plain_integer(word: str) -> int:
    """The integer; ValueError for anything else, also beyond 64 bits."""
    if not is_plain(word) or len(word.strip()) > _LONGEST_INTEGER:
        raise ValueError(f"'{word[:40]}' is not a whole number of 64 bits")
    number = int(word)
    if not -LARGEST_INTEGER - 1 <= number <= LARGEST_INTEGER:
        raise ValueError(f"'{word[:40]}' is not a whole number of 64 bits")
    return number


def number_of_word(word: str) -> float:
    """The finite number; ValueError for anything else."""
    if not is_plain(word) or not math.isfinite(number := float(word)):
        raise ValueError(f"'{word[:40]}' is not a number")
    return number


def is_number(word: str) -> bool:
    """Whether Python accepts a word as a number, such as nan, inf and 1_000."""
    return _is_accepted(float, word)


def is_finite_number(word: str) -> bool:
    """Whether `number_of_word` accepts a word."""
    return _is_accepted(number_of_word, word)


def is_integer(word: str) -> bool:
    """Whether `plain_integer` accepts a word."""
    return _is_accepted(plain_integer, word)


def _is_accepted(read: Callable[[str], float], word: str) -> bool:
    try:
        read(word)
    except ValueError:
        return False
    return True
