"""Plain numbers: what a file may write for one, in the digits 0 to 9.

Python also takes 1_000, the digits of every script, nan and infinity, and whole numbers of any length.
"""

from __future__ import annotations

import math

LARGEST_INTEGER = 2**63 - 1
"""Of 64 bits: what arrays of ids hold."""

_LONGEST_INTEGER = 20
"""Digits and sign; Python spends quadratic time on longer ones before they can be compared."""


def is_plain(text: str) -> bool:
    """Whether a text has none of the characters that only Python takes for a part of a number."""
    return text.isascii() and "_" not in text


def is_plain_digits(word: str) -> bool:
    """Whether a word is a whole number from 0 that fits in 64 bits."""
    return (
        word.isascii() and word.isdecimal() and len(word) < _LONGEST_INTEGER and int(word) <= LARGEST_INTEGER
    )


def plain_integer(word: str) -> int:
    """The whole number; ValueError for anything else, also beyond 64 bits."""
    if not is_plain(word) or len(word.strip()) > _LONGEST_INTEGER:
        raise ValueError(f"'{word[:40]}' is not a whole number of 64 bits")
    number = int(word)
    if not -LARGEST_INTEGER - 1 <= number <= LARGEST_INTEGER:
        raise ValueError(f"'{word[:40]}' is not a whole number of 64 bits")
    return number


def plain_number(word: str) -> float:
    """The number, finite; ValueError for anything else."""
    if not is_plain(word) or not math.isfinite(number := float(word)):
        raise ValueError(f"'{word[:40]}' is not a number")
    return number
