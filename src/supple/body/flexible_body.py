"""FlexibleBody: the matrices, nodes and interfaces of a free elastic body, the input of every method."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from supple.algebra import ConstrainedFactor, Eigenpairs, GroundedFactor, constrained_factor, lowest_modes
from supple.algebra.constraint_rows import dense_rows
from supple.body.checks import checked_grounded_stiffness
from supple.body.interface import BodyInterface, interface_named
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.errors import ModelError
from supple.fem import Assembly, FiniteElementModel
from supple.summary import Summarized, Summary, place_text

__all__ = ["FlexibleBody"]


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleBody(Summarized):
    """A free elastic body; build it with `flexible_body` or `superelement`, which check it.

    Its n coordinates q are the nodal freedoms that remain after elimination of rigid pieces, constraints and
    freedoms without mass or stiffness (`coordinates`), then six for each rigid piece:
    u_nodal = expansion @ q.

    nodes         : (N, 3) m, in the mesh axes
    dofs_per_node : 3 (ux uy uz) or 6 (.. rx ry rz)
    expansion     : csc (n_nodal, n), T
    nodal_mass    : csc (n_nodal, n_nodal)
    mass          : csc (n, n), T^T M T, kg
    stiffness     : csc (n, n), T^T K T, N/m
    interfaces    : virtual nodes, in the order given
    rigid_modes   : (n, 6), R: translations e_i, rotations e_i x x_a about the mesh origin; K R = 0
    model         : the elements it is made of; None for a body from matrices
    force         : evaluation of its internal force, linear or from quadratic strains
    rotation_operator : csc (3 P, n_nodal), rotation vectors at P points; None where rotations are unknown
    rotation_limit    : rad, largest rotation relative to the body's frame for which its kinematics hold
    threes : the map `rest` (n0, n) to coordinates in triples q0 = rest @ q, of free nodes and rigid pieces,
        and their mass (n0, n0); None where q0 = q, as with rigid interfaces only
    damping       : csc (n, n), N s/m, from its files, or None. Options of a reduction add to it
    linearized_from : the same body with quadratic strains, if it was linearised; None otherwise
    n_modal : number of modal coordinates in q, of a condensed model. They belong to no node, and their mass
        is not in `nodal_mass`. They enter centrifugal and Coriolis terms only by masses of recovered points
    """

    name: str
    nodes: NDArray[np.float64]
    dofs_per_node: int
    expansion: sparse.csc_array = field(repr=False)
    nodal_mass: sparse.csc_array = field(repr=False)
    mass: sparse.csc_array = field(repr=False)
    stiffness: sparse.csc_array = field(repr=False)
    interfaces: tuple[BodyInterface, ...] = field(repr=False)
    rigid_modes: NDArray[np.float64] = field(repr=False)
    model: FiniteElementModel | None = field(repr=False)
    force: LinearForce | QuadraticStrainForce = field(repr=False)
    rotation_operator: sparse.csc_array | None = field(repr=False)
    rotation_limit: float
    threes: tuple[sparse.csc_array, sparse.csc_array] | None = field(default=None, repr=False)
    n_modal: int = 0
    damping: sparse.csc_array | None = field(default=None, repr=False)
    linearized_from: FlexibleBody | None = field(default=None, repr=False, compare=False)

    def summary(self) -> Summary:
        """Coordinates, mass, elements, kind of internal force, damping and interfaces."""
        kind = "linear" if self.is_linear else "geometrically nonlinear"
        rows = [
            ("coordinates", f"{self.n} of {self.n_nodal} freedoms of {len(self.nodes)} nodes; {kind}"),
            ("mass", f"{self.rigid_modes[:, 0] @ (self.mass @ self.rigid_modes[:, 0]):g}"),
        ]
        if self.model is not None:
            cells = self.model.mesh.cells.items()
            rows.append(("elements", ", ".join(f"{len(array)} {cell.name}" for cell, array in cells)))
        if self.damping is not None:
            rows.append(("damping", "of its files"))
        size = float(abs(self.nodes).max())
        rows += [(f"interface {one.name}", f"at {place_text(one.position, size)}") for one in self.interfaces]
        return Summary(f"FlexibleBody '{self.name}', {self.n} coordinates, {kind}", rows)

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.rigid_modes)

    @property
    def n_nodal(self) -> int:
        """Number of nodal freedoms, N * dofs_per_node."""
        return len(self.nodes) * self.dofs_per_node

    def interface(self, name: str) -> BodyInterface:
        """The interface of that name; ModelError lists the nearest names, or all."""
        return interface_named(self.name, name, self.interfaces)

    @property
    def is_linear(self) -> bool:
        """Whether the internal force is K q, without nonlinear terms."""
        return self.force.is_linear

    def linearized(self) -> FlexibleBody:
        """The same body, of the same elements, without quadratic strains: its internal force is K q."""
        linear = replace(
            self,
            force=LinearForce(self.stiffness),
            linearized_from=self.linearized_from if self.is_linear else self,
            interfaces=tuple(
                replace(interface, cubic_turn=0.0, tied_nodes=interface.tied_nodes[:0])
                for interface in self.interfaces
            ),
        )
        if "grounded_stiffness" in vars(self):  # K is the same, so its factor is shared
            vars(linear)["grounded_stiffness"] = self.grounded_stiffness
        return linear

    @property
    def assembly(self) -> Assembly:
        """Nonlinear force and tangent in the body's coordinates; ModelError for a linear body."""
        if isinstance(self.force, LinearForce):
            raise ModelError(
                f"body '{self.name}' is linear: it has matrices but no quadratic strains, so no nonlinear "
                "force, tangent or modal derivative; build it from a finite-element model"
            )
        return self.force.assembly

    @cached_property
    def grounded_stiffness(self) -> GroundedFactor:
        """One sparse factor of K, fixed at six freedoms, for every static solution of the body."""
        return checked_grounded_stiffness(self.name, self.stiffness, self.rigid_modes)

    def constrained(self, constraint: ArrayLike | sparse.sparray) -> ConstrainedFactor:
        """Static equilibrium under D q = c, D (m, n); all constraints share `grounded_stiffness`."""
        return constrained_factor(self.stiffness, constraint, grounded=self.grounded_stiffness)

    def lowest_modes(self, n_modes: int, constraint: ArrayLike | sparse.sparray | None = None) -> Eigenpairs:
        """The lowest modes under D q = 0, D (m, n), proven complete; without D, those of the free body."""
        rows = dense_rows(constraint, self.n)
        found = lowest_modes(
            self.stiffness, self.mass, n_modes, constraint=rows, grounded=self.grounded_stiffness
        )
        known, held = self._known_values, _digest(rows)
        known[held] = max(known.get(held, found.values), found.values, key=len)
        return found

    def lowest_frequencies(
        self, n_modes: int, constraint: ArrayLike | sparse.sparray | None = None
    ) -> NDArray[np.float64]:
        """Lowest frequencies (n_modes,), rad/s, from modes computed earlier if these suffice."""
        values = self._known_values.get(_digest(dense_rows(constraint, self.n)), np.zeros(0))
        if len(values) < n_modes:
            values = self.lowest_modes(n_modes, constraint).values
        return np.sqrt(np.maximum(values[:n_modes], 0.0))

    @cached_property
    def _known_values(self) -> dict[bytes, NDArray[np.float64]]:
        """Computed eigenvalues, by a digest of the constraint rows."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        # Factors are in the memory of a solver library and cannot be pickled: they are rebuilt.
        made_anew = ("grounded_stiffness", "_known_values")
        return {key: value for key, value in self.__dict__.items() if key not in made_anew}


def _digest(rows: NDArray[np.float64]) -> bytes:
    return sha256(rows.tobytes()).digest()
