"""The nearest known name to one that is not known."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`, did you mean 'NEAREST'?` or nothing when no known name is near."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    nearest = get_close_matches(
        name.lower().replace("_", "-"), by_lower, n=1, cutoff=0.6
    ) or get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return f", did you mean {by_lower[nearest[0]]!r}?" if nearest else ""
