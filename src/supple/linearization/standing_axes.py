"""A rotating machine in standing axes: rotors on unequal bearings, blades on a tower.

Small motions `p` of rotating bodies are measured in their own axes, in which the equations of standing parts
vary with the angle psi of rotation. In other coordinates z, `p = W(psi) z`, all equations can be constant:

- the rigid motion of one rotating body, the hub, is a twist at the axis, in standing axes; the motions of
the other rotating bodies are relative to the hub, so that nothing between rotating bodies varies;
- N >= 3 equal bodies evenly spaced around the axis have multi-blade coordinates instead of their own,

    q_b = a_0 + sum_n [ a_n cos n psi_b + b_n sin n psi_b ] (+ (-1)^b a_(N/2)),   psi_b = psi + 2 pi b / N;

- bodies with cyclic symmetry about the axis have deformation and relative motion in standing axes
(`turn_generator`).

With a constant rate psi' = r, W' = dW/dpsi, and M, C, K at that angle,

    M_z = W^T M W,    C_z = W^T (C W + 2 r M W'),    K_z = W^T (K W + r C W' + r^2 M W'').

If these matrices do not vary with psi, their eigenvalues are exact. Otherwise they are periodic (`Periodic`).
Source: [ColemanFeingold1958]; [Johnson1980] chapter 8 for any number of blades.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from supple.equations.control_linearization import LinearControl
from supple.errors import BasisWarning, ModelError
from supple.linearization.axisymmetry import RoundBody, shapes_without_copy, turn_generator
from supple.linearization.linear_machine import Array, LinearMachine, rigid_motions, slices_of
from supple.linearization.periodic import Periodic
from supple.machine import GROUND, Joint, Spin
from supple.simulation.resting_state import RestingState, placed_at_rest
from supple.simulation.turned_machine import CONSTANT, equations_turned_on, turning_bodies

FEW, SAMPLES = 7, 16
"""Numbers of angles of a revolution: `FEW` for comparing the equations, `SAMPLES` for their harmonics."""
FINE = 64
"""Least number of angles for the coordinates W alone; their derivatives are computed from their harmonics."""
PER_BLADE = 3
"""Angles per blade: the motion of N blades has up to N / 2 waves, the matrices harmonics of up to N + 2."""
BETWEEN = 0.7
"""Additional angle of comparison, rad: it detects variations that vanish at all evenly spaced angles."""
ROUNDING = 64 * np.finfo(float).eps
"""Rounding error of a sum, relative to its terms."""
CUT = 2
"""Largest number of shapes without a rotated copy that is taken for cut pairs of modes."""
SAME_PLACE = 1e-6
"""Allowed deviation of equal bodies from even spacing, relative to the size of the machine and in rad."""


class Sampled(NamedTuple):
    """Matrices (s, n, n), and rows (s, m, n) of the joints, at evenly spaced angles of one revolution."""

    mass: Array
    damping: Array
    stiffness: Array
    constraint: Array


@dataclass(frozen=True, eq=False)
class RotatingMachine:
    """A machine in steady rotation, with bodies whose coordinates may be other than those of the equilibrium.

    bodies : in the order of those of the equilibrium
    """

    found: RestingState
    time: float
    spin: Spin
    bodies: Sequence[RoundBody]

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Positions of the motions of each body among those of the machine."""
        return slices_of(self.bodies)

    @cached_property
    def turning(self) -> Array:
        """Mask (nb,): True for bodies that rotate."""
        return turning_bodies(self.found, self.spin)

    @cached_property
    def hub(self) -> int:
        """The rotating body connected by a joint, or else a force, to a standing part; else the first."""
        system = self.found.system
        elements: list[Any] = [*system.joints, *(load for load in system.loads if hasattr(load, "second"))]
        for element in sorted(elements, key=lambda each: not isinstance(each, Joint)):
            ends = [system.body_index(e.body) for e in (element.first, element.second) if e != GROUND]
            moving = [end for end in ends if self.turning[end]]
            if len(moving) == 1:
                return moving[0]
        return int(np.argmax(self.turning))

    @cached_property
    def equal_bodies(self) -> list[list[int]]:
        """Groups of three or more rotating bodies with equally many coordinates, evenly spaced, by angle."""
        placed, point = self.found.configuration, self.spin.point
        length = float(self.found.equations.model.length)
        left, groups = [int(body) for body in np.flatnonzero(self.turning) if body != self.hub], []
        while left:
            first = left[0]
            size = self.bodies[first].n_coordinates
            places = {}
            for body in (each for each in left if self.bodies[each].n_coordinates == size):
                turn = Rotation.from_matrix(placed.rotations[body] @ placed.rotations[first].T)
                angle = float(turn.as_rotvec() @ self.spin.axis)
                carried = point + turn.apply(placed.origins[first] - point)
                off = float(np.linalg.norm(carried - placed.origins[body]))
                about = np.linalg.norm(turn.as_rotvec() - angle * self.spin.axis)
                if off < SAME_PLACE * length and about < SAME_PLACE:
                    places[body] = angle % (2 * np.pi)
            order = sorted(places, key=lambda body: places[body])
            spaced = 2 * np.pi * np.arange(len(order)) / len(order)
            apart = abs(np.array([places[body] for body in order]) - spaced)
            if len(order) >= 3 and apart.max() < SAME_PLACE:
                groups.append(order)
                left = [each for each in left if each not in order]
            else:
                left = left[1:]
        return groups

    def axis_in_body(self, number: int) -> tuple[Array, Array]:
        """Direction of the axis of rotation, and a point on it, in the axes of a body."""
        rotation = self.found.configuration.rotations[number]
        return rotation.T @ self.spin.axis, rotation.T @ (
            self.spin.point - self.found.configuration.origins[number]
        )

    def turned(self, number: int, refusal: str = "") -> list[Any]:
        """The equations at evenly spaced angles.

        Raises ModelError, with a refusal, where the machine is not in equilibrium at one of them or beside.
        """
        angles = (2 * np.pi * np.arange(number) / number).tolist()
        if refusal:
            angles.append(BETWEEN)
        each = [equations_turned_on(self.found, self.time, self.spin, angle) for angle in angles]
        if refusal and max(one.unbalanced for one in each) > CONSTANT:
            raise ModelError(refusal)
        return [one.equations for one in each[:number]]

    def constant(self, sampled: Sampled) -> LinearMachine | None:
        """The machine in standing axes, from sampled equations; None if they vary in all coordinates.

        Its `basis` maps to the coordinates of the samples.
        """
        return _constant(self, _seen_in_every_way(self, sampled))


