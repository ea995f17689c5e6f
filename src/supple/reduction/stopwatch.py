"""Wall time of the steps of a reduction."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


@contextmanager
def timed(seconds: dict[str, float], step: str) -> Iterator[None]:
    """Record the wall time of the block in `seconds[step]`."""
    start = perf_counter()
    yield
    seconds[step] = perf_counter() - start
