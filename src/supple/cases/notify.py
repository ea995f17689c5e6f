"""Reports of the long steps of a build."""

from __future__ import annotations

from typing import Any, Protocol


class Notify(Protocol):
    """Called at the long steps of a build, whose length is not known."""

    def __call__(self, step: str, detail: str = "", /) -> None:
        """A step begins; or, of the step that goes on, how far it has come."""
        ...


def silent(*_: Any) -> None:
    """No report."""
