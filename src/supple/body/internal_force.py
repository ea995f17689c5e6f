"""How the internal force of a body is evaluated: from its stiffness alone, or from quadratic strains.

What a body is made of is another question: a linearised body keeps its elements.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.fem import Assembly, QuadraticStrain, assemble_strains

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinearForce:
    """f = K q, of small displacements.

    stiffness : csc (n, n)
    """

    stiffness: sparse.csc_array = field(repr=False)

    @property
    def is_linear(self) -> bool:
        """True."""
        return True

    @property
    def blocks(self) -> tuple[QuadraticStrain, ...]:
        """No quadratic strains."""
        return ()

    def internal_force(self, q: Array) -> Array:
        """Internal force (n,), N and N m."""
        return self.stiffness @ q

    def tangent(self, q: Array) -> sparse.csc_array:  # noqa: ARG002
        """Tangent stiffness (n, n): K, whatever q."""
        return self.stiffness

    def strain_rate_force(self, q: Array, rates: Array) -> Array:  # noqa: ARG002
        """Force K q_dot (n,), whatever q."""
        return self.stiffness @ rates

    def energies(self, Q: Array) -> Array:
        """Strain energies (t,), J, of every column of Q (n, t)."""
        return (Q.T * (self.stiffness @ Q).T).sum(axis=1) / 2


@dataclass(frozen=True, eq=False)
class QuadraticStrainForce:
    """f = dU/dq of strains quadratic in q, summed over the elements of a model; K is its tangent at q = 0.

    blocks : of the elements, in nodal freedoms
    dofs_per_node : 3 or 6
    expansion : csc (n_nodal, n)    T of the nodal freedoms u = T q; rows of virtual nodes may follow
    """

    blocks: tuple[QuadraticStrain, ...] = field(repr=False)
    dofs_per_node: int
    expansion: Any = field(repr=False)

    @property
    def is_linear(self) -> bool:
        """False."""
        return False

    @cached_property
    def assembly(self) -> Assembly:
        """The sums over the elements, prepared when first used."""
        n_nodes = self.expansion.shape[0] // self.dofs_per_node
        return assemble_strains(self.blocks, n_nodes, self.dofs_per_node, self.expansion)

    def internal_force(self, q: Array) -> Array:
        """Internal force (n,), N and N m."""
        return self.assembly.internal_force(q)

    def tangent(self, q: Array) -> sparse.csc_array:
        """Tangent stiffness (n, n), the derivative of the internal force."""
        return self.assembly.tangent(q)

    def strain_rate_force(self, q: Array, rates: Array) -> Array:
        """Force K_mat(q) q_dot (n,) of stresses C eps_dot."""
        return self.assembly.strain_rate_force(q, rates)

    def energies(self, Q: Array) -> Array:
        """Strain energies (t,), J, of every column of Q (n, t)."""
        return self.assembly.energies(Q)

    def __getstate__(self) -> dict[str, Any]:
        # Between processes the sums travel worse than they are prepared.
        return {key: value for key, value in self.__dict__.items() if key != "assembly"}
