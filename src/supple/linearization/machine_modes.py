"""Eigenvalues and mode shapes of a machine."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from supple.arguments import checked_arguments
from supple.errors import ModelError
from supple.linearization.linear_machine import Array, FullMachine, LinearMachine, mass_squares
from supple.linearization.mode_error import MORE, ModeError, mode_error
from supple.linearization.periodic import floquet_modes
from supple.linearization.slowest_motions import Pairs, slowest_motions
from supple.linearization.sparse_machine import SparseMachine, slow_first
from supple.linearization.standing_error import slowest_in_standing_axes
from supple.summary import Summarized, Summary

__all__ = ["MachineModes", "damping_in_space", "machine_modes"]

_MOTIONLESS = 1e-12
"""Norm of motion and velocity, relative to that of all states, below which only controllers take part in a
mode."""

_NO_DAMPING = 1e-12
"""Largest damping ratio that counts as a rounding error."""

_FREE_SCALE = 2.0**26
"""Scale of the positions of free motions, large as that of slow ones in balanced coordinates."""

_MOVING = 1e-6
"""Size of the rates of free motions in a unit vector above which it belongs to their second pole at zero."""

_ROUNDING = 512.0
"""Rounding error of stiffness terms that cancel, relative to the terms, in units of the floating-point
precision."""


@dataclass(frozen=True, eq=False, repr=False)
class MachineModes(Summarized):
    """Free motions `p(t) = Re( shape exp(eigenvalue t) )` of a linearised machine, slowest first.

    With controllers the motions are those of the closed loop, and `z(t) = Re( states exp(eigenvalue t) )`;
    pure controller modes have a zero shape.

    eigenvalues : complex (k,)      1/s: of each conjugate pair the one above the real axis, one of the two
                                    zeros of each free rigid motion, and all other real eigenvalues
    shapes : complex (n, k)         motions of frames, in the frames' own axes, and deformation coordinates,
                                    with unit kinetic energy norm `shape^H M shape = 1` and the largest
                                    independent coordinate real
    independent : complex (m, k)    the shapes in the coordinates of the `LinearMachine`
    states : complex (c, k)         states of the controllers
    error : ModeError | None        basis errors; None without known full bodies
    """

    machine: LinearMachine
    eigenvalues: np.ndarray
    independent: np.ndarray
    states: np.ndarray
    error: ModeError | None = None

    def summary(self) -> Summary:
        """Frequency, damping ratio and the body with the largest share of kinetic energy, by mode."""
        names = [placed.body.name for placed in self.machine.system.bodies]
        most = self.kinetic_shares.argmax(axis=0)
        each = zip(self.frequencies / (2 * np.pi), self.damping_ratios, most, strict=True)
        rows = [
            (f"mode {i}", f"{hertz:.5g} cycles per unit of time, damping {ratio:.3g}, most in {names[body]}")
            for i, (hertz, ratio, body) in enumerate(each, 1)
        ]
        return Summary(f"{len(rows)} modes of a machine of {len(names)} bodies", rows)

    @property
    def shapes(self) -> np.ndarray:
        """Shapes of frames and deformation coordinates, (n, k)."""
        return self.machine.basis @ self.independent

    @property
    def frequencies(self) -> np.ndarray:
        """Damped angular frequencies, rad/s, (k,); zero for motions that do not oscillate."""
        return self.eigenvalues.imag

    @property
    def damping_ratios(self) -> np.ndarray:
        """`-Re(s) / |s|`, (k,): negative for unstable modes, 0 for rigid motions and rounding errors."""
        return damping_in_space(self.eigenvalues, self.frequencies)

    @property
    def kinetic_shares(self) -> np.ndarray:
        """Each body's share of the kinetic energy, in co-rotating axes, (nb, k); columns sum to 1.

        Zero for a mode without motion.
        """
        machine, shapes = self.machine, self.shapes
        weighted = np.real(shapes.conj() * (machine.full_mass @ shapes))
        energies = np.add.reduceat(weighted, [own.start for own in machine.slices], axis=0)
        whole = energies.sum(axis=0)
        return energies / np.where(whole > 0, whole, 1.0)

    @property
    def unstable(self) -> np.ndarray:
        """Mask (k,): True for modes that grow by more than rounding errors."""
        # Round-off is relative to the fastest motion, even if that is not among the modes.
        squares = abs(np.diag(self.machine.stiffness)) / np.diag(self.machine.mass)
        largest = max(float(np.max(abs(self.eigenvalues))), float(np.sqrt(squares.max())))
        return self.eigenvalues.real > 1e-7 * largest


def damping_in_space(eigenvalues: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """Damping ratios `-Re(s) / |s|` of motions with given frequencies Im(s); NaN where these are unknown.

    The decay rate -Re(s) is the same in all axes. The frequency is not, and therefore the damping ratio.
    Rigid motions and rounding errors have none.
    """
    size = np.hypot(eigenvalues.real, frequencies)
    ratios = -eigenvalues.real / np.where(size == 0, np.inf, size)
    return np.where(abs(ratios) <= _NO_DAMPING, 0.0, ratios)


@checked_arguments
def machine_modes(machine: LinearMachine | SparseMachine, n_modes: int | None = None) -> MachineModes:
    """The slowest modes of a linearised machine; all by default.

        ( s^2 M + s C + K ) y = H z,        ( s - E_z ) z = ( E_p + s E_v ) y

    A free rigid motion has two poles at s = 0. Poles that are zero within rounding are set to 0, and each
    free motion counts as one mode.

    For periodic equations the modes are Floquet modes (`floquet_modes`): shape and eigenvalue are those of
    the harmonic with most of the motion.

    For a machine with full bodies the slowest modes are found by shift and invert (`slowest_motions`); with
    damping or gyroscopic terms, a slower mode may be missed.

    If the full bodies of reduced ones are known (`linearize`), and `n_modes` is given, the modes are also
    computed with all coordinates. The difference gives the basis errors (`MachineModes.error`).

    Warns BasisWarning of modes whose eigenvalue is off by 1 % or more, and of modes missing from the bases.

    Raises
    ------
    ModelError      a number that is not positive; all modes of a large machine with full bodies
    AccuracyError   modes of a machine with full bodies, or Floquet modes, that do not converge
    """
    if n_modes is not None and not (n_modes >= 1 and n_modes == int(n_modes)):
        raise ModelError(f"number of modes must be a whole number, at least 1, got {n_modes}")
    n_modes = None if n_modes is None else int(n_modes)
    if isinstance(machine, SparseMachine):
        machine = machine.along(slowest_motions(machine, n_modes, _pairs))
    values, y, z = _pairs(machine) if machine.periodic is None else _floquet(machine, n_modes)
    values, y, z = values[:n_modes], y[:, :n_modes], z[:, :n_modes]
    largest = np.take_along_axis(y, np.argmax(abs(y), axis=0)[None], axis=0)[0]
    turned = np.where(largest == 0, 1.0, abs(largest) / np.where(largest == 0, 1.0, largest))
    modes = MachineModes(machine, values, y * turned, z * turned)
    if machine.full is None or n_modes is None:
        return modes
    exact, motions = _in_all_coordinates(machine.full, len(values) + MORE)
    error = mode_error(machine.full, values, modes.shapes, exact, motions)
    error.warn(values)
    return replace(modes, error=error)


def _floquet(machine: LinearMachine, n_modes: int | None) -> Pairs:
    """Eigenvalues, motions (k, ..) of the harmonic with most of the motion, and no states, slowest first."""
    assert machine.periodic is not None
    graded = _slow_first(machine)
    found = floquet_modes(machine.periodic.along(graded), n_modes)
    y = graded @ found.principal
    sizes = np.sqrt(mass_squares(y, machine.mass))
    return found.eigenvalues, y / np.where(sizes > 0, sizes, 1.0), np.zeros((0, y.shape[1]))


def _in_all_coordinates(full: FullMachine, n_modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and shapes (n, k) of the slowest modes, of a small machine all, in the axes of `full`."""
    machine, n_modes = full.machine, min(n_modes, full.machine.size)
    if full.standing is not None:
        return slowest_in_standing_axes(machine, full.standing, n_modes, _pairs)
    along = machine.along(slowest_motions(machine, n_modes, _pairs))
    values, y, _ = _pairs(along)
    return values[:n_modes], along.basis @ y[:, :n_modes]


