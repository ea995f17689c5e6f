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
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from scipy.spatial.transform import Rotation

from supple.algebra.cross import cross_matrix
from supple.equations.control_linearization import LinearControl
from supple.errors import BasisWarning, ModelError
from supple.linearization.axisymmetry import shapes_without_copy, turn_generator
from supple.linearization.linear_machine import Array, LinearMachine
from supple.linearization.periodic import Periodic
from supple.machine import GROUND, Joint, Spin
from supple.simulation.resting_state import RestingState, placed_at_rest
from supple.simulation.turned_machine import CONSTANT, equations_turned_on, turning_bodies

__all__ = ["FEW", "BodyColumns", "Sampled", "axis_in_body", "constant_in_standing_axes", "in_standing_axes"]

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


class BodyColumns(NamedTuple):
    """Slices of the coordinates of each body among those of the machine, and the bodies.

    bodies : objects with `n_coordinates`; deformable ones also with `nodes` and a `nodal_basis`
    """

    slices: Sequence[slice]
    bodies: Sequence[Any]


def in_standing_axes(found: RestingState, time: float, spin: Spin, refusal: str) -> LinearMachine:
    """The machine in standing axes: with constant equations if possible, otherwise with periodic ones.

    refusal : error message: why the machine is not linearised in co-rotating axes
    Raises ModelError for a machine with controllers, one whose equilibrium varies with rotation, or one whose
    joints leave other motions free at another angle.
    """
    if found.system.controllers:
        raise ModelError(refusal)
    columns = BodyColumns(found.equations.slices, [placed.body for placed in found.system.bodies])
    largest = max(map(len, _equal_bodies(found, spin, columns)), default=0)
    # A few angles suffice for constant equations; harmonics of varying ones need more.
    for number in (FEW, max(SAMPLES, PER_BLADE * largest)):
        sampled = _sampled(found, time, spin, number, refusal)
        kept = _seen_in_every_way(found, spin, columns, sampled)
        if not kept:
            raise ModelError(refusal)
        constant = _constant(kept)
        if constant is not None:
            return _machine(found, time, spin, constant, None)
    _warn_of_cut_pairs(found, spin, columns)
    return _machine(found, time, spin, kept[0], Periodic.of_samples(spin.rate, *kept[0].matrices))


def _warn_of_cut_pairs(found: RestingState, spin: Spin, columns: BodyColumns) -> None:
    """Warn of bodies whose basis has one of two equal modes; any other asymmetry lacks more copies."""
    for number in map(int, np.flatnonzero(turning_bodies(found, spin))):
        body, (axis, point) = columns.bodies[number], axis_in_body(found, spin, number)
        if 0 < shapes_without_copy(body, axis, point) <= CUT:
            warnings.warn(
                f"body '{body.name}': its mesh is symmetric about the axis of the spin, but its basis is "
                "not: a pair of equal modes is cut. The equations are therefore periodic, without estimated "
                "error and state space: keep one mode more, or one fewer",
                BasisWarning,
                stacklevel=6,
            )


def constant_in_standing_axes(
    found: RestingState, time: float, spin: Spin, columns: BodyColumns, sampled: Sampled
) -> LinearMachine | None:
    """The machine in standing axes, from sampled equations; None if no coordinates make them constant.

    Its `basis` maps to the coordinates of the samples.
    """
    constant = _constant(_seen_in_every_way(found, spin, columns, sampled))
    return None if constant is None else _machine(found, time, spin, constant, None)


def _constant(kept: list[_Seen]) -> _Seen | None:
    return next((each for each in kept if each.change < CONSTANT), None)


def _machine(
    found: RestingState, time: float, spin: Spin, seen: _Seen, periodic: Periodic | None
) -> LinearMachine:
    mass, damping, stiffness = _without_noise([matrix.mean(axis=0) for matrix in seen.matrices], spin.rate)
    return LinearMachine(
        system=placed_at_rest(found),
        spin=spin,
        time=time,
        mass=(mass + mass.T) / 2,
        damping=damping,
        stiffness=stiffness,
        basis=seen.motions,
        full_mass=seen.full_mass,
        control=_no_control(len(mass)),
        is_in_space=True,
        periodic=periodic,
    )


