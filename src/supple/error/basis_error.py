"""The error that the basis of a reduced run costs, body by body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from supple.algebra import read_only
from supple.reduction.locking import TOLERATED

__all__ = ["BasisError", "BodyError"]

FIRST_ORDER = 1 / 3
"""Size of a second correction over the first above which the first is an order of magnitude only."""

ENRICH = "keep more modes, or let the reduction correct itself (accuracy = { relative = 1e-3 })"
"""The remedy of a basis that costs too much."""

ASK_FOR_LESS = "ask for a smaller error, or start with more modes"
"""The remedy where the reduction corrects itself."""


@dataclass(frozen=True, eq=False)
class BodyError:
    """The error by the basis of one body, by the error equation.

    rms : float             largest over time of the RMS over the nodes of their error, unit of length
    worst : float           largest error of a node over the run, unit of length
    worst_node : int        that node
    worst_time : float      when it has that error
    rest : float            RMS of what the space of the error itself lacks, seen at instants of its own
    second : float | None   size of a second correction over the first at the worst instants; above a third
                            the error is an order of magnitude only; None: not estimated
    history : (t,)          RMS over the nodes at the output times
    indicator : float       largest RMS over the nodes of the motion outside the basis at rest; infinite
                            where no equilibrium was found; 0: not estimated
    withheld : float        share of a static answer that the body withholds because it locks
    """

    rms: float
    worst: float
    worst_node: int
    worst_time: float
    rest: float
    second: float | None
    history: np.ndarray
    indicator: float = 0.0
    withheld: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "history", read_only(self.history))

    @property
    def estimate(self) -> float:
        """Error stated, RMS over the nodes, largest over the run: what was found and what cannot be."""
        return self.rms + self.rest

    @property
    def is_converged(self) -> bool:
        """Whether the estimate is more than an order of magnitude: finite, its second correction small."""
        return bool(np.isfinite(self.estimate)) and (self.second is None or self.second <= FIRST_ORDER)

    def is_doubtful(self, limit: float) -> bool:
        """Whether the estimate may be far too small: the body locks, or lacks more than estimate and limit.

        The equation is linearised about the run. Where a strip that should tip sideways locks and stands
        straight, that is nearly in balance, and the error found small.

        limit : RMS over the nodes below which a missing motion raises no doubt
        """
        return self.withheld > TOLERATED or not self.indicator <= max(self.estimate, limit)


@dataclass(frozen=True, eq=False)
class BasisError:
    """The error that the bases of a reduced run cost, of every reduced body by name."""

    bodies: Mapping[str, BodyError]
