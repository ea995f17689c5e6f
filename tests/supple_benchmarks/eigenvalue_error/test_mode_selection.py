"""Selection rules compared on one body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import MeanAxisFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, box_beam
from supple.reduction import (
    CraigBampton,
    NoDerivatives,
    NoLoads,
    fixed_interface_component,
    fixed_interface_modes,
    reduce,
)
from supple.reduction.bases.interface_columns import motion_rows
from supple_benchmarks.eigenvalue_error.mode_selection import compare_selections, draw_transfer_errors


@pytest.fixture(scope="module")
def block_body():
    model = solid_model(block(2.0, 0.5, 0.3, 5, 2, 2, CellType.TETRA4), Isotropic(1e7, 0.3, 1000.0))
    return flexible_body("block", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def test_transfer_error_is_that_of_the_reduced_body_against_a_direct_solution(block_body):
    """H = B ((1 + i eta) K - omega^2 M)^-1 B^T, dense, in units of the interface mass."""
    body, n_modes, eta = block_body, 15, 0.02
    (quality,) = (
        q
        for q in compare_selections(
            body, (n_modes,), n_vibrations=6, candidates=60, loss_factor=eta, n_frequencies=30
        )
        if q.selection == "lowest frequency"
    )
    exact = lowest_modes(body.stiffness, body.mass, 6, constraint=MeanAxisFrame().constraint(body)).values
    component = fixed_interface_component(body, fixed_interface_modes(body, n_modes))
    triangle, B = np.linalg.cholesky(component.interface_mass), motion_rows(body.interfaces)
    K_b, M_b = component.interface_stiffness, component.interface_mass
    relative = []
    for omega in np.geomspace(np.sqrt(exact[0]) / 3.0, np.sqrt(exact[-1]), 30):
        direct = (1 + 1j * eta) * body.stiffness.toarray() - omega**2 * body.mass.toarray()
        full = B @ np.linalg.solve(direct, B.T)
        kappa = (1 + 1j * eta) * component.eigenvalues - omega**2
        P = component.participation
        dynamic = (1 + 1j * eta) * K_b - omega**2 * M_b - omega**4 * (P.T / kappa) @ P
        difference = triangle.T @ (np.linalg.inv(dynamic) - full) @ triangle
        relative.append(np.linalg.norm(difference) / np.linalg.norm(triangle.T @ full @ triangle))
    np.testing.assert_allclose(quality.transfer_error, np.sqrt(np.mean(np.square(relative))), rtol=1e-4)


def test_eigenvalue_error_is_that_of_the_reduced_body(block_body):
    """Every vibration of this block shows at its ends, so none is left out."""
    frame = MeanAxisFrame()
    constraint = frame.constraint(block_body)
    exact = lowest_modes(block_body.stiffness, block_body.mass, 6, constraint=constraint).values
    reduced = reduce(block_body, frame, CraigBampton(n_modes=15), derivatives=NoDerivatives(), loads=NoLoads)
    quality = compare_selections(block_body, (15,), n_vibrations=6, candidates=60)[0]
    assert quality.selection == "lowest frequency"
    np.testing.assert_allclose(
        quality.eigenvalue_error, np.max(reduced.frequencies[:6] ** 2 / exact - 1.0), rtol=1e-5
    )


@pytest.mark.slow
def test_panels_of_a_thin_box_make_interface_aware_rules_pay(tmp_path):
    wall = HomogeneousSection(Isotropic(70e9, 0.33, 2700.0), 0.001)
    model = shell_model(box_beam(1.0, 0.1, 0.06, 16, 4, 4), wall)
    body = flexible_body("box", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))
    qualities = compare_selections(body, (40, 60), candidates=120, n_frequencies=100)
    errors = {(q.selection, q.size): q.transfer_error for q in qualities}
    for size in (40, 60):
        assert errors["coupling moment", size] < 0.8 * errors["lowest frequency", size]
    assert errors["lowest frequency, residual modes", 60] < 0.1 * errors["coupling moment", 60]
    assert draw_transfer_errors(tmp_path / "selection.png", qualities).stat().st_size > 0


def test_rows_have_no_infinite_numbers(block_body):
    rows = [q.as_row() for q in compare_selections(block_body, (0, 12), n_vibrations=8, candidates=40)]
    assert rows[0] == {"selection": "lowest frequency", "size": 0} | {
        "transfer_error": rows[0]["transfer_error"],
        "eigenvalue_error": None,
    }
    # Residual modes take twelve places, so that rule begins at twelve.
    assert [row["size"] for row in rows] == [0, 12] * 3 + [12]


def test_body_without_interfaces_is_refused(block_body):
    with pytest.raises(
        ModelError, match="a comparison of mode selections needs interfaces, but body 'block'"
    ):
        compare_selections(replace(block_body, interfaces=()), (10,))


def test_sizes_beyond_the_candidates_are_refused(block_body):
    with pytest.raises(ModelError, match=r"sizes \[10, 80\] for 60 candidates"):
        compare_selections(block_body, (10, 80), candidates=60)


def test_more_vibrations_than_the_body_shows_are_refused(block_body):
    with pytest.raises(ModelError, match=r"only \d+ vibrations of body 'block' show at its interfaces"):
        compare_selections(block_body, (10,), n_vibrations=400, candidates=60)
