"""Elasticity along a run, seen by the columns of its error: exact forces, tangents from a few instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.body import FlexibleBody
from supple.error_equation.products_of_run import few_instants, pair_products, weights_of_instants

__all__ = ["ForcePolynomial", "TangentHistory", "force_polynomial", "tangent_history"]

Array = NDArray[np.float64]

SMALLEST_MONOMIAL = 1e-6
"""Of the largest change of the monomials along the run: what instants need not tell."""
MOST_SAMPLES = 120
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


def force_polynomial(body: FlexibleBody, motion: Array, onto: Array) -> ForcePolynomial:
    """The exact polynomial of a body's nonlinear force, from the strains of its elements.

    motion : (n, s) columns X;  onto : (n, k) columns Z
    """
    first, second = np.triu_indices(motion.shape[1])
    once = np.where(first == second, 0.5, 1.0)
    assembly = body.assembly
    quadratic = onto.T @ assembly.pair_forces(motion)
    cubic = [onto.T @ assembly.triple_forces(motion, i) for i in range(motion.shape[1])]
    return ForcePolynomial(quadratic * once, np.array(cubic) * once)


@dataclass(frozen=True, eq=False)
class TangentHistory:
    """What tangents `Z^T K_t(q(t)) Z` gain along a run: few matrices, and their weights at every step.

        gained(t) = sum_i weights(t)_i samples_i

    K_t is quadratic in q, so that weights which reproduce the coordinates and their products reproduce it.

    material : (m, k, k)    of stiffness through the strains
    geometric : (m, k, k)   of stress
    weights : (t, m)
    weight_rates : (t, m)   by which the samples give the rate of change
    missed : float          part of the gain that was missed at an instant that was not chosen
    """

    material: Array
    geometric: Array
    weights: Array
    weight_rates: Array
    missed: float


def tangent_history(
    body: FlexibleBody, motion: Array, coordinates: Array, rates: Array, onto: Array
) -> TangentHistory:
    """Tangents along q = X g(t) from those at a few instants, chosen so that all others follow from them.

    The monomials (g, g g) of the run are factored with column pivoting, which picks the instants; then
    tangents at other instants are compared, and join in where they are missed.

    motion : (n, s) X;  coordinates, rates : (t, s);  onto : (n, k) Z
    """
    k = onto.shape[1]
    scale = np.sqrt(np.sum(motion * (body.stiffness @ motion), axis=0))
    largest = float(np.max(np.abs(coordinates * scale), initial=0.0))
    if not largest:
        none, without = np.zeros((0, k, k)), np.zeros((len(coordinates), 0))
        return TangentHistory(none, none, without, without, 0.0)
    g, rate = coordinates * (scale / largest), rates * (scale / largest)
    monomials = np.hstack([g, pair_products(g, g)])
    moving = np.hstack([rate, 2 * pair_products(g, rate)])
    chosen, others = few_instants(monomials, SMALLEST_MONOMIAL, MOST_SAMPLES)
    sampled = [_gains(body, motion @ coordinates[i], onto) for i in chosen]
    weights = weights_of_instants(monomials, chosen, monomials)
    missed = 0.0
    for other in others:
        exact = np.sum(_gains(body, motion @ coordinates[other], onto), axis=0)
        told = np.tensordot(weights[other], np.sum(sampled, axis=1), axes=1)
        missed = max(missed, float(linalg.norm(told - exact) / max(float(linalg.norm(exact)), 1e-300)))
    material, geometric = (np.array(each) for each in zip(*sampled, strict=True))
    rates_of_weights = weights_of_instants(monomials, chosen, moving)
    return TangentHistory(material, geometric, weights, rates_of_weights, missed)


def _gains(body: FlexibleBody, q: Array, onto: Array) -> tuple[Array, Array]:
    """What the material and the geometric part of the tangent gain at q, (k, k) each."""
    material, geometric = body.assembly.tangent_parts(q)
    return onto.T @ ((material - body.stiffness) @ onto), onto.T @ (geometric @ onto)
