"""FlexibleBody: the matrices, nodes and interfaces of a free elastic body, the input of every method."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from supple.algebra import ConstrainedFactor, Eigenpairs, GroundedFactor, constrained_factor, lowest_modes
from supple.algebra.constrained_solve import dense_rows
from supple.body.checks import checked_grounded_stiffness
from supple.body.interface import BodyInterface, interface_named, moves_rigidly_with
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.errors import BasisWarning, ModelError
from supple.fem import Assembly, FiniteElementModel
from supple.mesh.mesh import no_ids
from supple.summary import Summarized, Summary, place_text

__all__ = ["FlexibleBody"]

# Smallest singular value of the rows of two interfaces, relative to the largest, that are independent.
_DEPENDENT = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleBody(Summarized):
    """A free elastic body; build it with `flexible_body` or `superelement`, which check it.

    Its n coordinates q are nodal freedoms, six freedoms of each rigid piece, and modal coordinates, in this
    order: u_nodal = expansion @ q. Coordinates eliminated by constraints, or for lack of mass or stiffness,
    are left out (`coordinates`).

    nodes         : (N, 3) m, in the mesh axes
    dofs_per_node : 3 (ux uy uz) or 6 (.. rx ry rz)
    expansion     : csc (n_nodal, n), T
    nodal_mass    : csc (n_nodal, n_nodal), M of the nodal freedoms
    mass          : csc (n, n), T^T M T, kg, kg m and kg m^2
    stiffness     : csc (n, n), T^T K T, N/m, N and N m
    interfaces    : virtual nodes, in the order given
    rigid_modes   : (n, 6), R: translations e_i, rotations e_i x x_a about the mesh origin; K R = 0
    model         : finite-element model of the body; None for a body from matrices
    force         : internal force as a function of q, linear or from quadratic strains
    rotation_operator : csc (3 P, n_nodal), from u_nodal to rotation vectors at P points; None if unknown
    rotation_limit    : rad, largest rotation relative to the body's frame for which the kinematics are valid
    threes : (rest, mass). csc (n0, n) maps q to q0, triples of freedoms of the free nodes, rigid pieces and
        recovered points with mass; csc (n0, n0) is the mass of q0. None where q0 = q
    damping       : csc (n, n), N s/m, of dashpots or a damping matrix; None without. Options of a reduction
        add further damping
    linearized_from : the body with quadratic strains from which `linearized` made this body; None otherwise
    n_modal : number of modal coordinates in q, of a condensed model. They belong to no node, and their mass
        is not in `nodal_mass`. They enter centrifugal and Coriolis terms only by masses of recovered points
    massless : numbers (k,) of nodes with displacements without mass, which follow the other nodes statically:
        a force on them causes no deflection relative to the others
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
    massless: NDArray[np.int64] = field(default_factory=no_ids, repr=False)
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
        """The interface of that name; the ModelError for an unknown name lists the nearest name, or all."""
        return interface_named(self.name, name, self.interfaces)

    def warn_of_massless(self, what: str, nodes: ArrayLike) -> None:
        """Warn once if some nodes, on which `what` exerts forces, have no mass."""
        bare = np.intersect1d(np.asarray(nodes, dtype=np.int64), self.massless)
        if bare.size:
            ids = () if self.model is None else self.model.mesh.node_ids
            number = ids[bare[0]] if len(ids) else bare[0]
            message = (
                f"{what}: node {number} (one of {bare.size}) has no mass. It follows the others statically: "
                "a force on it does not move it relative to them, and its deflection is too small; "
                "give its material a density, or the node a mass"
            )
            if message not in self._warnings:
                self._warnings.add(message)
                warnings.warn(message, BasisWarning, stacklevel=4)

    @cached_property
    def independent_interfaces(self) -> tuple[BodyInterface, ...]:
        """The interfaces without those that move rigidly with an earlier one, as means of the same nodes."""
        found: list[BodyInterface] = []
        for each in self.interfaces:
            if not any(moves_rigidly_with(each, other) for other in found):
                found.append(each)
        return tuple(found)

    @property
    def is_linear(self) -> bool:
        """Whether the internal force is K q, without nonlinear terms."""
        return self.force.is_linear

    def linearized(self) -> FlexibleBody:
        """The body with the internal force K q, without quadratic strains; `model` stays the same.

        Its interfaces have no tied nodes, and cubic_turn = 0.
        """
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
        vars(linear)["_warnings"] = self._warnings
        return linear

    @property
    def assembly(self) -> Assembly:
        """Assembly of the nonlinear force and tangent in the body's coordinates; ModelError if linear."""
        if isinstance(self.force, LinearForce):
            raise ModelError(
                f"body '{self.name}' is linear: it has matrices but no quadratic strains, so no nonlinear "
                "force, tangent or modal derivative; build it from a finite-element model"
            )
        return self.force.assembly

    @cached_property
    def grounded_stiffness(self) -> GroundedFactor:
        """Sparse factor of K with springs to ground at six freedoms, shared by all static solutions.

        ModelError for a mechanism, or a stiffness with negative eigenvalues.
        """
        return checked_grounded_stiffness(self.name, self.stiffness, self.rigid_modes)

    def constrained(self, constraint: ArrayLike | sparse.sparray) -> ConstrainedFactor:
        """Factor of static equilibrium under constraints D q = c, D (m, n), from `grounded_stiffness`."""
        try:
            return constrained_factor(self.stiffness, constraint, grounded=self.grounded_stiffness)
        except ModelError as error:
            pair = _dependent_pair(self.interfaces)
            if pair is None:
                raise
            raise ModelError(
                f"body '{self.name}': the motions of interfaces '{pair[0]}' and '{pair[1]}' depend on each "
                f"other: keep one of the two ({error})"
            ) from error

    def lowest_modes(self, n_modes: int, constraint: ArrayLike | sparse.sparray | None = None) -> Eigenpairs:
        """The n_modes lowest modes under D q = 0, D (m, n), with proof that none is missing.

        Without D the modes are those of the free body, including six rigid ones.
        """
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
        """Lowest angular frequencies (n_modes,), rad/s; modes are computed only if too few are known."""
        values = self._known_values.get(_digest(dense_rows(constraint, self.n)), np.zeros(0))
        if len(values) < n_modes:
            values = self.lowest_modes(n_modes, constraint).values
        return np.sqrt(np.maximum(values[:n_modes], 0.0))

    @cached_property
    def _known_values(self) -> dict[bytes, NDArray[np.float64]]:
        """Eigenvalues computed so far; the key is a digest of the constraint rows."""
        return {}

    @cached_property
    def _warnings(self) -> set[str]:
        """Warnings issued so far, as a machine is built several times with the same loads."""
        return set()

    def __getstate__(self) -> dict[str, Any]:
        # A factor is in the memory of a solver library and cannot be pickled; it is recomputed on first use.
        made_anew = ("grounded_stiffness", "_known_values", "_warnings")
        return {key: value for key, value in self.__dict__.items() if key not in made_anew}


def _digest(rows: NDArray[np.float64]) -> bytes:
    return sha256(rows.tobytes()).digest()


def _dependent_pair(interfaces: Sequence[BodyInterface]) -> tuple[str, str] | None:
    """Names of two interfaces whose motions depend on each other; None without such a pair.

    An example are two means of the same three nodes with different weights.
    """
    rows = [one.motion.toarray() for one in interfaces]
    rows = [each / np.linalg.norm(each, axis=1, keepdims=True) for each in rows]
    for (i, one), (j, other) in combinations(enumerate(rows), 2):
        singular = np.linalg.svd(np.vstack([one, other]), compute_uv=False)
        if singular[-1] < _DEPENDENT * singular[0]:
            return interfaces[i].name, interfaces[j].name
    return None
