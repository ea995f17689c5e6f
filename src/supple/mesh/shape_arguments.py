"""Checks of the sizes and cell counts of parametric shapes."""

from __future__ import annotations

import math

from supple.arguments import check_number
from supple.errors import MeshError

MOST_CELLS = 20_000_000
"""Largest cell count of a parametric shape: beyond it the nodes alone fill the memory of a workstation."""


def check_sizes(**sizes: float) -> None:
    """Raise MeshError unless every named size is finite and positive."""
    for name, size in sizes.items():
        check_number(name, size)
        if not (math.isfinite(size) and size > 0):
            raise MeshError(f"{name} = {size}; give a finite size above zero")


def check_counts(least: int = 1, **counts: int) -> None:
    """Raise MeshError unless counts are whole, at least `least`, and their product at most MOST_CELLS."""
    for name, count in counts.items():
        check_number(name, count)
        if not math.isfinite(count) or count != int(count) or count < least:
            raise MeshError(f"{name} = {count}; give a whole number of cells, at least {least}")
    cells = math.prod(map(int, counts.values()))
    if cells > MOST_CELLS:
        raise MeshError(
            f"{' x '.join(f'{name} = {count}' for name, count in counts.items())} make {cells:.3g} cells; "
            "at most "
            f"{MOST_CELLS} are made: choose fewer"
        )
