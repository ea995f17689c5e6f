"""Elasticity along a run, seen by the columns of its error: exact forces, tangents from a few instants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody
from supple.error.equation.products_of_run import (
    few_instants,
    monomials,
    pair_products,
    rate_monomials,
    weights_of_instants,
)
from supple.fem import StrainWorks

__all__ = [
    "PROVEN",
    "ForcePolynomial",
    "StrainRateHistory",
    "StrainRatePolynomial",
    "TangentHistory",
    "force_polynomial",
    "strain_rate_history",
    "strain_rate_polynomial",
    "tangent_history",
    "unit_stiffness",
]

Array = NDArray[np.float64]

SMALLEST_MONOMIAL = 1e-6
"""Of the largest change of the monomials along the run: what instants need not show. Of strips that bend far,
ten times as much changes estimates by 0.2 %; with a thousand times as much, what is missed of a membrane's
stiffness locks their bending."""
SMALLEST_RATE = 3e-3
"""The same of what strain rates add: of damping, which is a few hundredths of stiffness; ten times as much
changes estimates by less than 0.1 %."""
MOST_SAMPLES = 120
AT_ONCE = 4
"""Instants whose matrices show whether those before already give them."""
PROVEN = 3e-4
"""Of the stiffness at rest, in any direction: what matrices from the instants before may miss of the next;
the error of a run changes by as much in its energy."""
FACTOR_ROWS = 256


@dataclass(frozen=True, eq=False)
class ForcePolynomial:
    """`Z^T (f(X g) - K X g)`: what the internal force of a motion in columns X gains, seen by columns Z.

        gained = quadratic m2 + sum_i g_i cubic_i m2,   m2 = (g_j g_k), j <= k

    quadratic : (k, n2)
    cubic : (s, k, n2)
    """

    quadratic: Array
    cubic: Array

    def __call__(self, coordinates: Array) -> Array:
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
    """The exact polynomial of a body's nonlinear force, from the works of its elements' strains.

    works : of the columns X of the motion on Z (`Assembly.works`)
    """
    first, second, once = _pairs(works)
    turned = works.turned[:, first, second] + works.turned[:, second, first]
    return ForcePolynomial((works.linear + turned) * once, works.cubic * once)


@dataclass(frozen=True, eq=False)
class StrainRatePolynomial:
    """`Z^T (K_mat(X g) - K) X g_dot`: what the stress of strain rates adds to that at rest, seen by Z.

        gained = sum_jk g_j g_dot_k bilinear_jk + 2 sum_i g_i cubic_i m,   m = g (x) g_dot

    Weights of instants would not do for a force: what they miss of a stiff shell is more than the residual
    of a good run.

    bilinear : (k, s^2)
    cubic : (s, k, n2)      those of the elastic force
    """

    bilinear: Array
    cubic: Array

    def __call__(self, coordinates: Array, rates: Array) -> Array:
        """Forces (t, k) by unit of retardation time at coordinates g and rates (t, s)."""
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
    """The exact polynomial; works as for `force_polynomial`."""
    first, second, once = _pairs(works)
    bilinear = works.turned.copy()
    bilinear[:, first, second] += works.linear * once
    bilinear[:, second, first] += works.linear * once
    return StrainRatePolynomial(bilinear.reshape(len(bilinear), -1), works.cubic * once)


def _pairs(works: StrainWorks) -> tuple[Any, Any, Array]:
    """First and second of the pairs, and what each counts: twice, or once of equals."""
    first, second = np.triu_indices(works.turned.shape[2])
    return first, second, np.where(first == second, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class TangentHistory:
    """What tangents `Z^T K_t(q(t)) Z` gain along a run: few matrices, and their weights at every step.

        gained(t) = sum_i weights(t)_i samples_i

    K_t is quadratic in q, so that weights which reproduce the coordinates and their products reproduce it.

    whole : (m, k, k)
    material : (m, k, k)    through the strains alone; (0, k, k) where that was not asked for
    weights : (t, m)
    """

    whole: Array
    material: Array
    weights: Array


def tangent_history(
    body: FlexibleBody,
    motion: Array,
    coordinates: Array,
    onto: Array,
    *,
    material: bool = False,
    proven: float = PROVEN,
) -> TangentHistory:
    """Tangents along q = X g(t) from those at a few instants, chosen so that all others follow from them.

    The monomials (g, g g) of the run are factored with column pivoting, which picks the instants, those that
    differ most from all before first. Where the next ones follow from those before, the others do.

    motion : (n, s) X;  coordinates : (t, s);  onto : (n, k) Z
    material : bool     whether the part through the strains is wanted as well, as damping by their rate does
    proven : float      of the stiffness at rest, in any direction: what may be missed of the next tangents
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
    through_strains: list[Array] = []

    def gained(instant: int) -> Array:
        q = motion @ coordinates[instant]
        if not material:
            return _projected(body.assembly.tangent(q), onto) - at_rest
        of_strains, of_stress = (_projected(part, onto) for part in body.assembly.tangent_parts(q))
        through_strains.append(of_strains - at_rest)
        return of_strains + of_stress - at_rest

    whole = _samples(gained, products, chosen, at_rest, proven)
    weights = weights_of_instants(products, chosen[: len(whole)], products)
    return TangentHistory(whole, np.reshape(through_strains, (-1, k, k)), weights)


