"""Elastic forces and tangents along a run, projected on columns: exact forces, interpolated tangents."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from supple.arrays import FloatArray, IntArray
from supple.body import FlexibleBody
from supple.error.equation.products_of_run import (
    few_instants,
    monomials,
    pair_products,
    rate_monomials,
    weights_of_instants,
)
from supple.fem import StrainWorks
from supple.other_processes import in_threads

SMALLEST_MONOMIAL = 1e-6
"""Pivot of the monomials, relative to the largest pivot, below which no sample time is added. For strips with
large bending, a limit ten times as large changes error estimates by 0.2 %. A limit a thousand times as large
neglects changes of the membrane stiffness, and bending locks."""
SMALLEST_RATE = 3e-3
"""`SMALLEST_MONOMIAL` for tangents of the strain-rate stress, which are a few per cent of the stiffness. A
limit ten times as large changes error estimates by less than 0.1 %."""
MOST_SAMPLES = 120
"""Largest number of sample times of a run."""
AT_ONCE = 4
"""Number of sample times added before each test whether the previous matrices are sufficient."""
FEWEST_IN_THREADS, MOST_IN_THREADS = 2_000, 200_000
"""Several threads assemble the tangents of a body if its number of coordinates lies between these values. For
fewer coordinates threads save no time. For more, simultaneous assemblies take too much memory (gigabytes for
each at a million coordinates)."""
PROVEN = 3e-4
"""Allowed error of tangents predicted from earlier samples, relative to the stiffness at rest, in any
direction. It changes the energy of the estimated error of a run by the same ratio."""
PROVEN_DAMPING = 1e-2
"""`PROVEN` for the material part of the tangent, which only damping needs."""
FACTOR_ROWS = 256
"""Number of times whose products of coordinates are in memory at once."""


@dataclass(frozen=True, eq=False)
class ForcePolynomial:
    """`Z^T (f(X g) - K X g)`: nonlinear part of the internal force of a motion in columns X, projected on Z.

        gained = quadratic m2 + sum_i g_i cubic_i m2,   m2 = (g_j g_k), j <= k

    quadratic : (k, n2)     n2 = s (s + 1) / 2
    cubic : (s, k, n2)
    """

    quadratic: FloatArray
    cubic: FloatArray

    def __call__(self, coordinates: FloatArray) -> FloatArray:
        """Forces (t, k) at coordinates g (t, s)."""
        first, second = np.triu_indices(coordinates.shape[1])
        gained = np.empty((len(coordinates), len(self.quadratic)))
        for start in range(0, len(coordinates), FACTOR_ROWS):
            rows = slice(start, start + FACTOR_ROWS)
            g = coordinates[rows]
            products = g[:, first] * g[:, second]
            gained[rows] = products @ self.quadratic.T
            for i, cubic in enumerate(self.cubic):
                gained[rows] += (g[:, i, None] * products) @ cubic.T
        return gained


def force_polynomial(works: StrainWorks) -> ForcePolynomial:
    """The exact polynomial of a body's nonlinear force, from `StrainWorks`.

    works : strain works of the columns X of the motion on Z (`Assembly.works`)
    """
    first, second, once = _pairs(works)
    turned = works.turned[:, first, second] + works.turned[:, second, first]
    return ForcePolynomial((works.linear + turned) * once, works.cubic * once)


@dataclass(frozen=True, eq=False)
class StrainRatePolynomial:
    """`Z^T (K_mat(X g) - K) X g_dot`: strain-rate force minus that of the undeformed body, projected on Z.

        gained = sum_jl g_j g_dot_l bilinear_jl + 2 sum_i g_i cubic_i m
        m = ((g_j g_dot_l + g_l g_dot_j) / 2), j <= l

    Interpolation between sample times is not accurate enough for a force: its error for a stiff shell would
    exceed the residual of an accurate run.

    bilinear : (k, s^2)
    cubic : (s, k, n2)      as in `ForcePolynomial`
    """

    bilinear: FloatArray
    cubic: FloatArray

    def __call__(self, coordinates: FloatArray, rates: FloatArray) -> FloatArray:
        """Forces (t, k) per unit of retardation time at coordinates g and rates (t, s)."""
        gained = np.empty((len(coordinates), len(self.bilinear)))
        for start in range(0, len(coordinates), FACTOR_ROWS):
            rows = slice(start, start + FACTOR_ROWS)
            g, rate = coordinates[rows], rates[rows]
            gained[rows] = (g[:, :, None] * rate[:, None]).reshape(len(g), -1) @ self.bilinear.T
            products = 2 * pair_products(g, rate)
            for i, cubic in enumerate(self.cubic):
                gained[rows] += (g[:, i, None] * products) @ cubic.T
        return gained


def strain_rate_polynomial(works: StrainWorks) -> StrainRatePolynomial:
    """The exact polynomial of the strain-rate force; works as for `force_polynomial`."""
    first, second, once = _pairs(works)
    bilinear = works.turned.copy()
    bilinear[:, first, second] += works.linear * once
    bilinear[:, second, first] += works.linear * once
    return StrainRatePolynomial(bilinear.reshape(len(bilinear), -1), works.cubic * once)


def _pairs(works: StrainWorks) -> tuple[IntArray, IntArray, FloatArray]:
    """First and second index of the pairs j <= k, and their weights: 1, or 1/2 for j = k."""
    first, second = np.triu_indices(works.turned.shape[2])
    return first, second, np.where(first == second, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class TangentHistory:
    """Change of the tangent `Z^T K_t(q(t)) Z` from rest along a run: samples, and their weights at each time.

        gained(t) = sum_i weights(t)_i samples_i

    K_t is quadratic in q: weights that reproduce the coordinates and their products reproduce K_t. Samples
    are `whole`, or `material` for the material part.

    whole : (m, k, k)       changes of the tangent from rest, at m sample times
    material : (m, k, k)    changes of its material part; (0, k, k) if not requested
    weights : (t, m)
    """

    whole: FloatArray
    material: FloatArray
    weights: FloatArray


def tangent_history(
    body: FlexibleBody,
    motion: FloatArray,
    coordinates: FloatArray,
    onto: FloatArray,
    *,
    material: bool = False,
    proven: float = PROVEN,
) -> TangentHistory:
    """Tangents along q = X g(t), combined from the tangents at a few sample times.

    The monomials (g, g g) of the run are factored by QR with column pivoting. The pivots are the sample
    times: at each, the monomials differ most from those at the previous ones. Selection stops when the
    previous samples reproduce the next `AT_ONCE` tangents.

    motion : (n, s) X;  coordinates : (t, s);  onto : (n, k) Z
    material : bool     whether the material part is needed as well, by strain-rate damping; its allowed error
                        is the larger of `proven` and `PROVEN_DAMPING`
    proven : float      allowed error of predicted tangents, relative to the stiffness at rest
    """
    k = onto.shape[1]
    scale = _unit_energies(body, motion, coordinates)
    if scale is None:
        none = np.zeros((0, k, k))
        return TangentHistory(none, none, np.zeros((len(coordinates), 0)))
    g = coordinates * scale
    products = monomials(g)
    chosen = few_instants(products, SMALLEST_MONOMIAL, MOST_SAMPLES)
    at_rest = _projected(body.stiffness, onto)
    whole_at: dict[int, FloatArray] = {}

    def of_strains(instant: int) -> FloatArray:
        """Change of the material part; the change of the whole tangent is stored in `whole_at`."""
        through_strains, of_stress = (
            _projected(part, onto) for part in body.assembly.tangent_parts(motion @ coordinates[instant])
        )
        whole_at[instant] = through_strains + of_stress - at_rest
        return through_strains - at_rest

    def gained(instant: int) -> FloatArray:
        if instant in whole_at:
            return whole_at[instant]
        return _projected(body.assembly.tangent(motion @ coordinates[instant]), onto) - at_rest

    strains = np.zeros((0, k, k))
    if material:
        strains = _samples(of_strains, body.n, products, chosen, at_rest, max(proven, PROVEN_DAMPING))
    whole = _samples(gained, body.n, products, chosen, at_rest, proven)
    sampled = chosen[: len(whole)]
    if material:
        combined = weights_of_instants(products, chosen[: len(strains)], products[sampled])
        strains = np.tensordot(combined, strains, axes=1)
    return TangentHistory(whole, strains, weights_of_instants(products, sampled, products))


def _samples(
    matrix_at: Callable[[int], FloatArray],
    n: int,
    products: FloatArray,
    chosen: NDArray[np.intp],
    at_rest: FloatArray,
    proven: float,
) -> FloatArray:
    """Matrices (m, k, k) at the first m sample times; m grows until earlier matrices reproduce the new ones.

    n : number of coordinates of the body
    at_rest : (k, k)    stiffness, reference of the allowed error
    """
    compute = in_threads if FEWEST_IN_THREADS <= n <= MOST_IN_THREADS else map
    scaled = unit_stiffness(at_rest)
    samples = np.zeros((0, *at_rest.shape))
    for start in range(0, len(chosen), AT_ONCE):
        instants = chosen[start : start + AT_ONCE]
        more = np.array(list(compute(matrix_at, instants.tolist())))
        predicted = weights_of_instants(products, chosen[:start], products[instants])
        missed = scaled.T @ (more - np.tensordot(predicted, samples, axes=1)) @ scaled
        samples = np.concatenate([samples, more])
        if np.linalg.norm(missed, ord=2, axis=(1, 2)).max() <= proven:
            break
    return samples


def unit_stiffness(stiffness: FloatArray) -> FloatArray:
    """Columns C (k, k) with C^T K C = I for a stiffness K; columns of its null space are zero."""
    values, vectors = np.linalg.eigh((stiffness + stiffness.T) / 2)
    stiff = values > np.finfo(float).eps * len(values) * values[-1]
    return vectors * np.where(stiff, 1 / np.sqrt(np.where(stiff, values, 1.0)), 0.0)


@dataclass(frozen=True, eq=False)
class StrainRateHistory:
    """Additional tangent of the strain-rate stress along a run, per unit of retardation time.

        Z^T { A^T D N(q_dot) + N(D eps_dot) } Z = sum_i weights(t)_i samples_i

    The tangent is linear in the rates and not symmetric. A small change dq of the motion that does not change
    the strain rates, A dq_dot + N(q_dot) dq = 0, does not change the strain-rate stress. The symmetric part
    of the tangent alone would resist it.

    samples : (m, k, k)
    weights : (t, m)
    """

    samples: FloatArray
    weights: FloatArray


def strain_rate_history(
    body: FlexibleBody,
    motion: FloatArray,
    coordinates: FloatArray,
    rates: FloatArray,
    onto: FloatArray,
    time: float,
    *,
    proven: float = PROVEN,
) -> StrainRateHistory:
    """Strain-rate tangents along a run from a few sample times, selected by the monomials (g_dot, g g_dot).

    motion : (n, s) X;  coordinates, rates : (t, s);  onto : (n, k) Z
    time : float    retardation time
    proven : as for `tangent_history`, of the tangents times `time`
    """
    k, t = onto.shape[1], len(coordinates)
    scale = _unit_energies(body, motion, coordinates)
    if scale is None or not time or not np.any(rates):
        return StrainRateHistory(np.zeros((0, k, k)), np.zeros((t, 0)))
    products = rate_monomials(coordinates * scale, rates * scale)
    chosen = few_instants(products, SMALLEST_RATE, MOST_SAMPLES)

    def added(instant: int) -> FloatArray:
        q, moving = motion @ coordinates[instant], motion @ rates[instant]
        return _projected(body.assembly.strain_rate_tangent(q, moving), onto)

    at_rest = _projected(body.stiffness, onto)
    samples = _samples(added, body.n, products, chosen, at_rest, proven / time)
    return StrainRateHistory(samples, weights_of_instants(products, chosen[: len(samples)], products))


def _projected(matrix: csc_array | csr_array, onto: FloatArray) -> FloatArray:
    return onto.T @ (matrix @ onto)


def _unit_energies(body: FlexibleBody, motion: FloatArray, coordinates: FloatArray) -> FloatArray | None:
    """Factors (s,) that scale each coordinate to an energy norm of at most 1; None if all are zero."""
    # The energy of a motion without strain is round-off, of either sign.
    scale = np.sqrt(np.maximum(np.sum(motion * (body.stiffness @ motion), axis=0), 0.0))
    largest = float(np.max(np.abs(coordinates * scale), initial=0.0))
    return scale / largest if largest else None
