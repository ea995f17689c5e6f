"""Steady loads: a basis with the static responses to steady accelerations of the frame."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody, Frame
from supple.body.inertia_polynomial import SPIN_PAIRS, InertiaPolynomial
from supple.reduction.bases.interface_columns import fixed_interfaces
from supple.reduction.bases.linear_basis import LinearBasis, LinearBasisRecipe, static_columns

__all__ = ["NoLoads", "SteadyLoads"]

NAMES = (
    *(f"acceleration {axis}" for axis in "xyz"),
    *(f"angular acceleration {axis}" for axis in "xyz"),
    *(f"rotation about {axis}" for axis in "xyz"),
    *(f"rotation about {first} and {second}" for first, second in combinations("xyz", 2)),
)

# A response is dropped if its M-norm is at most this fraction of the largest, such as the response of a line
# of nodes to a rotation about itself.
SMALLEST_RESPONSE = 1e-9


@dataclass(frozen=True)
class SteadyLoads:
    """The basis of `recipe`, and the static responses y to twelve steady acceleration fields a.

        K y + B^T mu = M a,   B y = 0
        a:  e_i (3),   e_i cross x (3),   x - e_i (e_i . x) (3),   e_i (e_j . x) + e_j (e_i . x) (3)

    x is the position, e_i are the axes of the body. The fields are translational and angular acceleration of
    the frame, and the centrifugal accelerations due to the squares and to the products of the components of
    its angular velocity. Few modes do not contain these responses: a centrifugal load stretches a disc in
    modes of high frequency only, and an acceleration bends a body a little in all modes. The interface to
    which the frame is fixed supports the body, otherwise its first interface. A body without interfaces has
    the six responses to rotation only, under the constraints of the recipe. A response that other columns
    contain is dropped, and listed in the report of the basis: with a Rubin basis in a mean-axis frame, only
    the responses to rotation remain.

    recipe : the basis to extend
    Source: modal truncation augmentation with inertia loads, [Dickens1997]
    """

    recipe: LinearBasisRecipe

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """The recipe's columns, then up to twelve static responses; raises the recipe's errors."""
        basis = self.recipe.build(body, frame)
        held = fixed_interfaces(body, frame) or body.interfaces
        solver = body.constrained(held[0].motion) if held else basis.static_solver
        names = NAMES if held else NAMES[6:]  # an acceleration moves a free body rigidly
        responses = solver.solve(_loads(body)[:, -len(names) :])
        lengths = np.sqrt(np.sum(responses * (body.mass @ responses), axis=0))
        kept = np.flatnonzero(lengths > SMALLEST_RESPONSE * lengths.max())
        labels = tuple(f"static response to {names[i]}" for i in kept)
        return basis.followed_by(static_columns(responses[:, kept], labels, basis.static_solver))


@dataclass(frozen=True)
class NoLoads:
    """The basis of `recipe` without `SteadyLoads`, as in published work: `reduce(.., loads=NoLoads)`."""

    recipe: LinearBasisRecipe

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """The recipe's columns; raises the recipe's errors."""
        return self.recipe.build(body, frame)


def _loads(body: FlexibleBody) -> NDArray[np.float64]:
    """Inertia loads M a (n, 12) on the coordinates, in the order of NAMES; signs may differ."""
    of_spin = InertiaPolynomial(body).by_both
    of_both = of_spin + of_spin.swapaxes(0, 1)
    return np.column_stack([body.mass @ body.rigid_modes, *(of_both[pair] for pair in SPIN_PAIRS)])
