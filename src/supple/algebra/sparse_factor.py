"""Sparse direct factors: factor once, check once, solve many."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from threading import Event, Thread
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from supple.arrays import FloatArray
from supple.errors import AccuracyError, ModelError, SuppleWarning

__all__ = [
    "DirectSolver",
    "Inertia",
    "Rslab",
    "SparseFactor",
    "SuperLU",
    "factorize_general",
    "factorize_symmetric",
    "installed_solver",
]

# Sparse solvers share work between right-hand sides: in blocks of about 50 a column costs 4-5 times less than
# alone; much larger blocks only fill the cache.
BLOCK_COLUMNS = 64

# A refinement step changes the solution by about (round-off) x (condition number): 1e-8 for thin shells, of
# order one for a singular matrix, whose factors are only round-off along its null vectors.
LARGEST_REFINEMENT = 1e-3

# Above this size, SuperLU takes too long for three-dimensional meshes (10 minutes and more).
LARGEST_COMFORTABLE_SUPERLU = 50_000


Matrix = sparse.csr_array | sparse.csc_array | NDArray[Any]
"""A sparse or dense matrix"""


class Inertia(NamedTuple):
    """Numbers of negative, zero and positive eigenvalues of a symmetric matrix."""

    negative: int
    zero: int
    positive: int


class RawFactor(NamedTuple):
    """Functions of a library's factor: solve, count signs, refactor with new values."""

    solve: Callable[[FloatArray], FloatArray]
    inertia: Callable[[], Inertia]
    refactorize: Callable[[sparse.csc_array], RawFactor]


class DirectSolver(Protocol):
    """A library of sparse direct factorisations."""

    def symmetric(self, matrix: sparse.csc_array) -> RawFactor:
        """Factor a symmetric matrix, definite or not."""
        ...

    def general(self, matrix: sparse.csc_array) -> RawFactor:
        """Factor a matrix with a symmetric pattern but unsymmetric values."""
        ...


@dataclass(frozen=True)
class Rslab:
    """Supernodal Bunch-Kaufman factors of the rslab library (MIT licence; installed by supple[fast])."""

    def symmetric(self, matrix: sparse.csc_array) -> RawFactor:
        """Factor as P^T A P = L D L^T with 1x1 and 2x2 pivots."""
        return self._factor(_rslab().analyze(matrix, path="ldlt"), matrix)

    def general(self, matrix: sparse.csc_array) -> RawFactor:
        """Factor as P_r^T A P_c = L U; new values need a new analysis, as the permutations depend on them."""
        factor = _rslab().lu(matrix)
        return RawFactor(lambda b: _solve_with_rslab(factor, b), _inertia_of_unsymmetric, self.general)

    def _factor(self, analysis: Any, matrix: sparse.csc_array) -> RawFactor:
        factor = analysis.factor(matrix)
        positive, negative, zero = factor.inertia
        return RawFactor(
            lambda b: _solve_with_rslab(factor, b),
            lambda: Inertia(negative, zero, positive),
            lambda other: self._factor(analysis, other),
        )


@cache
def _rslab() -> Any:
    """The library, loaded by a thread that never ends.

    Its memory allocator (mimalloc 3.3) belongs to the thread that loads it. If that thread ends, as threads
    of a `ThreadPoolExecutor` do, a later thread crashes the process.
    """
    loaded = Event()

    def load() -> None:
        with suppress(ImportError):  # raised again below
            importlib.import_module("rslab")
        loaded.set()
        Event().wait()

    Thread(target=load, daemon=True).start()
    loaded.wait()
    return importlib.import_module("rslab")


def _solve_with_rslab(factor: Any, b: FloatArray) -> FloatArray:
    return factor.solve(b[:, 0])[:, None] if b.shape[1] == 1 else factor.solve_many(np.ascontiguousarray(b))


@dataclass(frozen=True)
class SuperLU:
    """SciPy's SuperLU in symmetric mode, five times faster than its defaults on symmetric patterns."""

    def symmetric(self, matrix: sparse.csc_array) -> RawFactor:
        """Factor with diagonal pivots; rows are exchanged, and the inertia lost, only if a pivot vanishes."""
        return self._factor(matrix, pivot_threshold=0.0)

    def general(self, matrix: sparse.csc_array) -> RawFactor:
        """Factor with diagonal pivots where possible: exchanging rows costs up to ten times the fill."""
        return self._factor(matrix, pivot_threshold=1e-3)._replace(
            inertia=_inertia_of_unsymmetric, refactorize=self.general
        )

    def _factor(self, matrix: sparse.csc_array, pivot_threshold: float) -> RawFactor:
        n = matrix.indptr.size - 1
        if n > LARGEST_COMFORTABLE_SUPERLU:
            warnings.warn(
                f"factoring {n} freedoms with SciPy's SuperLU: shells take seconds to minutes, solids hours "
                "and tens of gigabytes; install the fast solver with: pip install 'supple[fast]'",
                SuppleWarning,
                stacklevel=2,
            )
        factor = splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=pivot_threshold,
            options={"SymmetricMode": True, "Equil": False},
        )

        def inertia() -> Inertia:
            if not np.array_equal(factor.perm_r, factor.perm_c):
                raise AccuracyError(
                    "SuperLU exchanged rows to avoid a zero pivot, so the inertia cannot be read from its "
                    "factors; install the symmetric solver with: pip install 'supple[fast]'"
                )
            signs = np.sign(factor.U.diagonal())
            return Inertia(int(np.sum(signs < 0)), int(np.sum(signs == 0)), int(np.sum(signs > 0)))

        return RawFactor(factor.solve, inertia, self.symmetric)