def _pairs(machine: LinearMachine) -> Pairs:
    """Eigenvalues, motions (k, ..) of unit kinetic energy norm and states of controllers, slowest first."""
    k = machine.size
    graded, free = _free_apart(machine, _slow_first(machine))
    inner = replace(
        machine,
        mass=graded.T @ machine.mass @ graded,
        damping=graded.T @ machine.damping @ graded,
        stiffness=graded.T @ machine.stiffness @ graded,
        control=machine.control.along(graded),
    )
    lower = np.linalg.cholesky(inner.mass)
    state, unit = _state_matrix(inner, lower)
    # No force depends on the positions of free motions: without these, their velocities alone have a pole at
    # zero. Eigenvectors of several equal double poles would be those of one of the motions.
    kept = np.concatenate([~free, np.ones(len(state) - k, dtype=bool)])
    # States of controllers have different units: balancing makes their size comparable.
    balanced, (factors, _) = scipy.linalg.matrix_balance(
        state[np.ix_(kept, kept)], permute=False, separate=True
    )
    values, left, found = scipy.linalg.eig(balanced, left=True)
    scales, right = np.full(len(state), _FREE_SCALE), np.zeros((len(state), len(values)), dtype=complex)
    scales[kept], right[kept] = factors, found
    rates = (scales[:, None] * right)[k : 2 * k][free]
    right[:k][free] = unit / _FREE_SCALE * rates / np.where(values == 0, unit, values)
    motions = graded @ scipy.linalg.solve_triangular(lower.T, scales[:k, None] * right[:k])
    zero = _is_zero(values, left, found, unit / np.sqrt(k)) | _is_rigid(machine, values, motions)
    values, vectors = _one_of_each(np.where(zero, 0.0, values), right, scales, free)
    still = np.linalg.norm(vectors[: 2 * k], axis=0) < _MOTIONLESS
    vectors = scales[:, None] * vectors
    # Among modes equally slow within rounding, growing ones come first.
    order = np.lexsort((-values.real, np.array([float(f"{size:.8g}") for size in abs(values)])))
    values, vectors, still = values[order], vectors[:, order], still[order]
    y = graded @ scipy.linalg.solve_triangular(lower.T, np.where(still, 0.0, vectors[:k]))
    sizes = np.sqrt(mass_squares(y, machine.mass))
    sizes = np.where(still, np.linalg.norm(vectors[2 * k :], axis=0), sizes)
    return values, y / sizes, vectors[2 * k :] / sizes


