"""Static correction: a basis with the static response to given loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import read_only
from supple.body import FlexibleBody, Frame
from supple.errors import ModelError
from supple.reduction.bases.linear_basis import LinearBasis, LinearBasisRecipe, static_columns

__all__ = ["StaticCorrection"]


@dataclass(frozen=True, eq=False)
class StaticCorrection:
    """The basis of `recipe`, and the static response x to each given load F.

        K x + D^T mu = F,   D x = 0

    D are the conditions of the frame; if the recipe fixes the interfaces, B replaces D. The response to a
    distributed load converges slowly with the number of modes: for example, a centrifugal load stretches a
    blade, straightens its walls and tilts its sections, mostly in modes of high frequency. One column
    contains the whole response. In a mean-axis frame the multipliers mu are inertia forces, so that a load
    need not be balanced.

    recipe : the basis to extend
    loads : (n_nodal, k)    k loads on the nodal freedoms, of any scale
    Source: mode acceleration and modal truncation augmentation, [Dickens1997]
    """

    recipe: LinearBasisRecipe
    loads: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, "loads", read_only(self.loads))

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """The recipe's columns, then one per load; ModelError: a load of wrong size, zero or not finite."""
        if self.loads.ndim != 2 or self.loads.shape[0] != body.n_nodal:
            raise ModelError(
                f"static correction of body '{body.name}': loads of shape {self.loads.shape}; "
                f"give ({body.n_nodal}, k), one column for each load"
            )
        if not (np.isfinite(self.loads).all() and self.loads.any(axis=0).all()):
            raise ModelError(
                f"static correction of body '{body.name}': a load is zero or not finite; "
                "give finite, nonzero loads"
            )
        basis = self.recipe.build(body, frame)
        responses = basis.static_solver.solve(body.expansion.T @ self.loads)
        labels = tuple(f"static response to load {i + 1}" for i in range(self.loads.shape[1]))
        return basis.followed_by(static_columns(responses, labels, basis.static_solver))