def _inertia_of_unsymmetric() -> Inertia:
    raise ModelError("an unsymmetric matrix has no inertia; use factorize_symmetric for symmetric ones")


def installed_solver() -> DirectSolver:
    """The fastest available solver: rslab if installed, SciPy's SuperLU otherwise."""
    return Rslab() if importlib.util.find_spec("rslab") else SuperLU()


class SparseFactor:
    """The factors of a sparse matrix, checked by the `factorize_` functions and by `refactorize`.

    The numbers of the factors, gigabytes for a large body, can be released; the next solution computes them
    again.
    """

    def __init__(self, matrix: sparse.csc_array, raw: RawFactor) -> None:
        self._matrix = matrix
        self._raw: RawFactor | None = raw
        self._again = raw.refactorize
        self.n: int = matrix.indptr.size - 1

    def release(self) -> None:
        """Release the memory of the numbers; a symbolic analysis, if any, is kept."""
        self._raw = None

    def _numbers(self) -> RawFactor:
        if self._raw is None:
            self._raw = self._again(self._matrix)
        return self._raw

    def solve(self, loads: ArrayLike) -> FloatArray:
        """Solve A x = b for loads of shape (n,) or (n, k); the solution has the same shape."""
        b = np.asarray(loads, dtype=np.float64)
        if b.ndim not in (1, 2) or b.shape[0] != self.n:
            raise ModelError(
                f"loads have shape {b.shape}; the matrix has {self.n} rows, so give (n,) or (n, k)"
            )
        columns, raw = b if b.ndim == 2 else b[:, None], self._numbers()
        if columns.shape[1] <= BLOCK_COLUMNS and columns.size:
            return raw.solve(columns).reshape(b.shape)
        x = np.empty(columns.shape)
        for first in range(0, columns.shape[1], BLOCK_COLUMNS):
            block = slice(first, first + BLOCK_COLUMNS)
            x[:, block] = raw.solve(columns[:, block])
        return x.reshape(b.shape)

    @cached_property
    def inertia(self) -> Inertia:
        """Numbers of eigenvalues by sign, by Sylvester's law.

        Raises AccuracyError if the factors do not contain them, ModelError for an unsymmetric matrix.
        """
        return self._numbers().inertia()

    def refactorize(self, matrix: Matrix) -> SparseFactor:
        """Factor a matrix of the same pattern, reusing the symbolic analysis if the library allows it."""
        matrix = _square_csc(matrix)
        if matrix.shape != (self.n, self.n):
            raise ModelError(f"the new matrix has shape {matrix.shape}; the factored one has {self.n} rows")
        return _checked(lambda: self._again(matrix), matrix)


def factorize_symmetric(matrix: Matrix, *, solver: DirectSolver | None = None) -> SparseFactor:
    """Factor a symmetric sparse matrix, definite or indefinite, and check that it is not singular.

    Parameters
    ----------
    matrix : sparse or dense array (n, n)   symmetric; only finite numbers
    solver : DirectSolver                   Rslab() or SuperLU(); by default the fastest installed one
    Returns
    -------
    SparseFactor   .n, .solve(loads (n,) or (n, k)), .inertia, .refactorize(matrix of the same pattern)
    Raises
    ------
    ModelError      not square, or not finite
    AccuracyError   singular to working precision
    """
    matrix = _square_csc(matrix)
    return _checked(lambda: (solver or installed_solver()).symmetric(matrix), matrix)


def factorize_general(matrix: Matrix, *, solver: DirectSolver | None = None) -> SparseFactor:
    """Factor a sparse matrix of symmetric pattern and unsymmetric values.

    Arguments, result and errors are those of `factorize_symmetric`, except that `inertia` raises ModelError.
    """
    matrix = _square_csc(matrix)
    return _checked(lambda: (solver or installed_solver()).general(matrix), matrix)


def _square_csc(matrix: Matrix) -> sparse.csc_array:
    matrix = sparse.csc_array(matrix, dtype=np.float64)
    if matrix.shape[0] != matrix.shape[1] or matrix.shape[0] == 0:
        raise ModelError(f"a matrix of shape {matrix.shape} cannot be factored; it must be square, with rows")
    if not np.all(np.isfinite(matrix.data)):
        raise ModelError("the matrix has NaN or infinite entries and cannot be factorised")
    if not matrix.has_canonical_format:
        matrix = matrix.copy()
        matrix.sum_duplicates()
    return matrix


def _checked(factor: Callable[[], RawFactor], matrix: sparse.csc_array) -> SparseFactor:
    """The factor; AccuracyError if a refinement changes a random solution by more than LARGEST_REFINEMENT."""
    n = matrix.indptr.size - 1
    try:
        raw = factor()
    except RuntimeError as error:
        raise _singular(n, str(error)) from error

    # Scaled by the square root of the diagonal, so that metres and radians have equal weight.
    diagonal = np.abs(matrix.diagonal())
    scale = np.sqrt(np.where(diagonal > 0, diagonal, diagonal.max(initial=0.0) or 1.0))[:, None]
    load = scale * np.random.default_rng(0).standard_normal((n, 1))
    solution = raw.solve(load)
    correction = raw.solve(load - matrix @ solution)
    change = np.linalg.norm(scale * correction) / np.linalg.norm(scale * solution)
    if not change < LARGEST_REFINEMENT:  # NaN fails too
        raise _singular(n, f"one refinement step changes a solution by {change:.1e} of its size")
    return SparseFactor(matrix, raw)


def _singular(n: int, evidence: str) -> AccuracyError:
    return AccuracyError(
        f"the {n} x {n} matrix is singular to working precision ({evidence}); fix the body's rigid motion, "
        "shift the matrix, or find freedoms without stiffness"
    )
