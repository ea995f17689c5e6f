"""Ends of joints and forces: an interface of a body, or the ground."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any, NamedTuple

from supple.errors import ModelError

__all__ = ["GROUND", "At", "as_end"]


class At(NamedTuple):
    """One end of a joint or force: an interface of a body."""

    body: str
    interface: str

    def __str__(self) -> str:
        return f"{self.body}.{self.interface}" if self.interface else self.body


GROUND = At("ground", "")
"""The ground, an end fixed in space."""


def as_end(value: Any) -> At:
    """The end given as an `At`, a pair of names, "BODY.INTERFACE", or "ground".

    The name of the body ends at the first dot. If it contains a dot, give `At(body, interface)`.
    Raises ModelError for any other value. `System` checks that the body and the interface exist.
    """
    if isinstance(value, str):
        body, dot, interface = value.partition(".")
        if value == GROUND.body:
            return GROUND
        if body and interface:
            return At(body, interface)
        if not dot and get_close_matches(value, [GROUND.body]):
            raise ModelError(f"'{value}' is not an end; did you mean '{GROUND.body}'?")
        raise ModelError(
            f"'{value}' is not an end: write 'BODY.INTERFACE', for example '{body or 'blade'}.root', or "
            f"'{GROUND.body}'"
        )
    if isinstance(value, tuple) and len(value) == 2 and all(isinstance(name, str) for name in value):
        return At(*value)
    raise ModelError(f"an end is 'BODY.INTERFACE', At(body, interface) or '{GROUND.body}', got {value!r}")
