"""What a run depends on, by name, so that a run that goes on is the run that began.

A value is a short text (a number of a case file) or a digest (a file, the numbers of a body).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

Inputs = Mapping[str, str]

_DIGEST = "sha256:"
_MOST_NAMED = 5


def digest_of(content: bytes) -> str:
    """A value that stands for more than a line could show."""
    return _DIGEST + hashlib.sha256(content).hexdigest()


def changes(there: Inputs, here: Inputs) -> str:
    """What differs, in words: names, with both values where they can be shown; empty where nothing does."""
    found = [_change(name, there.get(name), here.get(name)) for name in sorted(there.keys() | here.keys())]
    found = [change for change in found if change]
    more = f"; and {len(found) - _MOST_NAMED} more" if len(found) > _MOST_NAMED else ""
    return "; ".join(found[:_MOST_NAMED]) + more


def _change(name: str, there: str | None, here: str | None) -> str:
    if there == here:
        return ""
    if there is None:
        return f"{name} is new"
    if here is None:
        return f"{name} is gone"
    if there.startswith(_DIGEST) or here.startswith(_DIGEST):
        return f"{name} has changed"
    return f"{name} was {there} and is {here}"
