"""Evaluation of the internal force of a body: from its stiffness alone, or from quadratic strains.

A body of elements can have either force: its linearised form keeps the elements and has a linear force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

from scipy import sparse

from supple.arrays import FloatArray
from supple.body.second_order_tie import RigidSet, second_order_strains
from supple.fem import Assembly, FiniteElementModel, QuadraticStrain, assemble_strains

__all__ = ["LinearForce", "QuadraticStrainForce"]


@dataclass(frozen=True, eq=False)
class LinearForce:
    """f = K q, for small displacements.

    stiffness : csc (n, n)
    """

    stiffness: sparse.csc_array = field(repr=False)

    is_linear: ClassVar[bool] = True

    blocks: ClassVar[tuple[QuadraticStrain, ...]] = ()
    """No quadratic strains."""

    def internal_force(self, q: FloatArray) -> FloatArray:
        """Internal force (n,), N and N m."""
        return self.stiffness @ q

    def tangent(self, q: FloatArray) -> sparse.csc_array:  # noqa: ARG002
        """Tangent stiffness (n, n): K for every q."""
        return self.stiffness

    def strain_rate_force(self, q: FloatArray, rates: FloatArray) -> FloatArray:  # noqa: ARG002
        """Force K q_dot (n,), independent of q."""
        return self.stiffness @ rates

    def energies(self, Q: FloatArray) -> FloatArray:
        """Strain energies (t,), J, one for each column of Q (n, t)."""
        return (Q.T * (self.stiffness @ Q).T).sum(axis=1) / 2


@dataclass(frozen=True, eq=False)
class QuadraticStrainForce:
    """f = dU/dq of strains quadratic in q, summed over the elements of a model; K is df/dq at q = 0.

    model : FiniteElementModel
    expansion : csc (n_nodal, n)    T of the nodal freedoms u = T q, followed by rows for the virtual nodes of
        `rigid_sets`
    rigid_sets : sets of nodes tied to second order in the rotation of their virtual node; empty: T ties all
        nodes linearly
    """

    model: FiniteElementModel = field(repr=False)
    expansion: sparse.csc_array = field(repr=False)
    rigid_sets: Sequence[RigidSet] = field(default=(), repr=False)

    @property
    def dofs_per_node(self) -> int:
        """Number of freedoms of a node, 3 or 6."""
        return self.model.dofs_per_node

    @cached_property
    def blocks(self) -> tuple[QuadraticStrain, ...]:
        """Strains of the elements, in nodal and virtual-node freedoms; created on first use."""
        model = self.model
        if not self.rigid_sets:
            return model.strains
        return second_order_strains(model.strains, model.mesh.nodes, self.dofs_per_node, self.rigid_sets)

    is_linear: ClassVar[bool] = False

    @cached_property
    def assembly(self) -> Assembly:
        """The assembly of the element forces and tangents, created on first use."""
        n_nodes = self.expansion.shape[0] // self.dofs_per_node
        return assemble_strains(self.blocks, n_nodes, self.dofs_per_node, self.expansion)

    def internal_force(self, q: FloatArray) -> FloatArray:
        """Internal force (n,), N and N m."""
        return self.assembly.internal_force(q)

    def tangent(self, q: FloatArray) -> sparse.csc_array:
        """Tangent stiffness (n, n), the derivative of the internal force."""
        return self.assembly.tangent(q)

    def strain_rate_force(self, q: FloatArray, rates: FloatArray) -> FloatArray:
        """Force K_mat(q) q_dot (n,) of stresses C eps_dot, with the material stiffness K_mat."""
        return self.assembly.strain_rate_force(q, rates)

    def energies(self, Q: FloatArray) -> FloatArray:
        """Strain energies (t,), J, one for each column of Q (n, t)."""
        return self.assembly.energies(Q)

    def __getstate__(self) -> dict[str, Any]:
        # Rebuilding these costs less than sending them between processes.
        return {key: value for key, value in self.__dict__.items() if key not in ("assembly", "blocks")}