def _slow_first(machine: LinearMachine) -> Array:
    """Coordinates (k, k) that separate slow and stiff motions."""
    square = 1e-9 * float(np.max(abs(np.diag(machine.stiffness)) / np.diag(machine.mass))) or 1.0
    return slow_first(machine.mass, machine.stiffness, square)


def _is_rigid(machine: LinearMachine, values: np.ndarray, motions: np.ndarray) -> np.ndarray:
    """Whether inertia, damping and stiffness terms of motions (k, ..) are all rounding of large terms.

    Beside a spring of stiffness k, a free motion has a rounding error of `eps k` in its stiffness; its
    `|s|^2 M + |s| C` is smaller than that.
    """

    def of_shape(matrix: Array) -> Array:
        return abs(np.einsum("ij,ij->j", motions.conj(), matrix @ motions))

    size = abs(motions)
    rounding = np.einsum("ij,ij->j", size, abs(machine.stiffness) @ size)
    left = abs(values) ** 2 * of_shape(machine.mass) + abs(values) * of_shape(machine.damping)
    return (rounding > 0) & (left < _ROUNDING * np.finfo(float).eps * rounding)


def _state_matrix(machine: LinearMachine, lower: Array) -> tuple[Array, float]:
    """State matrix of `(u y, y', z)`, y in the mass norm, and u.

    u is a typical frequency, with which motions and velocities are of similar size.
    """
    k, control = machine.size, machine.control

    def from_right(part: Array) -> Array:
        return scipy.linalg.solve_triangular(lower, part.T, lower=True).T

    damping, stiffness = (
        scipy.linalg.solve_triangular(lower, from_right(part), lower=True)
        for part in (machine.damping, machine.stiffness)
    )
    forces = scipy.linalg.solve_triangular(lower, control.forces, lower=True)
    unit = float(np.sqrt(np.linalg.norm(stiffness))) or 1.0
    rows = [
        [np.zeros((k, k)), unit * np.eye(k), np.zeros((k, control.size))],
        [-stiffness / unit, -damping, forces],
        [from_right(control.by_position) / unit, from_right(control.by_velocity), control.by_state],
    ]
    return np.block(rows), unit


def _is_zero(values: np.ndarray, left: np.ndarray, right: np.ndarray, unit: float) -> np.ndarray:
    """Whether eigenvalues are zero within rounding.

    A rounding error e of the matrix changes an eigenvalue by e / `|w^H v|`, with the left and right unit
    eigenvectors w and v. These are nearly orthogonal for the two zeros of a free motion, but not for a single
    slow pole.
    """
    moved = abs(values) * abs(np.einsum("ij,ij->j", left.conj(), right))
    return (abs(values) < 3e-7 * unit) & (moved < 1e-12 * unit)


