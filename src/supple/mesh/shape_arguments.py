"""Checks of the sizes and cell counts that the parametric shapes take."""

from __future__ import annotations

import math

from supple.errors import MeshError


def check_sizes(**sizes: float) -> None:
    """Raise MeshError unless every named size is finite and positive."""
    for name, size in sizes.items():
        if not (math.isfinite(size) and size > 0):
            raise MeshError(f"{name} = {size}; a size is finite and above zero")


def check_counts(least: int = 1, **counts: int) -> None:
    """Raise MeshError unless every named cell count is a whole number of at least `least`."""
    for name, count in counts.items():
        if count != int(count) or count < least:
            raise MeshError(f"{name} = {count}; a number of cells is whole and at least {least}")
