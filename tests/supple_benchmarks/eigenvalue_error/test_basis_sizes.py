"""Sizes of bases for the same exact eigenvalue errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import MeanAxisFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, block
from supple.reduction import CraigBampton, CraigBamptonResidual, Herting, NoDerivatives, NoLoads, reduce
from supple_benchmarks.eigenvalue_error.basis_sizes import basis_sizes

N_VALUES = 6
TOLERANCES = (0.1, 0.01, 0.001)


@pytest.fixture(scope="module")
def body():
    model = solid_model(block(2.0, 0.5, 0.3, 5, 2, 2, CellType.TETRA4), Isotropic(1e7, 0.3, 1000.0))
    return flexible_body("block", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


@pytest.fixture(scope="module")
def sizes(body):
    found = basis_sizes(body, TOLERANCES, N_VALUES, candidates=60)
    return {(size.interfaces, size.basis, size.tolerance): size for size in found}


@pytest.mark.parametrize(
    ("basis", "recipe"),
    [
        ("Craig-Bampton", CraigBampton),
        pytest.param("Craig-Bampton with residual modes", CraigBamptonResidual, marks=pytest.mark.slow),
    ],
)
def test_size_is_the_smallest_that_meets_the_tolerance(body, sizes, basis, recipe):
    """Against the free body's exact eigenvalues, with bodies reduced from scratch."""
    frame = MeanAxisFrame()
    exact = lowest_modes(body.stiffness, body.mass, N_VALUES, constraint=frame.constraint(body)).values
    for tolerance in TOLERANCES:
        size = sizes["free", basis, tolerance]
        for n_modes, met in ((size.modes, True), (max(size.modes - 1, 0), size.modes == 0)):
            reduced = reduce(body, frame, recipe(n_modes=n_modes), derivatives=NoDerivatives(), loads=NoLoads)
            worst = np.max(reduced.frequencies[:N_VALUES] ** 2 / exact - 1.0)
            assert (worst <= tolerance) == met
            if met:
                np.testing.assert_allclose(size.largest_error, worst, rtol=1e-5)
                assert size.coordinates == reduced.r + 6


def test_coordinates_of_herting_are_those_of_the_reduced_body(body, sizes):
    size = sizes["held", "Herting", 0.01]
    reduced = reduce(
        body, MeanAxisFrame(), Herting(n_modes=size.modes), derivatives=NoDerivatives(), loads=NoLoads
    )
    assert size.coordinates == reduced.r + 6


def test_each_family_is_exact_with_its_own_interfaces(sizes):
    for basis in ("Rubin", "Herting", "MacNeal", "dual Craig-Bampton"):
        assert sizes["free", basis, 0.001].modes == N_VALUES
    assert sizes["held", "Craig-Bampton", 0.001].modes == N_VALUES


def test_known_order_of_the_methods(sizes):
    """Residual modes spare vibrations; the residual mass that MacNeal leaves out costs some."""
    for interfaces in ("free", "loaded"):
        plain = sizes[interfaces, "Craig-Bampton", 0.001].modes
        assert sizes[interfaces, "Craig-Bampton with residual modes", 0.001].modes < plain
    for interfaces in ("held", "loaded"):
        rubin = sizes[interfaces, "Rubin", 0.01].modes
        assert rubin <= sizes[interfaces, "dual Craig-Bampton", 0.01].modes
        assert rubin < sizes[interfaces, "MacNeal", 0.01].modes


def test_looser_tolerance_never_needs_more(sizes):
    for interfaces, basis, _ in sizes:
        modes = [sizes[interfaces, basis, tolerance].modes for tolerance in TOLERANCES]
        reached = [count for count in modes if count is not None]
        assert reached == sorted(reached)
        assert modes == reached + [None] * (len(modes) - len(reached))


def test_tolerance_out_of_reach_has_no_size(body):
    row = next(
        size.as_row()
        for size in basis_sizes(body, (1e-9,), N_VALUES, candidates=20)
        if (size.basis, size.interfaces) == ("Craig-Bampton", "free")
    )
    assert row["size"] is None
    assert row["coordinates"] is None
    assert row["max_error"] > row["e"] == 1e-9


def test_body_without_interfaces_is_refused(body):
    with pytest.raises(ModelError, match="a comparison of bases needs interfaces, but body 'block' has none"):
        basis_sizes(replace(body, interfaces=()), (0.1,), 2)


def test_too_few_candidates_are_refused(body):
    with pytest.raises(ModelError, match=r"body 'block': 500 modes to compare among \d+ candidates"):
        basis_sizes(body, (0.1,), 500)