def free_motions(machine: LinearMachine) -> Array:
    """Motions (k, f) of modes with the eigenvalue 0, orthonormal in the mass norm."""
    values, y, _ = _pairs(machine)
    upper = np.linalg.cholesky(machine.mass).T
    free, _ = np.linalg.qr(upper @ y[:, values == 0].real)
    return np.asarray(scipy.linalg.solve_triangular(upper, free))


def _free_apart(machine: LinearMachine, graded: Array) -> tuple[Array, np.ndarray]:
    """Coordinates (k, k) with the free motions among them, and the mask (k,) of these.

    Of symmetric forces the free motions are among the `graded` coordinates. A force that depends on other
    motions than it acts on, such as the torque of a wheel by the angle of a hub, leaves combinations of them
    free: the null space of the forces and readings, relative to the terms that cancel in them.
    """
    free, read = _is_free(machine, graded), machine.control.by_position
    others, rounding = graded[:, ~free], _ROUNDING * np.finfo(float).eps
    forces, size = others.T @ machine.stiffness @ others, abs(others)
    terms = size.T @ abs(machine.stiffness) @ size
    if not read.any() and (abs(forces - forces.T) <= rounding * terms).all():
        return graded, free
    rows = np.vstack([forces, read @ others])
    largest = np.vstack([terms, abs(read) @ size]).max(axis=1, keepdims=True, initial=0.0)
    _, sizes, motions = np.linalg.svd(rows / np.where(largest > 0, largest, 1.0))
    null = motions[np.count_nonzero(sizes > rounding) :]
    n = len(null)
    if not n:
        return graded, free
    # The coordinates least like them remain, slow ones first, orthogonal to them.
    _, _, order = scipy.linalg.qr(null, pivoting=True)
    turned, _ = np.linalg.qr(np.vstack([null, np.eye(len(order))[np.sort(order[n:])]]).T)
    found = np.hstack([graded[:, free], others @ turned])
    return found, np.arange(len(free)) < np.count_nonzero(free) + n


def _is_free(machine: LinearMachine, graded: Array) -> np.ndarray:
    """Mask (k,) of motions in `graded` coordinates on whose position no force and no controller depends."""
    rounding, size = _ROUNDING * np.finfo(float).eps, abs(graded)
    stiffness, read = machine.stiffness, machine.control.by_position
    forces = abs(graded.T @ stiffness @ graded) <= rounding * (size.T @ abs(stiffness) @ size)
    readings = abs(read @ graded) <= rounding * (abs(read) @ size)
    return forces.all(axis=0) & readings.all(axis=0)


def _one_of_each(
    values: np.ndarray, vectors: np.ndarray, scales: Array, free: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The eigenvalue of each conjugate pair above the real axis; as many zeros as independent vectors.

    Each free rigid motion has two poles at zero, of position and rate: they count as one mode. The motions
    `free` are unit vectors; other vectors at zero with the rate of one belong to its second pole.
    """
    k = len(free)
    zero = values == 0
    kept = (values.imag >= 0) & ~zero
    at_zero = np.hstack([vectors[:, zero].real, vectors[:, zero].imag])
    _, sizes, rows = np.linalg.svd(at_zero[k : 2 * k][free])
    at_zero = at_zero @ rows[np.count_nonzero(sizes > _MOVING) :].T
    at_zero[k : 2 * k] = 0.0  # rates, which are rounding
    at_zero[:k][free] = 0.0
    at_zero = np.hstack([np.eye(len(at_zero), k)[:, free], at_zero])
    # Positions in the mass norm: in balanced units, the strain due to the rate of a free rotation is as
    # large as the rotation.
    weights, places = np.ones((len(at_zero), 1)), scales[:k, None] * at_zero[:k]
    weights[:k, 0] = scales[:k] * np.linalg.norm(at_zero[:k]) / (np.linalg.norm(places) or 1.0)
    directions, sizes, _ = np.linalg.svd(weights * at_zero, full_matrices=False)
    directions = directions[:, sizes > 1e-5 * max(sizes.max(initial=0.0), 1e-300)] / weights
    values = np.concatenate([np.zeros(directions.shape[1]), values[kept]])
    return values, np.hstack([directions, vectors[:, kept]])
