"""What is known of a body whose run is assessed: its columns, its start, and its missing motion at rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.body import Damping, FullBody
from supple.error.equation.error_model import body_of_columns
from supple.error.equation.error_space import ErrorSpace
from supple.error.equation.run_columns import RunColumns
from supple.reduction import ReducedBody

__all__ = ["AssessedBody", "MissedAtRest", "StartError"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AssessedBody:
    """A body of a run: all its coordinates, the columns that the run moves in, and those of its error."""

    full: FullBody
    motion: RunColumns
    space: ErrorSpace
    damping: Damping | None = None

    @cached_property
    def columns(self) -> ReducedBody:
        """The body in the columns of its error."""
        return body_of_columns(self.full.body, self.full.frame, self.space.vectors, self.damping)

    def along(self, motion: RunColumns) -> AssessedBody:
        """The same for another run in the same columns."""
        other = replace(self, motion=motion)
        object.__setattr__(other, "columns", self.columns)
        return other


class MissedAtRest(NamedTuple):
    """Motion outside the basis of a body, at some times (k,): displacements (n, k)."""

    times: Array
    deformation: Array


class StartError(NamedTuple):
    """True start less the run's of one body: positions and velocities `(dR, psi, q)`, (6 + n,) each."""

    position: Array
    velocity: Array
