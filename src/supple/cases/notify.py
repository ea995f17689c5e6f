"""Reports of the long steps of a build."""

from __future__ import annotations

from typing import Protocol


class Notify(Protocol):
    """Called at the long steps of a build, whose duration is unknown."""

    def __call__(self, step: str, detail: str = "", /) -> None:
        """Report the start of a step, or with `detail` its progress."""
        ...


def silent(*_: object) -> None:
    """Report nothing."""
