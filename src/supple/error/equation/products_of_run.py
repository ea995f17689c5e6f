"""Quadratic functions of the coordinates of a run, interpolated from a few times by their monomials."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.arrays import FloatArray

CANDIDATES = 400
"""Number of candidate times."""


def few_instants(monomials: FloatArray, smallest: float, most: int) -> NDArray[np.intp]:
    """Indices of times whose monomials span those of a whole run, by factorisation with column pivoting.

    monomials : (t, m)
    smallest : float    pivot, relative to the largest, at which selection ends
    most : int          largest number of times
    """
    looked = np.unique(np.linspace(0, len(monomials) - 1, CANDIDATES).round().astype(int))
    R, order = linalg.qr(monomials[looked].T, mode="r", pivoting=True)
    sizes = np.abs(np.diag(R))
    number = min(int(np.sum(sizes > smallest * sizes[0])), most)
    return looked[order[:number]]


def weights_of_instants(monomials: FloatArray, chosen: NDArray[np.intp], wanted: FloatArray) -> FloatArray:
    """Least-squares weights (t, c) with which monomials at selected times give the `wanted` ones (t, m)."""
    solved = np.linalg.lstsq(monomials[chosen].T, wanted.T, rcond=1e-13)[0]
    return np.asarray(solved.T, dtype=np.float64)


def pair_products(a: FloatArray, b: FloatArray) -> FloatArray:
    """The symmetric products `(a_j b_k + b_j a_k) / 2`, j <= k, (t, n2)."""
    first, second = np.triu_indices(a.shape[1])
    return (a[:, first] * b[:, second] + b[:, first] * a[:, second]) / 2


def monomials(coordinates: FloatArray) -> FloatArray:
    """Monomials of a tangent, g_l, then g_j g_l with j <= l, for coordinates (t, s): (t, s + s (s+1) / 2)."""
    return np.hstack([coordinates, pair_products(coordinates, coordinates)])


def rate_monomials(coordinates: FloatArray, rates: FloatArray) -> FloatArray:
    """Further monomials for strain rates, g'_k, then g_j g'_k: (t, s + s^2)."""
    products = (coordinates[:, :, None] * rates[:, None]).reshape(len(rates), -1)
    return np.hstack([rates, products])
