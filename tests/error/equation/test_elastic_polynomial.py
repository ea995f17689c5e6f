"""The polynomial of a body's elasticity in few columns, against its elements."""

from __future__ import annotations

import numpy as np
import pytest
from error.equation.machines import soft_strip

from supple.error.equation.elastic_polynomial import ElasticPolynomial, works_on_themselves
from supple.error.equation.products_of_run import monomials, rate_monomials
from supple.reduction.tensors import strain_products

N_MOTION = 3


@pytest.fixture(scope="module")
def strip():
    """The body, five columns, their polynomial, and coordinates and rates at two instants."""
    body = soft_strip("strip", 1.0)
    rng = np.random.default_rng(4)
    Z = rng.normal(size=(body.n, 5)) * 0.02
    polynomial = ElasticPolynomial(works_on_themselves(strain_products(body, Z)), N_MOTION)
    return body, Z, polynomial, rng.normal(size=(2, N_MOTION)), rng.normal(size=(2, N_MOTION))


def test_works_are_those_of_the_assembly(strip):
    body, Z, polynomial, *_ = strip
    for found, wanted in zip(polynomial.works, body.assembly.works(Z, Z), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-12 * abs(wanted).max())


def test_forces_are_those_of_the_elements(strip):
    body, Z, polynomial, g, rates = strip
    for row in range(2):
        q, rate = Z[:, :N_MOTION] @ g[row], Z[:, :N_MOTION] @ rates[row]
        wanted = Z.T @ (body.assembly.internal_force(q) - body.stiffness @ q)
        np.testing.assert_allclose(polynomial.force(g)[row], wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max())
        of_strains, _ = body.assembly.tangent_parts(q)
        wanted = Z.T @ (of_strains @ rate - body.stiffness @ rate)
        found = polynomial.strain_rate_force(g, rates)[row]
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * abs(wanted).max())


def test_tangents_are_those_of_the_elements(strip):
    body, Z, polynomial, g, rates = strip
    whole, material = (np.tensordot(monomials(g), own, axes=1) for own in polynomial.tangents)
    of_rates = np.tensordot(rate_monomials(g, rates), polynomial.rate_tangents, axes=1)
    for row in range(2):
        q, rate = Z[:, :N_MOTION] @ g[row], Z[:, :N_MOTION] @ rates[row]
        of_strains, of_stress = body.assembly.tangent_parts(q)
        at_rest = Z.T @ (body.stiffness @ Z)
        for found, wanted in (
            (whole[row], Z.T @ ((of_strains + of_stress) @ Z) - at_rest),
            (material[row], Z.T @ (of_strains @ Z) - at_rest),
            (of_rates[row], Z.T @ (body.assembly.strain_rate_tangent(q, rate) @ Z)),
        ):
            np.testing.assert_allclose(found, wanted, atol=1e-9 * abs(wanted).max())