def in_standing_axes(found: RestingState, time: float, spin: Spin, refusal: str) -> LinearMachine:
    """The machine in standing axes: with constant equations if possible, otherwise with periodic ones.

    refusal : error message: why the machine is not linearised in co-rotating axes
    Raises ModelError for a machine with controllers, one whose equilibrium varies with rotation, or one whose
    joints leave other motions free at another angle.
    """
    if found.system.controllers:
        raise ModelError(refusal)
    machine = RotatingMachine(found, time, spin, [placed.body for placed in found.system.bodies])
    # A few angles suffice for constant equations; harmonics of varying ones need more.
    for number in (FEW, max(SAMPLES, PER_BLADE * max(map(len, machine.equal_bodies), default=0))):
        equations = machine.turned(number, refusal)
        sampled = Sampled(*(np.array([getattr(one, of) for one in equations]) for of in Sampled._fields))
        kept = _seen_in_every_way(machine, sampled)
        if not kept:
            raise ModelError(refusal)
        if (constant := _constant(machine, kept)) is not None:
            return constant
    _warn_of_cut_pairs(machine)
    return _linear(machine, kept[0], Periodic.of_samples(spin.rate, *kept[0].matrices))


def _warn_of_cut_pairs(machine: RotatingMachine) -> None:
    """Warn of bodies whose basis has one of two equal modes; any other asymmetry lacks more copies."""
    for number in map(int, np.flatnonzero(machine.turning)):
        if 0 < shapes_without_copy(machine.bodies[number], *machine.axis_in_body(number)) <= CUT:
            warnings.warn(
                f"body '{machine.found.system.bodies[number].body.name}': its mesh is symmetric about the "
                "axis of the spin, but its basis is not: a pair of equal modes is cut. The equations are "
                "therefore periodic, without estimated error and state space: keep one mode more, or one "
                "fewer",
                BasisWarning,
                stacklevel=6,
            )


