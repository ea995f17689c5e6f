from itertools import product
from math import factorial

import numpy as np
import pytest

from supple.mesh.quadrature import (
    centroid_tetrahedron,
    conical_pyramid,
    conical_tetrahedron,
    conical_wedge,
    four_point_tetrahedron,
    gauss_cube,
    irons_cube,
    three_point_wedge,
)


def over_tetrahedron(i, j, k):
    return factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3)


def over_cube(*powers):
    return np.prod([2 / (p + 1) if p % 2 == 0 else 0 for p in powers])


def over_wedge(i, j, k):
    return factorial(i) * factorial(j) / factorial(i + j + 2) * over_cube(k)


def over_pyramid(i, j, k):
    """Over the square of half side 1 - z: int (1 - z)^(i + j + 2) z^k dz."""
    n = i + j + 2
    return over_cube(i, j) * factorial(n) * factorial(k) / factorial(n + k + 1)


@pytest.mark.parametrize(
    ("rule", "degree", "exact"),
    [
        (centroid_tetrahedron(), 1, over_tetrahedron),
        (four_point_tetrahedron(), 2, over_tetrahedron),
        (conical_tetrahedron(4), 7, over_tetrahedron),
        (conical_wedge(4), 7, over_wedge),
        (three_point_wedge(2), 2, over_wedge),
        (conical_pyramid(4), 7, over_pyramid),
        (gauss_cube(2), 3, over_cube),
        (gauss_cube(5), 9, over_cube),
        (irons_cube(), 5, over_cube),
    ],
)
def test_monomials_are_integrated_to_the_stated_degree_and_no_further(rule, degree, exact):
    def error(total):
        powers = [p for p in product(range(total + 1), repeat=3) if sum(p) == total]
        return max(abs(rule.weights @ np.prod(rule.points**p, axis=1) - exact(*p)) for p in powers)

    assert max(error(total) for total in range(degree + 1)) < 1e-14
    assert error(degree + 1) > 1e-9


def test_product_rule_is_exact_in_each_direction():
    """Degree 2n - 1 in each direction separately, so x^9 y^9 z^8 by five points."""
    rule = gauss_cube(5)
    assert rule.weights @ np.prod(rule.points ** [8, 8, 8], axis=1) == pytest.approx((2 / 9) ** 3, rel=1e-12)
