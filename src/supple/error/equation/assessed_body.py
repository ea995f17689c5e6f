"""Body of an assessed run: its columns, its start error, and its quasi-static missing motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray
from supple.body import Damping, FullBody
from supple.error.equation.elastic_polynomial import ElasticPolynomial
from supple.error.equation.error_model import body_of_columns
from supple.error.equation.error_space import ErrorSpace
from supple.error.equation.nodal_squares import NodalSquares, nodal_squares
from supple.error.equation.run_columns import RunColumns
from supple.reduction import ReducedBody

__all__ = ["AssessedBody", "MissedAtRest", "StartError"]


@dataclass(frozen=True, eq=False)
class AssessedBody:
    """A body of an assessed run: all its coordinates, and the columns of its motion and of its error.

    polynomial : elasticity of the body in few columns; None: elasticity from sample times of the run
    """

    full: FullBody
    motion: RunColumns
    space: ErrorSpace
    damping: Damping | None = None
    polynomial: ElasticPolynomial | None = None

    @property
    def retardation_time(self) -> float:
        """Retardation time of the strain-rate damping; 0 without such damping."""
        return 0.0 if self.damping is None else self.damping.retardation_time

    @cached_property
    def columns(self) -> ReducedBody:
        """The body in the columns of its error, as a reduced body."""
        steps = len(self.motion.coordinates) - 1
        return body_of_columns(self.full.body, self.full.frame, self.space.vectors, self.damping, steps)

    @cached_property
    def squares(self) -> NodalSquares:
        """Mean squares over the nodes of an error in these columns."""

        def at_nodes(columns: FloatArray) -> FloatArray:
            return np.moveaxis(self.full.expand(columns.T), 0, 2)

        return nodal_squares(self.full.nodes, at_nodes(self.motion.vectors), at_nodes(self.space.vectors))

    def along(self, motion: RunColumns) -> AssessedBody:
        """The same body in another run with the same columns."""
        other = replace(self, motion=motion)
        for name in ("columns", "squares"):
            object.__setattr__(other, name, getattr(self, name))
        return other


class MissedAtRest(NamedTuple):
    """Quasi-static motion outside the basis of a body, at some times (k,): displacements (n, k)."""

    times: FloatArray
    deformation: FloatArray


class StartError(NamedTuple):
    """True start less the run's start of one body: positions and velocities `(dR, psi, q)`, (6 + n,) each."""

    position: FloatArray
    velocity: FloatArray
