"""The estimators against exact eigenvalues: rigid and averaging interfaces, consistent and lumped mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from supple.algebra import RitzModes
from supple.body import AveragingInterface, RigidInterface, flexible_body
from supple.fem import Isotropic, lumped_mass, solid_model
from supple.mesh import CellType, block
from supple.reduction import (
    CraigBamptonFamily,
    FirstOrderEstimate,
    Han2020Bound,
    KnownEigenvalues,
    SharperBound,
    TwoTermEstimate,
    error_terms,
    fixed_interface_component,
)

N = 8
INTERFACES = {
    "rigid": (RigidInterface("root", "root"),),
    "averaging": (AveragingInterface("root", "root"),),
    "two rigid": (RigidInterface("root", "root"), RigidInterface("tip", "tip")),
    "mixed": (RigidInterface("root", "root"), AveragingInterface("tip", "tip")),
}


def lumped(model):
    return replace(model, mass=sparse.csc_array(sparse.diags_array(lumped_mass(model))))


@pytest.fixture(scope="module", params=INTERFACES)
def interfaces(request):
    return INTERFACES[request.param]


@pytest.fixture(scope="module", params=["consistent", "lumped"])
def body(request, interfaces):
    model = solid_model(block(2.0, 0.5, 0.3, 8, 2, 2, CellType.TETRA4), Isotropic(1e7, 0.3, 1000.0))
    return flexible_body("block", lumped(model) if request.param == "lumped" else model, interfaces)


@pytest.fixture(scope="module")
def family(body):
    return CraigBamptonFamily(body)


@pytest.fixture(scope="module")
def exact(body, mean_axis, lowest_squares):
    return KnownEigenvalues(lowest_squares(body, mean_axis, N))


@pytest.mark.parametrize("n_kept", [40, 80])
def test_estimates_lie_where_they_should(family, exact, n_kept):
    truth = family.errors(n_kept, N, exact)
    assert 1e-7 < truth.max() < 0.02
    small = truth < 0.005
    assert small.sum() > N // 2

    def over_truth(estimator):
        return (family.errors(n_kept, N, estimator) / truth)[small]

    assert np.all(over_truth(FirstOrderEstimate()) < 1.0005)
    assert np.all(over_truth(SharperBound()) > 0.999)
    assert np.all(over_truth(Han2020Bound()) > over_truth(SharperBound()))
    assert np.median(over_truth(SharperBound())) < 1.05
    assert abs(np.median(over_truth(TwoTermEstimate())) - 1) < 0.01
    assert np.all(over_truth(TwoTermEstimate()) > over_truth(FirstOrderEstimate()))


@pytest.mark.parametrize("n_kept", [20, 40, 80])
def test_two_terms_miss_the_square_of_the_error_and_the_third_term(family, exact, n_kept):
    """zeta = chi X + chi^2 X2 + chi^3 X3 + .. + O(zeta^2), each X at most 1/kappa_(d+1) of the last."""
    truth = family.errors(n_kept, 3, exact)
    missed = np.abs(family.errors(n_kept, 3, TwoTermEstimate()) - truth)
    ratio = family.vibrations(n_kept, 3).values / family.component.eigenvalues[n_kept]
    assert np.all(missed < 3 * truth.max() ** 2 + 1.01 * ratio**2 * truth / (1 - ratio) + 1e-11)


def test_rank_one_updates_give_what_deflation_gives(body, family):
    """X and X2 with 15 of the known modes, updated from all of them, against a deflation of those alone."""
    family.vibrations(60, N)
    modes = family.modes
    few = RitzModes(modes.values[:15], modes.basis, modes.weights[:, :15])
    fresh, updated = fixed_interface_component(body, few), family.component.leading(15)
    scale = np.sqrt(np.diag(fresh.residual_flexibility))
    difference = (updated.residual_flexibility - fresh.residual_flexibility) / np.outer(scale, scale)
    assert np.abs(difference).max() < 1e-9
    scale = np.sqrt(np.diag(fresh.residual_mass))
    assert np.abs((updated.residual_mass - fresh.residual_mass) / np.outer(scale, scale)).max() < 1e-9


def test_with_all_modes_nothing_is_left_out(family, exact):
    n_kept = family.n_available
    assert family.errors(n_kept, N, SharperBound()).max() < 1e-12
    assert np.abs(family.errors(n_kept, N, exact)).max() < 1e-8


def test_missing_vibrations_have_no_finite_error(family):
    n_static = len(family.rigid_motion) - 6
    errors = family.errors(2, n_static + 4, SharperBound())
    assert np.isinf(errors).tolist() == [False] * (n_static + 2) + [True, True]


def test_terms_know_the_first_mode_left_out(family):
    vibrations = family.vibrations(10, N)
    terms = error_terms(family.component, vibrations)
    assert terms.next_fixed == family.component.eigenvalues[10]
    assert np.all(terms.first > 0)
    assert np.all(terms.second <= terms.first / terms.next_fixed * (1 + 1e-9))


def test_the_published_bound_where_there_are_more_vibrations_than_modes(mean_axis, lowest_squares):
    """Two averaging interfaces on a body of eight nodes: 18 vibrations, 12 fixed-interface modes."""
    model = solid_model(block(1.0, 0.5, 0.5, 1, 1, 1, CellType.HEXA8), Isotropic(1e7, 0.3, 1000.0))
    interfaces = (AveragingInterface("root", "root"), AveragingInterface("tip", "tip"))
    body = flexible_body("cube", model, interfaces)
    family = CraigBamptonFamily(body)
    assert (family.n_available, family.n_vibrations) == (12, 18)
    errors = family.errors(10, 16, Han2020Bound())
    terms = error_terms(family.component, family.vibrations(10, 16))
    np.testing.assert_allclose(
        errors[12:], (terms.values * (1 + terms.values / terms.fixed[11]) * terms.first)[12:]
    )
    exact = KnownEigenvalues(lowest_squares(body, mean_axis, 16))
    assert np.abs(family.errors(12, 16, Han2020Bound()) - family.errors(12, 16, exact)).max() < 1e-8