def _samples(
    matrix_at: Callable[[int], Array],
    products: Array,
    chosen: NDArray[np.intp],
    at_rest: Array,
    proven: float,
) -> Array:
    """Matrices (m, k, k) at the first of the chosen instants, until those give the next ones.

    at_rest : (k, k)    stiffness, of which so much may be missed
    """
    scaled = unit_stiffness(at_rest)
    samples = np.zeros((0, *at_rest.shape))
    for start in range(0, len(chosen), AT_ONCE):
        instants = chosen[start : start + AT_ONCE]
        more = np.array([matrix_at(int(instant)) for instant in instants])
        predicted = weights_of_instants(products, chosen[:start], products[instants])
        missed = scaled.T @ (more - np.tensordot(predicted, samples, axes=1)) @ scaled
        samples = np.concatenate([samples, more])
        if np.linalg.norm(missed, ord=2, axis=(1, 2)).max() <= proven:
            break
    return samples


def unit_stiffness(stiffness: Array) -> Array:
    """Columns (k, k) to which a stiffness is the unit matrix; zero where it has none."""
    values, vectors = np.linalg.eigh((stiffness + stiffness.T) / 2)
    stiff = values > np.finfo(float).eps * len(values) * values[-1]
    return vectors * np.where(stiff, 1 / np.sqrt(np.where(stiff, values, 1.0)), 0.0)


@dataclass(frozen=True, eq=False)
class StrainRateHistory:
    """What the stress of strain rates adds to the tangent along a run, by unit of retardation time.

        Z^T { A^T D N(q_dot) + N(D eps_dot) } Z = sum_i weights(t)_i samples_i

    It is linear in the rates, and has no symmetry: a motion that keeps its strains as the body moves on,
    A dq_dot + N(q_dot) dq = 0, meets no resistance, which no symmetric half of it shows.

    samples : (m, k, k)
    weights : (t, m)
    """

    samples: Array
    weights: Array


def strain_rate_history(
    body: FlexibleBody,
    motion: Array,
    coordinates: Array,
    rates: Array,
    onto: Array,
    time: float,
    *,
    proven: float = PROVEN,
) -> StrainRateHistory:
    """The same at few instants, chosen by the monomials (g_dot, g g_dot) as those of the tangents are.

    motion : (n, s) X;  coordinates, rates : (t, s);  onto : (n, k) Z
    time : float    of retardation
    proven : as for `tangent_history`
    """
    k, t = onto.shape[1], len(coordinates)
    scale = _unit_energies(body, motion, coordinates)
    if scale is None or not time or not np.any(rates):
        return StrainRateHistory(np.zeros((0, k, k)), np.zeros((t, 0)))
    products = rate_monomials(coordinates * scale, rates * scale)
    chosen = few_instants(products, SMALLEST_RATE, MOST_SAMPLES)

    def added(instant: int) -> Array:
        q, moving = motion @ coordinates[instant], motion @ rates[instant]
        return _projected(body.assembly.strain_rate_tangent(q, moving), onto)

    samples = _samples(added, products, chosen, _projected(body.stiffness, onto), proven / time)
    return StrainRateHistory(samples, weights_of_instants(products, chosen[: len(samples)], products))


def _projected(matrix: Any, onto: Array) -> Array:
    return onto.T @ (matrix @ onto)


def _unit_energies(body: FlexibleBody, motion: Array, coordinates: Array) -> Array | None:
    """Factors (s,) that weigh coordinates by strain energy, 1 at most; None where nothing moves."""
    scale = np.sqrt(np.sum(motion * (body.stiffness @ motion), axis=0))
    largest = float(np.max(np.abs(coordinates * scale), initial=0.0))
    return scale / largest if largest else None
