"""Progress messages of benchmarks."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Announce", "Progress"]

Progress = Callable[[float], None]
"""Called with the completed fraction of a run."""
Announce = Callable[[str], Progress]
"""Called with the name of the next run; returns the callback for its progress."""
