"""A reduced body as a superelement: motion of its interfaces, and modal coordinates.

The body has the rigid motion `a` of its mesh axes and its coordinates `gamma`; its interfaces have the motion
`u = B (a, gamma)`. With N the null space of B, and P the motion of least strain energy for given u,

    (a, gamma) = P u + N Phi eta,    B P = 1,    N^T K P = 0,    N^T K N Phi = N^T M N Phi diag(omega^2)

This is an exact change of coordinates to the Craig-Bampton form, for any basis of the body.

Source: [CraigBampton1968].
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.arrays import FloatArray
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError, did_you_mean
from supple.export.superelements.stated_frequencies import (
    N_RIGID,
    N_STATED,
    StatedFrequencies,
    free_matrices,
    frequencies,
    frequency_lines,
)
from supple.reduction import ReducedBody

__all__ = ["InterfaceForm", "interface_form"]


INDEPENDENT = 1e-8
"""Smallest singular value of independent interface motions, relative to the largest; below it, ModelError."""


@dataclass(frozen=True, eq=False)
class InterfaceForm:
    """Linear part of a body: motion of its interfaces, and modes with all interfaces clamped.

        q = (u_1, theta_1, .., u_n, theta_n, eta)

    interfaces : names;  positions : (n, 3), mesh axes
    stiffness, mass, damping : (6 n + m, 6 n + m), without supports. The block of eta is diag(omega^2) in the
        stiffness, without coupling to u, and the identity in the mass
    to_body : (6 + r, 6 n + m)      (a, gamma) = to_body q, a about the origin of the mesh axes
    """

    name: str
    interfaces: tuple[str, ...]
    positions: FloatArray
    stiffness: FloatArray = field(repr=False)
    mass: FloatArray = field(repr=False)
    damping: FloatArray = field(repr=False)
    to_body: FloatArray = field(repr=False)

    @property
    def n_boundary(self) -> int:
        """Number of degrees of freedom of the interfaces, 6 n."""
        return 6 * len(self.interfaces)

    @property
    def n_modal(self) -> int:
        """Number of modal coordinates."""
        return len(self.stiffness) - self.n_boundary

    def freedoms(self, *, of_modal: int) -> NDArray[np.int64]:
        """Node and component (6 n + m, 2) of every row: nodes 1 to n have six rows, each further node one.

        of_modal : component of the modal coordinates
        """
        n = len(self.interfaces)
        own = np.column_stack([np.repeat(np.arange(1, n + 1), 6), np.tile(np.arange(1, 7), n)])
        modal = n + 1 + np.arange(self.n_modal)
        return np.concatenate([own, np.column_stack([modal, np.full_like(modal, of_modal)])])

    def matrices(self, stiffness: str, mass: str, damping: str) -> dict[str, FloatArray]:
        """Stiffness, mass and, unless it is zero, damping, by the names of a format."""
        found = {stiffness: self.stiffness, mass: self.mass}
        return found | {damping: self.damping} if self.damping.any() else found

    def rows(self, interface: str) -> NDArray[np.int64]:
        """Rows (6,) of an interface; ModelError for an unknown one."""
        if interface not in self.interfaces:
            near, known = did_you_mean(interface, self.interfaces), ", ".join(self.interfaces)
            raise ModelError(f"body '{self.name}' has no interface '{interface}'{near}; it has: {known}")
        return 6 * self.interfaces.index(interface) + np.arange(6)

    def frequencies(self, held: Collection[str] = ()) -> FloatArray:
        """Natural frequencies with the interfaces `held` clamped, cycles per unit of time, ascending.

        If none is clamped, the six zero frequencies of rigid motion are left out.

        Raises ModelError for an unknown interface.
        """
        free = np.setdiff1d(np.arange(len(self.mass)), [row for name in held for row in self.rows(name)])
        found = frequencies(self.stiffness[np.ix_(free, free)], self.mass[np.ix_(free, free)])
        return found if held else found[N_RIGID:]

    def stated_frequencies(self) -> StatedFrequencies:
        """Lowest frequencies by support, cycles per unit of time, as a reference for another program."""
        supports: list[tuple[str, tuple[str, ...]]] = [("free", ())]
        supports += [(f"clamped at {name}", (name,)) for name in self.interfaces]
        if len(self.interfaces) > 1 and self.n_modal:
            supports.append(("clamped at all interfaces", self.interfaces))
        return [(words, self.frequencies(held)[:N_STATED]) for words, held in supports]

    def comment(self) -> list[str]:
        """Lines for the header of a file: interfaces, and reference frequencies."""
        lines = [f"{self.name}: linear superelement with {self.n_modal} modal coordinates"]
        lines += [
            f"interface {number}: {name} at {x:.9g} {y:.9g} {z:.9g}"
            for number, (name, (x, y, z)) in enumerate(zip(self.interfaces, self.positions, strict=True), 1)
        ]
        return [*lines, *frequency_lines(self.stated_frequencies())]


def interface_form(body: ReducedBody) -> InterfaceForm:
    """The superelement form of a reduced body; for a nonlinear body, the form of its linear part.

    Raises
    ------
    ModelError      no interface; interface motions that are not independent in the body's coordinates
    """
    if not body.interfaces:
        raise ModelError(
            f"body '{body.name}' has no interface, and a superelement is joined at interfaces; give it one"
        )
    K, M, D = free_matrices(body)
    motion = np.concatenate([interface.motion for interface in body.interfaces])
    positions = np.array([interface.position for interface in body.interfaces])
    rigid = nodal_rigid_modes(positions, 6)
    # Scaled to pure numbers: unit kinetic energy of each coordinate, rotations times the size of the body.
    balance = linalg.block_diag(np.linalg.inv(linalg.cholesky(M[:N_RIGID, :N_RIGID])), np.eye(body.r))
    size = float(np.linalg.norm(np.ptp(body.nodes, axis=0))) or 1.0
    lengths = np.tile(np.repeat([1.0, size], 3), len(positions))
    B = lengths[:, None] * (np.hstack([rigid, motion]) @ balance)
    K, M, D = (balance.T @ matrix @ balance for matrix in (K, M, D))
    left, values, right = linalg.svd(B)
    n_boundary = len(B)
    if n_boundary > len(M) or values[-1] < INDEPENDENT * values[0]:
        independent = int(np.sum(values > INDEPENDENT * values[0]))
        raise ModelError(
            f"body '{body.name}': of its {n_boundary} interface degrees of freedom only {independent} are "
            f"independent in {body.r} coordinates and rigid motion; reduce it with CraigBampton or Rubin, or "
            "remove interfaces"
        )
    N = right[n_boundary:].T
    P = (right[:n_boundary].T / values) @ left.T
    if N.shape[1]:
        stiff = N.T @ K @ N
        P = P - N @ linalg.solve(stiff, N.T @ (K @ P), assume_a="pos")
        N = N @ linalg.eigh(stiff, N.T @ M @ N)[1]
    whole = np.hstack([P * lengths, N])
    stiffness = whole.T @ K @ whole
    stiffness[:n_boundary, n_boundary:] = stiffness[n_boundary:, :n_boundary] = 0.0
    stiffness[n_boundary:, n_boundary:] = np.diag(np.diag(stiffness)[n_boundary:])
    mass = whole.T @ M @ whole
    mass[n_boundary:, n_boundary:] = np.eye(N.shape[1])
    return InterfaceForm(
        body.name,
        tuple(interface.name for interface in body.interfaces),
        positions,
        _symmetric(stiffness),
        _symmetric(mass),
        _symmetric(whole.T @ D @ whole),
        balance @ whole,
    )


def _symmetric(matrix: FloatArray) -> FloatArray:
    return 0.5 * (matrix + matrix.T)
