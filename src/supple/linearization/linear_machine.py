"""A machine linearised about an equilibrium, in independent coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

from supple.algebra.cross import cross_matrix
from supple.equations.control_linearization import LinearControl
from supple.equations.steady_motion import LinearEquations
from supple.integrate import Solution, Statistics
from supple.linearization.periodic import Periodic
from supple.machine import Spin, System
from supple.summary import Summarized, Summary, listed

if TYPE_CHECKING:
    from supple.linearization.axisymmetry import RoundBody
    from supple.linearization.sparse_machine import SparseMachine
    from supple.linearization.standing_error import StandingTurn
    from supple.methods.floating.full.linear_equations import SparseEquations
    from supple.simulation.full_rest import EquilibriumError

__all__ = ["LinearMachine"]

Array = np.ndarray
TURNING, STANDING = "turning with the machine", "standing in space"
"""Axes of the frequencies: a forward whirl of frequency w in space has the frequency w minus the spin rate in
co-rotating axes."""


def mass_squares(motions: np.ndarray, mass: Array | csr_array) -> Array:
    """Squared norms (k,) of motions (n, k), weighted by the mass."""
    return np.maximum(np.real(np.einsum("ij,ij->j", motions.conj(), mass @ motions)), 0.0)


def likeness(first: np.ndarray, second: np.ndarray, mass: Array | csr_array) -> Array:
    """MAC (j, k) of motions a (n, j) and b (n, k): `|a^H M b|^2 / (|a|^2 |b|^2)`; 0 for those at rest."""
    product = abs(first.conj().T @ (mass @ second)) ** 2
    sizes = np.outer(mass_squares(first, mass), mass_squares(second, mass))
    return product / np.where(sizes > 0, sizes, 1.0)


def slices_of(bodies: Iterable[RoundBody]) -> tuple[slice, ...]:
    """Positions of the motions of each body among `p`."""
    ends = np.cumsum([6 + body.n_coordinates for body in bodies]).tolist()
    return tuple(map(slice, [0, *ends[:-1]], ends))


def rigid_motions(n: int, frames: Iterable[tuple[int, Array, Array]]) -> Array:
    """Motions `p` (n, 6) of bodies for unit translations, and rotations about one point, global axes.

    frames : number of the first motion of each body, rotation of its frame, and its position from the point
    """
    found = np.zeros((n, 6))
    for start, rotation, arm in frames:
        found[start : start + 3, :3] = found[start + 3 : start + 6, 3:] = rotation.T
        found[start : start + 3, 3:] = -rotation.T @ cross_matrix(arm)
    return found


@dataclass(frozen=True, eq=False)
class FullMachine:
    """The reference for the basis errors of a linearised machine.

    machine  : SparseMachine    about its own equilibrium, with all coordinates of the reduced bodies
    expansion : sparse (N, n)   map from motions `p` of the reduced machine to those of the full one
    bodies   : by name, the coordinates of a reduced body among the N of the full machine
    rest     : EquilibriumError        basis errors at the equilibrium, by name
    standing : StandingTurn | None      for a machine in standing axes, over one revolution
    """

    machine: SparseMachine
    expansion: csr_array
    bodies: Mapping[str, slice]
    rest: Mapping[str, EquilibriumError]
    standing: StandingTurn | None = None


@dataclass(frozen=True, eq=False, repr=False)
class LinearMachine(Summarized):
    """Small motions `y` of a machine at rest, or in steady rotation.

        M y'' + C y' + K y = N^T f + H z,        p = N y,        G N = 0
        z' = E_p y + E_v y' + E_z z

    `p` contains per body the translation and the rotation of its frame, in the frame's own axes, and its
    deformation coordinates; `f` contains the forces conjugate to `p`; `N` spans the motions that the joints
    leave free, so that no constraint is left.
    For a rotating machine, the axes rotate with the machine: C contains the gyroscopic, K the centrifugal
    terms. `z` contains the states of the controllers, one after the other.

    system    : System          in its equilibrium
    spin      : Spin | None
    time      : float           at which loads and laws are evaluated
    mass, damping, stiffness : (k, k)
    basis     : N, (n, k)
    full_mass : (n, n)          mass matrix of `p`, without the joints' constraints
    control   : LinearControl   H (k, c), E_p (c, k), E_v (c, k), E_z (c, c)
    full      : FullMachine | None      the machine with all coordinates of its reduced bodies, if known
    is_in_space : bool          whether y describes rotating bodies in standing axes; `basis` is then valid
                only at the angle of the system
    periodic  : Periodic | None     the matrices over a revolution, if they vary; `mass`, `damping` and
                `stiffness` are then their means
    """

    system: System
    spin: Spin | None
    time: float
    mass: Array
    damping: Array
    stiffness: Array
    basis: Array
    full_mass: Array | csr_array
    control: LinearControl
    full: FullMachine | None = None
    is_in_space: bool = False
    periodic: Periodic | None = None

    @classmethod
    def along(
        cls,
        basis: Array,
        equations: LinearEquations | SparseEquations,
        system: System,
        spin: Spin | None,
        time: float,
    ) -> LinearMachine:
        """The machine with the equations of `p`, restricted to motions `p = N y`, N (n, k)."""
        mass = basis.T @ (equations.mass @ basis)
        return cls(
            system=system,
            spin=spin,
            time=time,
            mass=(mass + mass.T) / 2,
            damping=basis.T @ equations.damped(basis),
            stiffness=basis.T @ (equations.stiffness @ basis),
            basis=basis,
            full_mass=equations.mass,
            control=equations.control.along(basis),
        )

    def summary(self) -> Summary:
        """Bodies, spin, and the axes and kind of the equations."""
        rows = [
            ("bodies", listed(placed.body.name for placed in self.system.bodies)),
            ("coordinates", f"{self.size}, of {len(self.basis)} before joints"),
            ("axes", self.axes),
            ("equations", "constant" if self.periodic is None else "periodic in the rotation"),
            ("states of controllers", str(self.control.size)),
            ("compared with all coordinates", "no" if self.full is None else "yes"),
        ]
        if self.spin is not None:
            rows.insert(1, ("spin", f"{self.spin.rate:g} rad per unit of time"))
        return Summary(f"Linear machine of {self.size} coordinates, {self.axes}", rows)

    @property
    def axes(self) -> str:
        """Description of the axes of the motions and frequencies: `TURNING` or `STANDING`."""
        turns = self.spin is not None and self.spin.rate != 0 and not self.is_in_space
        return TURNING if turns else STANDING

    @property
    def size(self) -> int:
        """Number k of independent coordinates."""
        return len(self.mass)

    @property
    def slices(self) -> tuple[slice, ...]:
        """Positions of the motions of each body among `p`."""
        return slices_of(placed.body for placed in self.system.bodies)

    def motion_near(self, displacements: Array, rates: Array, times: Array | None = None) -> Solution:
        """Motion of the bodies for small p (t, n) about the equilibrium.

        The velocities are those for the rates p' (t, n) at p = 0.
        """
        bodies = {}
        for placed, own in zip(self.system.bodies, self.slices, strict=True):
            pose = placed.position, placed.rotation, placed.coordinates
            bodies[placed.body.name] = placed.body.motion_near(*pose, displacements[:, own], rates[:, own])
        return Solution(np.zeros(len(rates)) if times is None else times, bodies, {}, Statistics())

    def moving_at(self, rates: Array) -> Solution:
        """The equilibrium t times, with rates p' (t, n)."""
        return self.motion_near(np.zeros_like(rates), rates)

    @cached_property
    def unit_rates(self) -> Solution:
        """The equilibrium k times, each with a unit rate of one independent coordinate."""
        return self.moving_at(self.basis.T)

    def coordinates_of(self, motions: np.ndarray) -> np.ndarray:
        """Independent coordinates (k, ..) of motions (n, ..); the nearest if the motions violate joints."""
        return np.linalg.lstsq(self.basis, motions, rcond=None)[0]
