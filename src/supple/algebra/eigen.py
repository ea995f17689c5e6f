"""The lowest vibration modes of a sparse pair (K, M), certified complete by an inertia count."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, sparse
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from supple.algebra.constrained_solve import ConstrainedFactor, GroundedFactor, constrained_factor, dense_rows
from supple.algebra.orthonormalize import mass_orthonormalize
from supple.algebra.sparse_factor import DirectSolver, Matrix, SparseFactor, factorize_symmetric
from supple.arrays import FloatArray
from supple.errors import AccuracyError, ModelError

__all__ = ["Eigenpairs", "count_below", "lowest_modes"]

# Below this size a dense solution is as fast and finds every mode at once.
LARGEST_DENSE = 400

# Freedoms above which factors of a solid take gigabytes: factoring again is cheaper than storing two factors.
LARGEST_WITH_TWO_FACTORS = 100_000

LARGEST_RESIDUAL = 1e-6
"""Allowed relative residual of a mode in its equation."""
GUARD_MODES = 4
"""Number of modes computed in addition to the missing ones."""
ROUNDS = 4
"""Largest number of rounds of search and count."""


class Eigenpairs(NamedTuple):
    """Eigenvalues (k,) in ascending order, rad^2/s^2, and M-orthonormal vectors (n, k)."""

    values: FloatArray
    vectors: FloatArray


def lowest_modes(
    stiffness: Matrix | sparse.sparray,
    mass: Matrix | sparse.sparray,
    n_modes: int,
    *,
    constraint: ArrayLike | sparse.sparray | None = None,
    grounded: GroundedFactor | None = None,
    solver: DirectSolver | None = None,
) -> Eigenpairs:
    """The n_modes lowest modes of K x = lambda M x on {x : D x = 0}, with proof that none below was missed.

    Shift-invert Lanczos (ARPACK) at a negative shift -s, so a free body's singular K needs no special
    treatment. On constrained space the inverse of K + s M is, exactly and sparsely,

        P b = z - Y (D Y)^-1 D z,     z = (K + s M)^-1 b,     Y = (K + s M)^-1 D^T.

    At a shift t in the gap above the last mode found, Sylvester's law counts the modes below t,

        neg(K - t M) + pos(D (K - t M)^-1 D^T) - m     (Haynsworth),

    and missed modes (clusters, symmetries) are searched in the complement of those found.

    Parameters
    ----------
    stiffness, mass : sparse array (n, n)   symmetric; K positive semi-definite, M positive definite
    n_modes         : int                   0 <= n_modes <= n - m
    constraint      : array (m, n) or None  D of full row rank; R^T M leaves the elastic modes of a free body
    grounded        : GroundedFactor        a factor of this stiffness, as for `count_below`; above 100 000
                                            freedoms its numbers are released, and computed again on its use
    Returns
    -------
    Eigenpairs   .values (n_modes,) ascending, .vectors (n, n_modes) with X^T M X = I, largest entry positive
    Raises
    ------
    ModelError      wrong shapes; more modes than freedoms; K not positive semi-definite
    AccuracyError   the count and the modes found disagree, or a mode violates its equation
    """
    stiffness = sparse.csc_array(stiffness, dtype=np.float64)
    mass = sparse.csc_array(mass, dtype=np.float64)
    n = stiffness.indptr.size - 1
    if stiffness.shape != (n, n) or mass.shape != (n, n):
        raise ModelError(f"stiffness {stiffness.shape} and mass {mass.shape} must be square and of one size")
    D = dense_rows(constraint, n)
    freedoms = n - len(D)
    if not 0 <= n_modes <= freedoms:
        raise ModelError(f"{n_modes} modes requested of a body with {freedoms} freedoms: request fewer")
    if n_modes == 0:
        return Eigenpairs(np.zeros(0), np.zeros((n, 0)))
    if n <= LARGEST_DENSE or 3 * (n_modes + GUARD_MODES) > freedoms:
        return _dense_modes(stiffness, mass, n_modes, D)

    if grounded is not None and n > LARGEST_WITH_TWO_FACTORS:
        grounded.factor.release()
    factorize = _factorization(grounded, solver)
    inverse, shift = _shifted_factor(stiffness, mass, D, factorize)
    values, vectors = _certified_modes(mass, n_modes, inverse, shift, factorize)
    return Eigenpairs(values, _fixed_sign(vectors))


def count_below(
    stiffness: Matrix,
    mass: Matrix,
    value: float,
    *,
    constraint: ArrayLike | sparse.sparray | None = None,
    grounded: GroundedFactor | None = None,
    solver: DirectSolver | None = None,
) -> int:
    """Number of eigenvalues of K x = lambda M x on {x : D x = 0} below a value, by Sylvester's law.

        neg(K - t M) + pos(D (K - t M)^-1 D^T) - m     (Haynsworth)

    One sparse factor; no eigenvector is needed. A free body's rigid motions count as eigenvalues zero.

    Parameters
    ----------
    stiffness, mass : sparse array (n, n)   symmetric, M positive definite
    value           : float                 t, rad^2/s^2, away from any eigenvalue
    constraint      : array (m, n) or None  D of full row rank
    grounded        : GroundedFactor        a factor of this stiffness, whose symbolic analysis is reused if
                                            the mass has no entries beyond those of the stiffness
    Raises
    ------
    ModelError      wrong shapes
    AccuracyError   the value is an eigenvalue to working precision
    """
    shifted = sparse.csc_array(stiffness - value * mass)
    D = dense_rows(constraint, shifted.indptr.size - 1)
    return _count_negative(_factorization(grounded, solver)(shifted), D)


_Factorization = Callable[[sparse.csc_array], SparseFactor]


def _factorization(grounded: GroundedFactor | None, solver: DirectSolver | None) -> _Factorization:
    """Factorisation of shifted matrices, with the symbolic analysis of a known factor if it applies."""

    def factorize(shifted: sparse.csc_array) -> SparseFactor:
        shifted.sort_indices()
        if grounded is not None and _same_pattern(shifted, grounded.stiffness):
            return grounded.factor.refactorize(shifted)
        return factorize_symmetric(shifted, solver=solver)

    return factorize


def _same_pattern(one: sparse.csc_array, other: sparse.csc_array) -> bool:
    return np.array_equal(one.indptr, other.indptr) and np.array_equal(one.indices, other.indices)


def _dense_modes(
    stiffness: sparse.csc_array, mass: sparse.csc_array, n_modes: int, D: FloatArray
) -> Eigenpairs:
    K, M = stiffness.toarray(), mass.toarray()
    Z = np.linalg.qr(D.T, mode="complete").Q[:, len(D) :] if len(D) else np.eye(len(K))
    K, M = Z.T @ K @ Z, Z.T @ M @ Z
    K, M = 0.5 * (K + K.T), 0.5 * (M + M.T)
    shift = _first_shift(stiffness, mass)
    values, vectors = _lowest_by_inverse(K, M, shift, n_modes)
    elastic = values[values > 1e3 * shift]
    if 0 < elastic.size < n_modes:
        # Rigid motions dominate the inverse, so that elastic modes lose digits: use a closer shift.
        values, vectors = _lowest_by_inverse(K, M, 1e-3 * float(elastic[0]), n_modes)
    return Eigenpairs(values, _fixed_sign(Z @ vectors))


def _lowest_by_inverse(
    K: FloatArray, M: FloatArray, shift: float, n_modes: int
) -> tuple[FloatArray, FloatArray]:
    """Lowest modes as the highest of M x = mu (K + s M) x: round-off is then relative to the lowest mode."""
    last = len(K) - 1
    try:
        mu, vectors = linalg.eigh(M, K + shift * M, subset_by_index=(last - n_modes + 1, last))
    except linalg.LinAlgError as error:
        raise ModelError(
            "the stiffness is not positive semi-definite: "
            f"it has the eigenvalue {linalg.eigh(K, M, eigvals_only=True)[0]:.3e}"
        ) from error
    mu, vectors = mu[::-1], vectors[:, ::-1]
    return 1 / mu - shift, vectors / np.sqrt(mu)


def _first_shift(stiffness: sparse.csc_array, mass: sparse.csc_array) -> float:
    """A shift far below the elastic eigenvalues of most bodies, far above rounded zero eigenvalues."""
    return 1e-9 * float(np.max(np.divide(stiffness.diagonal(), mass.diagonal())))


def _shifted_factor(
    stiffness: sparse.csc_array,
    mass: sparse.csc_array,
    D: FloatArray,
    factorize: _Factorization,
) -> tuple[ConstrainedFactor, float]:
    """Factor K + s M, s a small fraction of the requested eigenvalues, estimated by subspace iteration."""
    n = D.shape[1]
    shift = _first_shift(stiffness, mass)
    start = np.random.default_rng(0).standard_normal((n, 8))
    while True:
        shifted = stiffness + shift * mass
        factor = factorize(shifted)
        if factor.inertia.negative:
            raise ModelError(
                "the stiffness is not positive semi-definite: "
                f"{factor.inertia.negative} eigenvalues are below {-shift:.3e} rad^2/s^2"
            )
        grounded = GroundedFactor(shifted, np.zeros((n, 0)), np.zeros(0, dtype=np.intp), factor)
        constrained = constrained_factor(shifted, D, grounded=grounded)
        block = start
        for _ in range(3):
            # Elastic parts may be 1e-9 of the rigid ones here: hence the small rank tolerance.
            images = constrained.solve(mass @ block)
            block = mass_orthonormalize(images, mass, rank_tolerance=1e-14).vectors
        estimate = float(np.linalg.eigvalsh(block.T @ (stiffness @ block))[-1])
        # Three steps reduce even a far too large shift by orders of magnitude, so this ends soon. A far too
        # small shift would lose the elastic modes beside the rigid ones, and digits of the factor.
        if 1e-5 * estimate <= shift <= estimate:
            return constrained, shift
        shift = 0.1 * estimate
        factor.release()  # one at a time: for a large body they take gigabytes


def _certified_modes(
    mass: sparse.csc_array,
    n_modes: int,
    inverse: ConstrainedFactor,
    shift: float,
    factorize: _Factorization,
) -> Eigenpairs:
    vectors = np.zeros((inverse.n, 0))
    values = np.zeros(0)
    missing, verdict = n_modes, "none was searched"
    for _ in range(ROUNDS):
        more = _lanczos(mass, inverse, Eigenpairs(values, vectors), missing + GUARD_MODES, shift)
        values, vectors, residuals = _ritz(mass, inverse, np.hstack([vectors, more]), shift)
        gap = _widest_gap(values + shift, n_modes)
        if gap is None:
            missing, verdict = max(GUARD_MODES, n_modes - values.size), "the modes found end inside a cluster"
            continue
        # Released before the factor for the count is computed; recomputed if modes are missing.
        inverse.grounded.factor.release()
        middle = 0.5 * (values[gap - 1] + values[gap])
        shifted = inverse.grounded.stiffness - (middle + shift) * mass
        count = _count_negative(factorize(shifted), inverse.constraint)
        if count == gap:
            worst = float(np.max(residuals[:n_modes]))
            if not worst < LARGEST_RESIDUAL:
                raise AccuracyError(
                    f"a mode violates its equation by {worst:.1e} (allowed {LARGEST_RESIDUAL:.0e})"
                )
            return Eigenpairs(values[:n_modes], vectors[:, :n_modes])
        missing, verdict = max(count - gap, 0), f"{gap} were found where the inertia counts {count}"
    raise AccuracyError(f"the {n_modes} lowest modes could not be certified in {ROUNDS} rounds: {verdict}")


def _lanczos(
    mass: sparse.csc_array, inverse: ConstrainedFactor, known: Eigenpairs, count: int, shift: float
) -> FloatArray:
    """The next modes, M-orthogonal to the known ones, whose eigenvalues are shifted to infinity."""

    def solve(load: FloatArray) -> FloatArray:
        load = load.reshape(inverse.n, -1)
        return inverse.solve(load) - known.vectors @ (
            (known.vectors.T @ load) / (known.values + shift)[:, None]
        )

    operator = LinearOperator((inverse.n, inverse.n), matvec=solve, matmat=solve, dtype=np.float64)  # ty: ignore[missing-argument, parameter-already-assigned, unknown-argument]
    start = solve(mass @ np.random.default_rng(known.values.size).standard_normal(inverse.n))[:, 0]
    try:
        _, vectors = eigsh(
            inverse.grounded.stiffness,
            k=count,
            M=mass,
            sigma=-shift,
            OPinv=operator,
            v0=start,
            ncv=max(2 * count + 1, 20),
        )
    except ArpackNoConvergence as error:
        vectors = error.eigenvectors
    return vectors


def _ritz(
    mass: sparse.csc_array, inverse: ConstrainedFactor, vectors: FloatArray, shift: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Best eigenvalues, M-orthonormal vectors and relative residuals in a subspace, by the inverse."""
    loads = mass @ vectors
    images = inverse.solve(loads)
    projected = loads.T @ images
    mu, weights = linalg.eigh(0.5 * (projected + projected.T), vectors.T @ loads)
    mu, weights = mu[::-1], weights[:, ::-1]
    vectors = vectors @ weights
    error = images @ weights - vectors * mu
    residuals = np.sqrt(np.maximum(np.sum(error * (mass @ error), axis=0), 0)) / mu
    return 1 / mu - shift, vectors, residuals


def _widest_gap(values: FloatArray, n_modes: int) -> int | None:
    """Number of modes below the widest relative gap with at least n_modes below it."""
    if values.size <= n_modes:
        return None
    widths = np.diff(values[n_modes - 1 :]) / values[n_modes:]
    widest = int(np.argmax(widths))
    return n_modes + widest if widths[widest] > 1e-6 else None


def _count_negative(factor: SparseFactor, D: FloatArray) -> int:
    """Number of negative eigenvalues of a factored symmetric matrix on {x : D x = 0}."""
    flexibility = D @ factor.solve(D.T)
    signs = np.linalg.eigvalsh(0.5 * (flexibility + flexibility.T))
    return factor.inertia.negative + int(np.sum(signs > 0)) - D.shape[0]


def _fixed_sign(vectors: FloatArray) -> FloatArray:
    largest = np.take_along_axis(vectors, np.argmax(np.abs(vectors), axis=0)[None, :], axis=0)
    return vectors * np.where(largest < 0, -1.0, 1.0)
