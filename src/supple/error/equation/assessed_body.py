"""What is known of a body whose run is assessed: its columns, its start, and its missing motion at rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.body import Damping, FullBody
from supple.error.equation.elastic_polynomial import ElasticPolynomial
from supple.error.equation.error_model import body_of_columns
from supple.error.equation.error_space import ErrorSpace
from supple.error.equation.nodal_squares import NodalSquares, nodal_squares
from supple.error.equation.run_columns import RunColumns
from supple.reduction import ReducedBody

__all__ = ["AssessedBody", "MissedAtRest", "StartError"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AssessedBody:
    """A body of a run: all its coordinates, the columns that the run moves in, and those of its error.

    polynomial : of its elasticity in few columns; None: from instants of the run
    """

    full: FullBody
    motion: RunColumns
    space: ErrorSpace
    damping: Damping | None = None
    polynomial: ElasticPolynomial | None = None

    @property
    def retardation_time(self) -> float:
        """Of the damping by strain rate; 0 without one."""
        return 0.0 if self.damping is None else self.damping.retardation_time

    @cached_property
    def columns(self) -> ReducedBody:
        """The body in the columns of its error."""
        steps = len(self.motion.coordinates) - 1
        return body_of_columns(self.full.body, self.full.frame, self.space.vectors, self.damping, steps)

    @cached_property
    def squares(self) -> NodalSquares:
        """Mean squares over its nodes of an error in these columns."""

        def at_nodes(columns: Array) -> Array:
            return np.moveaxis(self.full.expand(columns.T), 0, 2)

        return nodal_squares(self.full.nodes, at_nodes(self.motion.vectors), at_nodes(self.space.vectors))

    def along(self, motion: RunColumns) -> AssessedBody:
        """The same for another run in the same columns."""
        other = replace(self, motion=motion)
        for name in ("columns", "squares"):
            object.__setattr__(other, name, getattr(self, name))
        return other


class MissedAtRest(NamedTuple):
    """Motion outside the basis of a body, at some times (k,): displacements (n, k)."""

    times: Array
    deformation: Array


class StartError(NamedTuple):
    """True start less the run's of one body: positions and velocities `(dR, psi, q)`, (6 + n,) each."""

    position: Array
    velocity: Array
