"""Inputs of a run by name; a run is continued only with the same inputs.

A value is a short text (a number of a case file) or a digest (a file, the numbers of a body).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

Inputs = Mapping[str, str]

FILE = "the file "
"""Prefix of a file name among inputs."""
ORDER_OF_CONTROLLERS = "the order of the controllers"
_MAY_BE_NEW = (FILE, ORDER_OF_CONTROLLERS)
"""Names, or their beginnings, of inputs that older files lack. Such a new input is no change: a run reads a
new file only if another input has changed."""
_DIGEST = "sha256:"
_MOST_NAMED = 5


def digest_of(content: bytes) -> str:
    """Digest of a content that is too long to be shown."""
    return _DIGEST + hashlib.sha256(content).hexdigest()


def changes(there: Inputs, here: Inputs) -> str:
    """The differences of two sets of inputs as text: names, with short values; empty where they are equal."""
    found = [_change(name, there.get(name), here.get(name)) for name in sorted(there.keys() | here.keys())]
    found = [change for change in found if change]
    more = f"; and {len(found) - _MOST_NAMED} more" if len(found) > _MOST_NAMED else ""
    return "; ".join(found[:_MOST_NAMED]) + more


def _change(name: str, there: str | None, here: str | None) -> str:
    if there == here:
        return ""
    if there is None:
        return "" if name.startswith(_MAY_BE_NEW) else f"{name} is new"
    if here is None:
        return f"{name} is missing now"
    if there.startswith(_DIGEST) or here.startswith(_DIGEST):
        return f"{name} has changed"
    return f"{name} was {there} and is {here}"
