"""Static equilibrium under linear constraints, with one sparse factor even when the body is free."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse

from supple.algebra.sparse_factor import DirectSolver, Matrix, SparseFactor, factorize_symmetric
from supple.arrays import FloatArray
from supple.errors import AccuracyError, ModelError

__all__ = ["ConstrainedFactor", "GroundedFactor", "constrained_factor", "grounded_factor"]

LARGEST_RESIDUAL = 1e-8
"""Allowed relative residual of equilibrium and constraint in the check of a factor."""
SMALLEST_RECIPROCAL_CONDITION = 1e-14
"""Ratio of smallest to largest singular value of the border below which it counts as singular."""

# Most entries, and fewest columns, of the solutions computed at once: several copies of all columns of a
# large body would take gigabytes.
NUMBERS_AT_ONCE = 2**22
FEWEST_AT_ONCE = 16


@dataclass(frozen=True, eq=False)
class GroundedFactor:
    """A free body's stiffness K, supported by springs at as many freedoms as it has rigid motions.

    K_g = K + E k E^T is positive definite and sparse. For a self-equilibrated load (R^T b = 0) the springs
    have no force. So x = K_g^-1 b, and x + R a for every a, solve K x = b exactly.
    """

    stiffness: sparse.csc_array = field(repr=False)
    rigid_modes: FloatArray = field(repr=False)
    springs: NDArray[np.intp]
    factor: SparseFactor

    @property
    def n(self) -> int:
        """Number of freedoms."""
        return self.factor.n

    @property
    def spring_stiffness(self) -> FloatArray:
        """K of the springs."""
        return _sizes(self.stiffness, self.rigid_modes)[self.springs]


def grounded_factor(
    stiffness: Matrix, rigid_modes: ArrayLike | None, *, solver: DirectSolver | None = None
) -> GroundedFactor:
    """Factor a stiffness grounded at statically determinate freedoms.

    The freedoms are the pivots of a rank-revealing QR of the rigid modes, scaled by diag(K), so that forces
    and moments have equal weight; each spring is as stiff as its freedom. Freedoms without stiffness, as of
    the only grid of a condensed model, have the mean stiffness of the others.

    Parameters
    ----------
    stiffness   : sparse array (n, n)   symmetric; K R = 0
    rigid_modes : array (n, d) or None  R, all motions without strain; None when K is regular
    Raises
    ------
    ModelError      wrong shapes, linearly dependent rigid modes
    AccuracyError   K has more motions without force than R
    """
    stiffness = sparse.csc_array(stiffness, dtype=np.float64)
    if not stiffness.has_sorted_indices:
        stiffness = stiffness.sorted_indices()
    n = stiffness.indptr.size - 1
    modes = np.zeros((n, 0)) if rigid_modes is None else np.array(rigid_modes, dtype=np.float64)
    if modes.ndim != 2 or modes.shape[0] != n:
        raise ModelError(f"rigid modes have shape {modes.shape}; the stiffness has {n} rows")
    modes.flags.writeable = False

    sizes = _sizes(stiffness, modes)
    springs = _determinate_freedoms(modes * np.sqrt(np.maximum(sizes, 0))[:, None])
    spring_stiffness = np.zeros(n)
    spring_stiffness[springs] = sizes[springs]
    grounded = stiffness + sparse.diags_array(spring_stiffness, format="csc")
    return GroundedFactor(stiffness, modes, springs, factorize_symmetric(grounded, solver=solver))


def _sizes(stiffness: sparse.csc_array, modes: FloatArray) -> FloatArray:
    """Stiffness (n,) of each freedom; the mean of the others where only freedoms without stiffness move."""
    diagonal = stiffness.diagonal()
    stiff = diagonal > 0
    if modes[stiff].any() or not stiff.any():
        return diagonal
    return np.where(stiff, diagonal, np.mean(diagonal[stiff]))


def _determinate_freedoms(modes: FloatArray) -> NDArray[np.intp]:
    count = modes.shape[1]
    if count == 0:
        return np.zeros(0, dtype=np.intp)
    lengths = np.linalg.norm(modes, axis=0)
    orthonormal, triangle = np.linalg.qr(modes / np.where(lengths > 0, lengths, 1.0))
    if np.min(np.abs(np.diag(triangle))) < 1e-10:
        raise ModelError(
            f"the {count} rigid modes are linearly dependent, or move only freedoms without stiffness"
        )
    pivots = linalg.qr(orthonormal.T, mode="r", pivoting=True)[-1]
    return np.sort(np.asarray(pivots[:count], dtype=np.intp))


@dataclass(frozen=True, eq=False)
class ConstrainedFactor:
    """Solves K x + D^T mu = b with D x = c; see `constrained_factor`."""

    grounded: GroundedFactor
    constraint: FloatArray = field(repr=False)
    _response: FloatArray = field(repr=False)  # K_g^-1 D^T
    _border: tuple[FloatArray, NDArray[np.intp]] = field(repr=False)
    _scale: FloatArray = field(repr=False)

    @property
    def n(self) -> int:
        """Number of freedoms."""
        return self.grounded.n

    def solve(self, loads: ArrayLike | None = None, values: ArrayLike | None = None) -> FloatArray:
        """Displacement x (n,) or (n, k) under loads b of that shape and values c (m,) or (m, k)."""
        return self.solve_with_multipliers(loads, values)[0]

    def solve_with_multipliers(
        self, loads: ArrayLike | None = None, values: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Displacement x and multipliers mu, the forces of the constraint: K x = b - D^T mu."""
        n, m = self.n, self.constraint.shape[0]
        flat = all(given is None or np.ndim(given) == 1 for given in (loads, values))
        b = None if loads is None else _columns(loads, n, "loads")
        c = None if values is None else _columns(values, m, "constraint values")
        if b is None:
            b = np.zeros((n, 1 if c is None else c.shape[1]))
        if c is None:
            c = np.zeros((m, b.shape[1]))
        if b.shape[1] != c.shape[1]:
            raise ModelError(f"{b.shape[1]} load columns but {c.shape[1]} columns of constraint values")
        x, mu = np.empty(b.shape), np.empty(c.shape)
        size = max(FEWEST_AT_ONCE, NUMBERS_AT_ONCE // n)
        for first in range(0, b.shape[1], size):
            part = slice(first, first + size)
            x[:, part], mu[:, part] = self._solve(b[:, part], c[:, part])
        return (x[:, 0], mu[:, 0]) if flat else (x, mu)

    def _solve(self, b: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
        D, R = self.constraint, self.grounded.rigid_modes
        x = self.grounded.factor.solve(b) if np.any(b) else np.zeros(b.shape)
        mu = np.zeros(c.shape)
        if self._scale.size == 0:
            return x, mu
        # The second pass removes the drift due to round-off where K is nearly singular and x a small
        # difference of large parts.
        for relative_residual in (R.T @ b, np.zeros((R.shape[1], b.shape[1]))):
            right = self._scale[:, None] * np.vstack([D @ x - c, relative_residual])
            forces, rigid = np.split(self._scale[:, None] * linalg.lu_solve(self._border, right), [len(D)])
            x -= self._response @ forces
            x -= R @ rigid
            mu += forces
        return x, mu


def constrained_factor(
    stiffness: Matrix,
    constraint: Any,
    rigid_modes: ArrayLike | None = None,
    *,
    grounded: GroundedFactor | None = None,
    solver: DirectSolver | None = None,
) -> ConstrainedFactor:
    """Factor the equilibrium of a body, free or clamped, under m linear constraints.

        [ K  D^T ] [ x  ]   [ b ]
        [ D   0  ] [ mu ] = [ c ]

    K may be singular with null space R (free body). With the grounded factor K_g of `grounded_factor`,

        x = K_g^-1 (b - D^T mu) - R a,     R^T (b - D^T mu) = 0,     D x = c

    leaves a dense symmetric system of m + d unknowns (mu, a): the springs carry no force, so they are removed
    exactly. D = R^T M gives inertia relief (mean-axis frame); an interface is clamped by its motion as D.

    Parameters
    ----------
    stiffness   : sparse array (n, n)             symmetric, N/m
    constraint  : array (m, n), dense or sparse   D, of full row rank; K with D must be nonsingular
    rigid_modes : array (n, d) or None            null space R of K; None when K is regular
    grounded    : GroundedFactor                  factor to share; it then supplies stiffness and rigid modes
    Returns
    -------
    ConstrainedFactor   .solve(loads, values) -> x, .solve_with_multipliers(loads, values) -> (x, mu)
    Raises
    ------
    ModelError      wrong shapes; redundant rows of D; D leaves a rigid motion free
    AccuracyError   K singular beyond R; the solved system violates equilibrium
    """
    if grounded is None:
        grounded = grounded_factor(stiffness, rigid_modes, solver=solver)
    n, R = grounded.n, grounded.rigid_modes
    D = dense_rows(constraint, n)
    m, d = len(D), R.shape[1]
    if m < d:
        raise ModelError(
            f"{m} constraint rows cannot fix {d} rigid motions; give a frame or fixed interfaces"
        )

    response = grounded.factor.solve(D.T)
    compliance = D @ response
    compliance = 0.5 * (compliance + compliance.T)
    fixed = D @ R
    border = np.block([[compliance, fixed], [fixed.T, np.zeros((d, d))]])
    border_factor, scale = _border_factor(border, m)
    factor = ConstrainedFactor(grounded, D, response, border_factor, scale)
    _check_equilibrium(factor)
    return factor


def dense_rows(constraint: Any, n: int) -> FloatArray:
    """D as a dense, read-only (m, n) array; (0, n) without a constraint.

    Raises ModelError for a wrong shape, or numbers that are not finite.
    """
    if constraint is None:
        constraint = np.zeros((0, n))
    elif sparse.issparse(constraint):
        constraint = constraint.toarray()
    rows = np.array(constraint, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != n:
        raise ModelError(f"the constraint has shape {rows.shape}; give (m, n) with n = {n}")
    if not np.all(np.isfinite(rows)):
        raise ModelError("the constraint has NaN or infinite entries")
    rows.flags.writeable = False
    return rows


def _border_factor(border: FloatArray, m: int) -> tuple[tuple[FloatArray, NDArray[np.intp]], FloatArray]:
    """Scale the border, as its multipliers have the units of forces and moments, and factor it.

    Returns the factor and the scales (m + d,). Raises ModelError for a singular border.
    """
    if border.shape[0] == 0:
        return (border, np.zeros(0, dtype=np.intp)), np.zeros(0)
    scale = np.ones(border.shape[0])
    diagonal = np.diag(border)[:m]
    if not np.all(diagonal > 0):
        raise ModelError(f"constraint row {int(np.argmin(diagonal))} is zero; remove it")
    scale[:m] = 1 / np.sqrt(diagonal)
    lengths = np.linalg.norm(scale[:m, None] * border[:m, m:], axis=0)
    if not np.all(lengths > 0):
        raise ModelError(f"the constraint leaves rigid motion {int(np.argmin(lengths))} free")
    scale[m:] = 1 / lengths
    scaled = scale[:, None] * border * scale
    singular = np.linalg.svd(scaled, compute_uv=False)
    if singular[-1] < SMALLEST_RECIPROCAL_CONDITION * singular[0]:
        raise ModelError(
            f"the {m} constraint rows are linearly dependent or leave a rigid motion free "
            f"(smallest singular value {singular[-1] / singular[0]:.1e} of the largest)"
        )
    return linalg.lu_factor(scaled), scale


def _check_equilibrium(factor: ConstrainedFactor) -> None:
    """Raise AccuracyError if the solution of a pseudo-random case violates equilibrium or the constraint.

    K x + D^T mu - b is compared with the largest of its terms, D x with a bound from the energy of x.
    """
    K, D = factor.grounded.stiffness, factor.constraint
    rng = np.random.default_rng(0)
    b = np.sqrt(np.abs(K.diagonal())) * rng.standard_normal(factor.n)
    x, mu = factor.solve_with_multipliers(b)
    internal, reaction = K @ x, D.T @ mu
    size = max(np.linalg.norm(abs(K) @ np.abs(x)), np.linalg.norm(reaction), np.linalg.norm(b))
    residual = np.linalg.norm(internal + reaction - b) / size if size else 0.0
    # |D_i x|^2 <= (D K_g^-1 D^T)_ii (x^T K_g x) bounds row i for a motion of this energy.
    energy = x @ internal + factor.grounded.spring_stiffness @ x[factor.grounded.springs] ** 2
    reach = np.sqrt(np.einsum("ij,ji->i", D, factor._response) * max(energy, 0.0))
    missed = float(np.max(np.abs(D @ x) / np.where(reach > 0, reach, 1.0), initial=0.0))
    if len(D) == factor.n:  # everything is held: x is rounding, and has no size to compare with
        missed = 0.0
    if not max(residual, missed) < LARGEST_RESIDUAL:
        raise AccuracyError(
            f"the constrained solution violates equilibrium by {residual:.1e} and its constraint by "
            f"{missed:.1e} (allowed {LARGEST_RESIDUAL:.0e}); check the rigid modes of this stiffness"
        )


def _columns(values: ArrayLike, rows: int, what: str) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim not in (1, 2) or array.shape[0] != rows:
        raise ModelError(f"{what} have shape {array.shape}; give ({rows},) or ({rows}, k)")
    return array if array.ndim == 2 else array[:, None]
