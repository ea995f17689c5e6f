"""What hears of the long steps of a build and of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

Progress = Callable[[str, float], None]
"""Hears of the step at work, in words, and of the share of it that is done, 0 to 1."""


class Notify(Protocol):
    """What hears of the long steps of a build, whose length is not known."""

    def __call__(self, step: str, detail: str = "", /) -> None:
        """A step begins; or, of the step that goes on, how far it has come."""
        ...


def silent(*_: Any) -> None:
    """Hears of everything and says nothing."""