def _sampled(found: RestingState, time: float, spin: Spin, number: int, refusal: str) -> Sampled:
    angles = (2 * np.pi * np.arange(number) / number).tolist()
    each = [equations_turned_on(found, time, spin, angle) for angle in angles]
    between = equations_turned_on(found, time, spin, BETWEEN)
    if max(one.unbalanced for one in (*each, between)) > CONSTANT:
        raise ModelError(refusal)
    equations: list[Any] = [one.equations for one in each]
    return Sampled(*(np.array([getattr(one, name) for one in equations]) for name in Sampled._fields))


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
    full_mass: Array


def _seen_in_every_way(
    found: RestingState, spin: Spin, columns: BodyColumns, sampled: Sampled
) -> list[_Seen]:
    """The machine in each set of coordinates in which joints leave the same motions free at all angles."""
    ways = _ways(found, spin, columns, len(sampled.mass))
    seen = (_seen(sampled, spin, coordinates) for coordinates in ways)
    return [each for each in seen if each is not None]


def _ways(found: RestingState, spin: Spin, columns: BodyColumns, number: int) -> Iterator[_Coordinates]:
    """Coordinates to try, those most likely to give constant equations first."""
    groups = _equal_bodies(found, spin, columns)
    fine = number * -(-max(FINE, PER_BLADE * max(map(len, groups), default=0)) // number)
    angles = 2 * np.pi * np.arange(fine) / fine
    hub = _hub_in_space(found, spin, columns, angles)
    blades = _multi_blade(columns, groups, angles)
    in_groups = [body for group in groups for body in group]
    round_bodies = _round_bodies(found, spin, columns, in_groups, angles)
    for W in (hub @ (blades @ round_bodies), hub @ blades, hub):
        yield _Coordinates.of_fine(W, number)


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


def _starts(columns: BodyColumns) -> Array:
    return np.array([part.start for part in columns.slices])


def _hub(found: RestingState, turning: Array) -> int:
    """The rotating body connected by a joint, or else a force, to a standing part; by default the first."""
    system = found.system
    elements: list[Any] = [*system.joints, *(load for load in system.loads if hasattr(load, "second"))]
    for element in sorted(elements, key=lambda each: not isinstance(each, Joint)):
        ends = [
            None if end == GROUND else system.body_index(end.body) for end in (element.first, element.second)
        ]
        moving = [end for end in ends if end is not None and turning[end]]
        if len(moving) == 1:
            return moving[0]
    return int(np.argmax(turning))


def _hub_in_space(found: RestingState, spin: Spin, columns: BodyColumns, angles: Array) -> Array:
    """Map `S` (s, n, n) to the motions of rotating bodies from the hub's twist and motions relative to it.

    The twist of the hub is that of a point on the axis, in standing axes.
    """
    turning, starts = turning_bodies(found, spin), _starts(columns)
    n = columns.slices[-1].stop
    with_hub, configuration = np.zeros((n, 6)), found.configuration
    for body in np.flatnonzero(turning):
        axes, arm = configuration.rotations[body].T, configuration.origins[body] - spin.point
        start = starts[body]
        with_hub[start : start + 3, :3] = with_hub[start + 3 : start + 6, 3:] = axes
        with_hub[start : start + 3, 3:] = -axes @ cross_matrix(arm)
    back = Rotation.from_rotvec(-angles[:, None] * spin.axis).as_matrix()
    S = np.tile(np.eye(n), (len(angles), 1, 1))
    hub = starts[_hub(found, turning)] + np.arange(6)
    S[:, :, hub[:3]] = with_hub[:, :3] @ back
    S[:, :, hub[3:]] = with_hub[:, 3:] @ back
    return S


def _equal_bodies(found: RestingState, spin: Spin, columns: BodyColumns) -> list[list[int]]:
    """Groups of three or more rotating bodies with equally many coordinates, evenly spaced, by angle."""
    turning, configuration = turning_bodies(found, spin), found.configuration
    hub, slices = _hub(found, turning), columns.slices
    length = float(found.equations.model.length)
    left, groups = [int(body) for body in np.flatnonzero(turning) if body != hub], []
    while left:
        first = left[0]
        alike = [each for each in left if _length(slices[each]) == _length(slices[first])]
        places = {}
        for body in alike:
            turn = Rotation.from_matrix(configuration.rotations[body] @ configuration.rotations[first].T)
            angle = float(turn.as_rotvec() @ spin.axis)
            carried = spin.point + turn.apply(configuration.origins[first] - spin.point)
            off = float(np.linalg.norm(carried - configuration.origins[body]))
            about = np.linalg.norm(turn.as_rotvec() - angle * spin.axis)
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


def _round_bodies(
    found: RestingState, spin: Spin, columns: BodyColumns, blades: list[int], angles: Array
) -> Array:
    """Map (s, n, n) to the motions of bodies with cyclic symmetry, in own axes, from standing axes."""
    turning = turning_bodies(found, spin)
    hub, slices = _hub(found, turning), columns.slices
    T = np.tile(np.eye(slices[-1].stop), (len(angles), 1, 1))
    for number in map(int, np.flatnonzero(turning)):
        if number in blades:
            continue
        axis, point = axis_in_body(found, spin, number)
        generator = turn_generator(columns.bodies[number], axis, point)
        if generator is None:
            continue
        start = slices[number].start
        back = Rotation.from_rotvec(-angles[:, None] * axis).as_matrix()
        if number != hub:
            T[:, start : start + 3, start : start + 3] = T[
                :, start + 3 : start + 6, start + 3 : start + 6
            ] = back
        own = slice(start + 6, slices[number].stop)
        T[:, own, own] = scipy.linalg.expm(-angles[:, None, None] * generator)
    return T


def axis_in_body(found: RestingState, spin: Spin, number: int) -> tuple[Array, Array]:
    """Direction of the axis of rotation, and a point on it, in the axes of a body."""
    rotation = found.configuration.rotations[number]
    return rotation.T @ spin.axis, rotation.T @ (spin.point - found.configuration.origins[number])


def _length(part: slice) -> int:
    return part.stop - part.start


def _multi_blade(columns: BodyColumns, groups: list[list[int]], angles: Array) -> Array:
    """Map `T` (s, n, n) to the coordinates of equal bodies from multi-blade coordinates.

    The multi-blade coordinates have the positions of the bodies' coordinates.
    """
    n = columns.slices[-1].stop
    T = np.tile(np.eye(n), (len(angles), 1, 1))
    for group in groups:
        parts = [columns.slices[body] for body in group]
        waves = _waves(len(group), angles)
        own = np.eye(_length(parts[0]))
        for row, part in enumerate(parts):
            for column, other in enumerate(parts):
                T[:, part, other] = waves[:, row, column, None, None] * own
    return T


def _waves(number: int, angles: Array) -> Array:
    """Coefficients (s, N, N) of a_0, a_1, b_1, a_2, .. in each body's coordinate."""
    at = angles[:, None] + 2 * np.pi * np.arange(number) / number
    columns: list[Any] = [np.ones_like(at)]
    for order in range(1, (number - 1) // 2 + 1):
        columns += [np.cos(order * at), np.sin(order * at)]
    if number % 2 == 0:
        columns.append(np.tile((-1.0) ** np.arange(number), (len(angles), 1)))
    return np.stack(columns, axis=2)


def _no_control(size: int) -> LinearControl:
    return LinearControl(np.zeros((size, 0)), np.zeros((0, size)), np.zeros((0, size)), np.zeros((0, 0)))
