"""Error of a reduced run caused by its bases (reduction error), body by body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from supple.algebra import read_only
from supple.reduction.locking import TOLERATED

__all__ = ["BasisError", "BodyError"]

FIRST_ORDER = 1 / 3
"""Ratio of the second correction to the first; above it only the order of magnitude of the error is known."""

ENRICH = "keep more modes, or let the reduction correct itself (accuracy = { relative = 1e-3 })"
"""Remedy for a basis whose error is too large."""

ASK_FOR_LESS = "ask for a smaller error, or start with more modes"
"""Remedy where the reduction is self-corrected."""


@dataclass(frozen=True, eq=False)
class BodyError:
    """Error of one body caused by its basis, estimated by the error equation.

    rms : float             largest RMS error of the nodes at an output time, unit of length
    worst : float           largest error of a node at the time of this RMS, unit of length
    worst_node : int        the node with that error
    worst_time : float      time of that error
    rest : float            largest RMS of corrections outside the error space, at times not used to build it
    second : float | None   ratio of a second correction to the first at the times of the largest errors;
                            above a third only the order of magnitude is known; None: not estimated
    history : (t,)          RMS over the nodes at the output times
    indicator : float       largest RMS over the nodes of the quasi-static motion outside the basis; infinite
                            where no equilibrium was found; 0: not estimated
    locking_loss : float    largest relative deficit of a static deflection due to locking; 0: not computed
    """

    rms: float
    worst: float
    worst_node: int
    worst_time: float
    rest: float
    second: float | None
    history: np.ndarray
    indicator: float = 0.0
    locking_loss: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "history", read_only(self.history))

    @property
    def estimate(self) -> float:
        """Estimated error: largest RMS over the nodes, plus the part outside the error space."""
        return self.rms + self.rest

    @property
    def is_converged(self) -> bool:
        """Whether the estimate is quantitative: finite, with a small second correction."""
        return bool(np.isfinite(self.estimate)) and (self.second is None or self.second <= FIRST_ORDER)

    def is_doubtful(self, limit: float) -> bool:
        """Whether the estimate may be far too small: the body locks, or much motion is outside its basis.

        The equation is linearised about the run. Example: a strip should buckle sideways, but locks and stays
        straight. This state is almost in equilibrium, so the estimated error is small.

        limit : RMS over the nodes; unless the body locks, the estimate is doubtful only if `indicator`
            exceeds both this limit and the estimate
        """
        return self.locking_loss > TOLERATED or not self.indicator <= max(self.estimate, limit)


@dataclass(frozen=True, eq=False)
class BasisError:
    """Error of a reduced run caused by the bases, by name of the reduced body."""

    bodies: Mapping[str, BodyError]