def _constant(machine: RotatingMachine, kept: list[_Seen]) -> LinearMachine | None:
    return next((_linear(machine, each, None) for each in kept if each.change < CONSTANT), None)


def _linear(machine: RotatingMachine, seen: _Seen, periodic: Periodic | None) -> LinearMachine:
    mean = [matrix.mean(axis=0) for matrix in seen.matrices]
    mass, damping, stiffness = _without_noise(mean, machine.spin.rate)
    none = np.zeros((len(mass), 0))
    return LinearMachine(
        system=placed_at_rest(machine.found),
        spin=machine.spin,
        time=machine.time,
        mass=(mass + mass.T) / 2,
        damping=damping,
        stiffness=stiffness,
        basis=seen.motions,
        full_mass=seen.full_mass,
        control=LinearControl(none, none.T, none.T, np.zeros((0, 0))),
        is_in_space=True,
        periodic=periodic,
    )


class _Coordinates(NamedTuple):
    """`W` and its first and second derivative by the angle, (s, n, n) at s angles."""

    values: Array
    first: Array
    second: Array

    @classmethod
    def of_fine(cls, W: Array, number: int) -> _Coordinates:
        """Coordinates at `number` of the angles of W; the derivatives follow from the harmonics of all W."""
        harmonics = 1j * np.fft.fftfreq(len(W), 1 / len(W))[:, None, None]
        spectrum = np.fft.fft(W, axis=0)
        spectrum[abs(spectrum) < ROUNDING * abs(spectrum).max()] = 0.0
        found = (W, *(np.fft.ifft(harmonics**order * spectrum, axis=0).real for order in (1, 2)))
        return cls(*(each[:: len(W) // number] for each in found))


class _Seen(NamedTuple):
    """A machine in some coordinates z: free motions `W(0) N` (n, k), and their matrices.

    matrices : mass, damping and stiffness (s, k, k)
    change : largest variation of the matrices in a revolution, relative to the size of each row and column
    full_mass : (n, n) of p at the first angle
    """

    motions: Array
    matrices: tuple[Array, Array, Array]
    change: float
    full_mass: Array | csr_array


def _seen_in_every_way(machine: RotatingMachine, sampled: Sampled) -> list[_Seen]:
    """The machine in each set of coordinates in which joints leave the same motions free at all angles.

    Coordinates most likely to give constant equations come first.
    """
    number, blades = len(sampled.mass), max(map(len, machine.equal_bodies), default=0)
    fine = number * -(-max(FINE, PER_BLADE * blades) // number)
    angles = 2 * np.pi * np.arange(fine) / fine
    hub, blades = _hub_in_space(machine, angles), _multi_blade(machine, angles)
    ways = (hub @ (blades @ _round_bodies(machine, angles)), hub @ blades, hub)
    seen = (_seen(sampled, machine.spin, _Coordinates.of_fine(W, number)) for W in ways)
    return [each for each in seen if each is not None]


def _seen(sampled: Sampled, spin: Spin, coordinates: _Coordinates) -> _Seen | None:
    """The machine in some coordinates; None if the joints leave other motions free as the machine rotates."""
    W, first, second = coordinates
    rows = sampled.constraint @ W
    size = 1 / np.sqrt(np.einsum("ij,ij->j", W[0], sampled.mass[0] @ W[0]))
    basis = size[:, None] * scipy.linalg.null_space(rows[0] * size)
    opened = float(np.max(abs(rows @ basis) @ np.ones(basis.shape[1]), initial=0.0))
    if opened > CONSTANT * float(np.max(abs(rows) @ (abs(basis).sum(axis=1) + size), initial=1e-300)):
        return None
    rate, (M, C, K, _) = spin.rate, sampled
    damped = C @ W + 2 * rate * M @ first
    stiff = K @ W + rate * C @ first + rate**2 * M @ second
    left = basis.T @ W.transpose(0, 2, 1)
    matrices = (left @ (M @ W) @ basis, left @ damped @ basis, left @ stiff @ basis)
    return _Seen(W[0] @ basis, matrices, _change(matrices, rate), M[0])


def _without_noise(matrices: Sequence[Array], rate: float) -> Iterator[Array]:
    """The matrices with entries that are rounding errors set to zero, as they would disturb eigenvalues."""
    mass, _, stiffness = matrices
    size = np.sqrt(np.abs(np.diag(stiffness)) + rate**2 * np.diag(mass))
    for matrix, scale in zip(matrices, (rate**2, abs(rate), 1.0), strict=True):
        yield np.where(scale * abs(matrix) < ROUNDING * np.outer(size, size), 0.0, matrix)


def _change(matrices: tuple[Array, Array, Array], rate: float) -> float:
    """Largest variation in a revolution, relative to the size of each row and column."""
    mass, damping, stiffness = matrices
    size = np.sqrt(np.abs(np.diag(stiffness[0])) + rate**2 * np.diag(mass[0]))
    scales = (rate**2, abs(rate), 1.0)
    changes = (
        scale * abs(each - each[0]) / np.outer(size, size)
        for scale, each in zip(scales, (mass, damping, stiffness), strict=True)
    )
    return float(max(np.max(each, initial=0.0) for each in changes))


def _hub_in_space(machine: RotatingMachine, angles: Array) -> Array:
    """Map `S` (s, n, n) to the motions of rotating bodies from the hub's twist and motions relative to it.

    The twist of the hub is that of a point on the axis, in standing axes.
    """
    slices, placed, spin = machine.slices, machine.found.configuration, machine.spin
    n, bodies = slices[-1].stop, map(int, np.flatnonzero(machine.turning))
    with_hub = rigid_motions(
        n, ((slices[i].start, placed.rotations[i], placed.origins[i] - spin.point) for i in bodies)
    )
    back = Rotation.from_rotvec(-angles[:, None] * spin.axis).as_matrix()
    S = np.tile(np.eye(n), (len(angles), 1, 1))
    hub = slices[machine.hub].start + np.arange(6)
    S[:, :, hub[:3]] = with_hub[:, :3] @ back
    S[:, :, hub[3:]] = with_hub[:, 3:] @ back
    return S


def _round_bodies(machine: RotatingMachine, angles: Array) -> Array:
    """Map (s, n, n) to the motions of bodies with cyclic symmetry, in own axes, from standing axes."""
    T = np.tile(np.eye(machine.slices[-1].stop), (len(angles), 1, 1))
    blades = {body for group in machine.equal_bodies for body in group}
    for number in (int(each) for each in np.flatnonzero(machine.turning) if each not in blades):
        axis, point = machine.axis_in_body(number)
        generator = turn_generator(machine.bodies[number], axis, point)
        if generator is None:
            continue
        start = machine.slices[number].start
        if number != machine.hub:
            back = Rotation.from_rotvec(-angles[:, None] * axis).as_matrix()
            for part in (slice(start, start + 3), slice(start + 3, start + 6)):
                T[:, part, part] = back
        own = slice(start + 6, machine.slices[number].stop)
        T[:, own, own] = scipy.linalg.expm(-angles[:, None, None] * generator)
    return T


def _multi_blade(machine: RotatingMachine, angles: Array) -> Array:
    """Map `T` (s, n, n) to the coordinates of equal bodies from multi-blade coordinates.

    The multi-blade coordinates have the positions of the bodies' coordinates.
    """
    T = np.tile(np.eye(machine.slices[-1].stop), (len(angles), 1, 1))
    for group in machine.equal_bodies:
        parts = [machine.slices[body] for body in group]
        waves = _waves(len(group), angles)
        own = np.eye(parts[0].stop - parts[0].start)
        for row, part in enumerate(parts):
            for column, other in enumerate(parts):
                T[:, part, other] = waves[:, row, column, None, None] * own
    return T


def _waves(number: int, angles: Array) -> Array:
    """Coefficients (s, N, N) of a_0, a_1, b_1, a_2, .. in each body's coordinate."""
    at = angles[:, None] + 2 * np.pi * np.arange(number) / number
    columns = [np.ones_like(at)]
    for order in range(1, (number - 1) // 2 + 1):
        columns += [np.cos(order * at), np.sin(order * at)]
    if number % 2 == 0:
        columns.append(np.tile((-1.0) ** np.arange(number), (len(angles), 1)))
    return np.stack(columns, axis=2)
