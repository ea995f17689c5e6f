"""Modes of a machine in standing (non-rotating) axes, with motion outside the bases of its bodies.

In its own axes a body has the same matrices at every angle; joints and forces act at its interfaces alone. In
a mode it moves with shapes x at frequencies s relative to its own axes, `( s^2 M + s C + K ) x = f`, thus

    K(z) x = f + (z^2 - s^2) M x + (z - s) C x,    K(z) = K + z C + z^2 M.

Therefore the responses K(z)^-1 M x and K(z)^-1 C x of the machine with unreduced bodies, at a fixed shift z,
contain the motion outside a basis for every s. They are added to the bases until the modes converge: those of
one blade to all equal blades, those of cyclic bodies together with their rotated copies.
Source: [Voss2004], as for `slowest_motions`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array

from supple.body import FullBody, frame_projector
from supple.errors import AccuracyError
from supple.linearization.axisymmetry import waves_around
from supple.linearization.linear_machine import Array, LinearMachine, mass_squares
from supple.linearization.slowest_motions import Pairs
from supple.linearization.sparse_machine import SparseMachine
from supple.linearization.standing_axes import FEW, RotatingMachine, Sampled
from supple.methods.floating.full.linear_equations import SparseEquations
from supple.simulation.resting_state import RestingState
from supple.simulation.stored_basis import coordinates_of_nodes

ROUNDS = 8
"""Largest number of extensions of the bases."""
STAYS = 1e-6
"""Relative change of an eigenvalue per round below which modes have converged."""
STILL = 1e-6
"""Smaller eigenvalues, relative to the largest, count as zero (rigid motions) in the test of convergence."""
NEW = 1e-5
"""Norm of the part of a response outside a basis, relative to the response, below which it is rounding."""
ALIKE = 1e-9
"""Allowed difference between the bases of equal bodies, relative to the bases."""
PAIRED = 0.99
"""Ratio of squared norms above which two columns are a shape and its rotated copy: both are kept, or none."""


class _Shapes(NamedTuple):
    """The columns of a body as motions of its nodes."""

    nodes: Array
    nodal_basis: Array

    @property
    def n_coordinates(self) -> int:
        return self.nodal_basis.shape[1]


@dataclass(frozen=True, eq=False)
class StandingTurn:
    """A machine with unreduced bodies at several angles of its rotation, for equations in standing axes.

    machine : RotatingMachine   with unreduced bodies, at its equilibrium
    fulls, vectors : by name    the full body of each reduced one, and the columns (n, r) of its basis
    """

    machine: RotatingMachine
    fulls: Mapping[str, FullBody]
    vectors: Mapping[str, Array]

    @property
    def found(self) -> RestingState:
        """The equilibrium."""
        return self.machine.found

    @cached_property
    def turned(self) -> list[SparseEquations]:
        """The equations at evenly spaced angles."""
        return self.machine.turned(FEW)

    def along(self, vectors: Mapping[str, Array]) -> LinearMachine:
        """The machine with bodies reduced to given bases; `basis` of the result maps to these coordinates.

        Raises AccuracyError if its equations in standing axes are not constant.
        """
        motions = expansion(self.found, vectors).toarray()
        # The columns satisfy the frame conditions: the last rows of the constraints, six for each full body.
        joints = self.turned[0].constraint.shape[0] - 6 * len(self.fulls)
        sampled = Sampled(
            mass=np.array([motions.T @ (each.mass @ motions) for each in self.turned]),
            damping=np.array([motions.T @ each.damped(motions) for each in self.turned]),
            stiffness=np.array([motions.T @ (each.stiffness @ motions) for each in self.turned]),
            constraint=np.array([(each.constraint @ motions)[:joints] for each in self.turned]),
        )
        shapes = {
            name: _Shapes(full.nodes, full.body.expansion @ vectors[name])
            for name, full in self.fulls.items()
        }
        bodies = [shapes.get(placed.body.name, placed.body) for placed in self.found.system.bodies]
        machine = replace(self.machine, bodies=bodies).constant(sampled)
        if machine is None:
            raise AccuracyError(
                "with all coordinates of its bodies the machine has no constant equations in standing "
                "axes: the error of the bases is not known; skip its estimate, fulls=()"
            )
        return machine

    def enlarged(self, vectors: Mapping[str, Array], responses: Array) -> dict[str, Array]:
        """The bases, extended by the parts of responses (N, k) of unreduced bodies outside them."""
        own = {name: responses[part] for name, part in coordinates_of_bodies(self.found, vectors).items()}
        found: dict[str, Array] = {}
        for name, basis in vectors.items():
            # Equal bodies keep equal bases, whether they are blades of one rotor or not.
            alike = [other for other in vectors if _is_alike(self.fulls, vectors, name, other)]
            known = next((found[other] for other in alike if other in found), None)
            if known is None:
                known = self._with(name, basis, np.hstack([own[other] for other in alike]))
            found[name] = known
        return found

    def _with(self, name: str, basis: Array, added: Array) -> Array:
        full = self.fulls[name]
        body = full.body
        around = self.machine.axis_in_body(self.found.system.body_index(name))
        nodal = waves_around(full.nodes, body.expansion @ added, *around)
        added = frame_projector(body, full.frame)(coordinates_of_nodes(body)(nodal))
        weight = basis.T @ (body.mass @ basis)
        for _ in range(2):
            added = added - basis @ np.linalg.solve(weight, basis.T @ (body.mass @ added))
        squares, weights = np.linalg.eigh(added.T @ (body.mass @ added))
        first = int(np.searchsorted(squares, NEW**2))
        while 0 < first < len(squares) and squares[first - 1] > PAIRED * squares[first]:
            first += 1
        return np.hstack([basis, added @ (weights[:, first:] / np.sqrt(squares[first:]))])


def expansion(found: RestingState, vectors: Mapping[str, Array]) -> csr_array:
    """Matrix (N, n) from coordinates of bodies reduced to bases, by name, to those of unreduced bodies."""
    blocks: list[Any] = []
    for placed, part in zip(found.system.bodies, found.equations.slices, strict=True):
        own = vectors.get(placed.body.name)
        blocks += [eye_array(part.stop - part.start)] if own is None else [eye_array(6), own]
    return csr_array(block_diag(blocks))


def coordinates_of_bodies(found: RestingState, names: Collection[str]) -> dict[str, slice]:
    """Positions of the coordinates of some bodies among all motions, by name."""
    pairs = zip(found.system.bodies, found.equations.slices, strict=True)
    return {own.body.name: slice(at.start + 6, at.stop) for own, at in pairs if own.body.name in names}


def _is_alike(fulls: Mapping[str, FullBody], vectors: Mapping[str, Array], first: str, second: str) -> bool:
    """Whether two bodies have equal reductions, within rounding."""
    ours, theirs = vectors[first], vectors[second]
    if ours.shape != theirs.shape or not np.array_equal(fulls[first].nodes, fulls[second].nodes):
        return False
    return bool(abs(ours - theirs).max(initial=0.0) <= ALIKE * abs(ours).max(initial=0.0))


def slowest_in_standing_axes(
    machine: SparseMachine,
    turn: StandingTurn,
    n_modes: int,
    modes_of: Callable[[LinearMachine], Pairs],
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and shapes (N, k) at the first angle of the slowest modes, with unreduced bodies.

    machine : the same machine in co-rotating axes, whose factorisation at a shift is used for the responses
    Raises AccuracyError for modes that do not converge, or equations that are not constant.
    """
    vectors, before = turn.vectors, np.zeros(0)
    for _ in range(ROUNDS):
        linear = turn.along(vectors)
        values, y, _ = modes_of(linear)
        values, motions = values[:n_modes], linear.basis @ y[:, :n_modes]
        shapes = expansion(turn.found, vectors).toarray() @ motions
        sizes = np.maximum(abs(values), STILL * abs(values).max(initial=0.0))
        if len(values) == len(before) and (abs(values - before) <= STAYS * sizes).all():
            return values, shapes
        before = values
        motions = np.hstack([shapes.real, shapes.imag])
        equations, factor = machine.equations, machine.slow.factor
        responses = factor.solve(np.hstack([equations.mass @ motions, equations.damped(motions)]))
        norms = np.sqrt(mass_squares(responses, equations.mass))
        vectors = turn.enlarged(vectors, responses[:, norms > 0] / norms[norms > 0])
    raise AccuracyError(
        f"the modes with all coordinates have not converged in standing axes after {ROUNDS} rounds: the "
        "error of the bases is not known; request fewer modes, or skip its estimate, fulls=()"
    )
