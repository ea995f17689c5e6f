"""Progress messages of benchmarks."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Announce", "Progress"]

Progress = Callable[[float], None]
"""Called with the share of a run that is done."""
Announce = Callable[[str], Progress]
"""Called with the name of a run about to start; gives the callback for its progress."""
